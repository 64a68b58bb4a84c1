"""Answers are those of the tools, and their tables are the library's own memory."""
import csv
import io
import json
import math
import os
import re
import subprocess
import sys
import threading
import warnings
import zipfile
from pathlib import Path

import numpy
import pytest

import kmech
from kmech import ffi, lib


def test_the_version_is_the_projects():
    assert kmech.__version__ == os.environ["KMECH_VERSION"]


def test_every_kind_of_question_is_a_method(brake):
    assert kmech.kinds() == ["mobility", "advantage", "forces", "track", "run", "inverse", "motion",
                             "allowance", "clearance", "modes", "map", "turning", "volume"]
    for kind in kmech.kinds()[:3]:
        answer = getattr(brake, kind)(range=(20, 32), steps=4)
        assert len(answer) == 5 and answer.complete
        assert kind in getattr(kmech.Model, kind).__doc__
        assert "range" in str(__import__("inspect").signature(getattr(kmech.Mechanism, kind)))


def test_a_track_is_a_question(iiwa, source):
    answer = iiwa.track(study=source / "studies/iiwa_weld/study.json", method="dls")
    assert answer.complete and len(answer) == 161 and answer.events == []
    assert answer.figure("limit_margin", "min")[0] > 0 and "<svg" in answer._repr_svg_()
    with pytest.raises(kmech.KmechError, match="`study` is missing"):
        iiwa.track()
    with pytest.raises(kmech.KmechError, match="gone.json"):
        iiwa.track(study="gone.json")
    with pytest.raises(TypeError):
        iiwa.track(study=3)


def test_rows_are_those_of_the_c_library(brake, tmp_path):
    answer = brake.sweep("K", 20, 32, 7)
    answer.save_csv(tmp_path / "a.csv")
    rows = list(csv.reader(io.StringIO((tmp_path / "a.csv").read_text())))
    for row, line in zip(answer.table, rows[1:]):
        assert [float(x) for x in line] == pytest.approx([float(v) for v in row], rel=0, abs=0, nan_ok=True)
    assert len(rows) == 9


def test_workbooks_hold_every_number(brake, tmp_path):
    answer = brake.sweep("K", 20, 32, 7)
    answer.save_xlsx(tmp_path / "a.xlsx", sheet="stroke")
    with zipfile.ZipFile(tmp_path / "a.xlsx") as book:
        assert b'name="stroke"' in book.read("xl/workbook.xml")
        cells = re.findall(rb'<c r="[A-Z]+[0-9]+"><v>([^<]+)</v>', book.read("xl/worksheets/sheet1.xml"))
    numbers = [float(v) for row in answer.table for v in row if numpy.isfinite(v)]
    assert [float(c) for c in cells] == pytest.approx(numbers, rel=5e-16 + 2.0**-53, abs=0)


def test_tables_are_views(brake):
    answer = brake.sweep("K", 20, 32, 50)
    table = answer.table
    pointer = lib.km_table_row(lib.km_question_table(answer._c), 0)
    assert table.__array_interface__["data"][0] == int(ffi.cast("intptr_t", pointer))
    assert table["q.K"].base is not None and table.matrix().shape == (51, len(table.columns))
    assert table.units["q.K"] == "mm" and not table.flags.writeable
    column, matrix, plain = table["q.K"], table.matrix(), numpy.asarray(table)["q.K"]
    kept = matrix.copy()
    del answer, table
    __import__("gc").collect()
    others = [brake.sweep("K", 20, 32, 50).table for _ in range(20)]  # would take the memory if it were free
    assert len(others) == 20 and numpy.array_equal(matrix, kept, equal_nan=True)
    assert column[0] == plain[0] == pytest.approx(20.0) and column[-1] == pytest.approx(32.0)


def test_events_figures_pictures(brake, tmp_path):
    answer = brake.advantage(range=(20, 32), steps=50)
    least, where = answer.figure(answer.table.columns[-4], "min")
    assert least <= answer.table[answer.table.columns[-4]].min() + 1e-12 and 20 <= where <= 32
    assert answer.plot().save(tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    assert answer.plot().data("png").startswith(b"\x89PNG")
    assert answer._repr_svg_() == answer.plot()._repr_svg_() and "<svg" in answer._repr_svg_()
    assert answer.table._repr_html_().startswith("<table>")
    assert all(isinstance(e.s, float) for e in answer.events)


def test_slider_crank_by_formula():
    """x = cos q + √(l² − sin² q): the slider of a crank of length 1 and a rod of length 3."""
    b = kmech.Builder()
    b.body("crank").body("rod").body("slider")
    b.frame("crank", "tip", [1, 0, 0]).frame("rod", "tip", [3, 0, 0])
    b.joint("A", "Rz", "fixed", "crank").joint("B", "Rz", "crank/tip", "rod").joint("C", "Rz", "rod/tip", "slider")
    b.joint("D", "Tx", "fixed", "slider", position=4)
    model = b.finish()
    table = model.sweep("A", 0.1, 3.0, 40).table
    q = table["q.A"]
    assert numpy.abs(table["q.D"] - (numpy.cos(q) + numpy.sqrt(9 - numpy.sin(q) ** 2))).max() < 1e-11
    state = model.mechanism(set={"A": 1.0}).state
    assert state.mobility().mobility == 1 and state["A"] == pytest.approx(1.0, abs=1e-12)
    assert state.frame("crank/tip").p == pytest.approx([math.cos(1), math.sin(1), 0], abs=1e-12)
    assert state.jacobian("crank/tip")[:, 0] == pytest.approx([-math.sin(1), math.cos(1), 0, 0, 0, 1], abs=1e-12)
    again = kmech.from_string(model.to_json(state))
    assert again.mechanism().state["D"] == pytest.approx(state["D"], abs=1e-12)


def test_hinges_have_transmission_angles(fourbar):
    """The one of coupler and rocker is the four-bar's, or its supplement."""
    answer = fourbar.advantage(input="A", output="D", transmission=True, steps=36)
    angle = answer["transmission_angle"]
    assert answer["transmission.C"] == pytest.approx(numpy.minimum(angle, math.pi - angle), abs=1e-9)
    assert answer["transmission.B"] + answer["pressure.B"] == pytest.approx(math.pi / 2, abs=1e-12)
    assert answer.figure("transmission.C", "min")[0] <= answer["transmission.C"].min() + 1e-12


def test_models_change(fourbar):
    mechanism = fourbar.mechanism()
    before = mechanism.state.mobility().numbers
    frame = next(f for f in fourbar.frames if not f.endswith("origin") and not f.startswith("fixed"))
    place = mechanism.state.frame(frame)
    assert place.R.shape == (3, 3)
    fourbar.set_frame(frame, [0.9, 0.01, 0.0])
    with pytest.raises(kmech.UsageError, match="has changed"):
        mechanism.state.mobility()
    mechanism.renumber()
    assert mechanism.state.mobility().numbers != before
    low, high = fourbar.limits(fourbar.coordinates[0])
    fourbar.set_limits(fourbar.coordinates[0], -1, 1)
    assert fourbar.limits(fourbar.coordinates[0]) == (-1, 1)


def test_variants():
    text = """{"parameters": {"reach": 2}, "assemblies": [{"name": "a", "bodies": [{"name": "b", "frames": [{"name": "t",
      "T": ["reach", 0, 0]}]}], "joints": [{"name": "J", "type": "Rz", "body_frame_pairs": ["fixed", "b"]}]}]}"""
    model = kmech.from_string(text)
    assert model.mechanism().state.frame("b/t").p[0] == 2
    assert model.vary(reach=5).mechanism().state.frame("b/t").p[0] == 5
    assert model.vary(reach=5).vary(**{"J.initial_displacement": math.pi}).mechanism().state.frame("b/t").p[0] == -5


def test_robot_descriptions(tmp_path):
    text = ("<robot name='r'><link name='a'/><link name='b'/><joint name='J' type='revolute'><parent link='a'/>"
            "<child link='b'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='3' velocity='2'/></joint></robot>")
    (tmp_path / "r.urdf").write_text(text)
    model = kmech.load(tmp_path / "r.urdf")
    assert model.limits("J") == (-1, 1) and model.name == "r"
    assert len(kmech.load(tmp_path / "r.urdf", floating=True).coordinates) == 7
    assert '"max_force": 3' in model.to_json()


def test_closure_tolerance_on_loading(iiwa, tmp_path):
    notes = iiwa.save(tmp_path / "arm.json")
    assert notes is not None
    assert "closure_tolerance" not in kmech.load(tmp_path / "arm.json").to_json()
    model = kmech.load(tmp_path / "arm.json", closure_tolerance=2e-5)
    assert '"closure_tolerance": 2e-05' in model.to_json()
    assert '"closure_tolerance": 2e-05' in model.vary(**{"model_parameters.gravity.2": -1}).to_json()
    with pytest.raises(kmech.UsageError, match="closure_tolerance: found 2"):
        kmech.load(tmp_path / "arm.json", closure_tolerance=2)


@pytest.mark.parametrize("ending", ["json", "urdf", "xml", "sdf"])
def test_models_go_out_and_come_back(ending, iiwa, tmp_path):
    notes = iiwa.save(tmp_path / f"arm.{ending}")
    assert all(n.severity == "note" for n in notes)
    again = kmech.load(tmp_path / f"arm.{ending}")
    q = {label: 0.1 * k for k, label in enumerate(iiwa.coordinates)}
    one, two = iiwa.mechanism(set=q), again.mechanism(set=q)
    for body in iiwa.bodies[1:]:
        assert two.state.frame(f"{body}/origin").p == pytest.approx(one.state.frame(f"{body}/origin").p, abs=1e-12)


def test_a_model_in_another_folder_finds_its_meshes(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "in" / "t.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (tmp_path / "in" / "m.json").write_text(
        '{"assemblies": [{"name": "a", "bodies": [{"name": "b", "definition": ["t.obj"], "density": 6}],'
        ' "joints": [{"name": "J", "type": "Rx", "body_frame_pairs": ["fixed", "b"]}]}]}')
    kmech.load(tmp_path / "in" / "m.json").save(tmp_path / "out" / "m.json")
    again = kmech.load(tmp_path / "out" / "m.json")
    assert "../in/t.obj" in again.to_json() and not again.messages


def test_arms(iiwa):
    arm = iiwa.mechanism().arm("flange/tool")
    q = [0.1, 0.5, -0.2, -1.2, 0.3, 0.7, 0.0]
    pose = arm.place(q)
    found = arm.solve(pose, [x + 0.05 for x in q])
    assert arm.place(found).p == pytest.approx(pose.p, abs=1e-10)
    J, h = arm.jacobian(q), 1e-6
    for k in range(7):
        moved = [list(q), list(q)]
        moved[0][k] -= h
        moved[1][k] += h
        rate = (arm.place(moved[1]).p - arm.place(moved[0]).p) / (2 * h)
        assert J[:3, k] == pytest.approx(rate, abs=1e-8)


def test_path_studies(source):
    study = kmech.load_study(source / "studies/thesis_line/study.json")
    track = study.track(0)
    assert track.complete == track.summary.complete and track.summary.error_position < 1e-11
    assert "s" in track.table.columns and "<svg" in track._repr_svg_()


def test_effort_and_energy_of_a_track(source):
    text = """{"effector": "flange/tool", "path": {"segments": [{"type": "line", "to": [-0.19, 0.25, 0.46], "steps": 48}]},
               "methods": ["dp"], "objective": "%s"}"""
    model = kmech.load(source / "models/panda.json")
    effort, energy = [kmech.arm.Study(text % word, model=model).track(0) for word in ("effort", "energy")]
    assert effort.summary.effort < energy.summary.effort and energy.summary.energy < effort.summary.energy
    assert energy.summary.positive_work <= energy.summary.energy and 0 < energy.summary.relative_effort < 7
    table = energy.table
    dt, power = numpy.diff(table["t"]), table["power"][1:]
    assert energy.summary.energy == pytest.approx(float(dt @ power), rel=1e-12) == table["energy"][-1]


def test_progress_and_cancel(brake):
    seen = []
    brake.sweep("K", 20, 32, 20000, progress=lambda done: seen.append(done))
    assert seen == sorted(seen) and all(0 <= d <= 1 for d in seen)
    with pytest.raises(kmech.Cancelled):
        brake.sweep("K", 20, 32, 200000, progress=lambda done: False)
    with pytest.raises(KeyError):
        brake.sweep("K", 20, 32, 200000, progress=lambda done: {}["nothing"])


def test_keyboard_interrupt():
    program = ("import kmech, os, signal, sys, threading\n"
               f"m = kmech.load({str(Path(__file__).resolve().parents[3] / 'models/brake.json')!r})\n"
               "threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
               "try:\n  m.sweep('K', 20, 32, 9000000)\n"
               "except KeyboardInterrupt:\n  print('stopped')\n")
    done = subprocess.run([__import__("sys").executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.stdout == "stopped\n", done.stderr


def test_threads_work_side_by_side(brake):
    reference = brake.sweep("K", 20, 32, 300).table.matrix().copy()
    mechanism, results = brake.mechanism(), {}

    def work(i):
        results[i] = mechanism.sweep("K", 20, 32, 300).table.matrix()

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i in range(4):
        assert numpy.array_equal(results[i], reference, equal_nan=True)


def test_the_gil_is_released(brake):
    """Another thread counts while the library works: with so long a turn it gets none otherwise."""
    count, stop, interval = [0], threading.Event(), sys.getswitchinterval()

    def spin():
        while not stop.is_set():
            count[0] += 1

    mechanism, thread = brake.mechanism(), threading.Thread(target=spin)
    sys.setswitchinterval(0.2)
    try:
        thread.start()
        before = count[0]
        for _ in range(100):  # a busy machine may not have given it a processor yet
            mechanism.sweep("K", 20, 32, 20000)
            moved = count[0] - before
            if moved > 1000:
                break
    finally:
        stop.set()
        thread.join()
        sys.setswitchinterval(interval)
    assert moved > 1000


def test_warnings_of_readers():
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        model = kmech.from_string('{"assemblis": []}')
    assert found[0].category is kmech.ModelWarning and "assemblies" in str(found[0].message)
    assert model.messages[0].severity == "warning"


def test_named_poses():
    model = kmech.from_string('{"poses": {"home": {"J": 1}}, "assemblies": [{"name": "a", "bodies": [{"name": "b"}], '
                              '"joints": [{"name": "J", "type": "Rz", "body_frame_pairs": ["fixed", "b"]}]}]}')
    assert model.poses == ["home"]


def test_couplings_by_calls():
    b = kmech.Builder()
    b.body("x").body("y").joint("A", "Rz", "fixed", "x").joint("B", "Rz", "fixed", "y")
    b.couple("cam", follower="A", leader="B", polynomial=[0.5, 0, 2])
    table = b.finish().sweep("B", -1, 1, 10).table
    assert table["q.A"] == pytest.approx(0.5 + 2 * table["q.B"] ** 2, abs=1e-12)


def test_documentation():
    assert "closes every loop" in kmech.documentation("km_assemble").lower()
    assert "km_assemble" in kmech.State.assemble.__doc__


def test_parts_of_tables(fourbar):
    table = fourbar.sweep("A", 60, 70, 10).table
    some = table[["q.B", "q.C"]]
    assert some.columns == ("q.B", "q.C")
    assert some.matrix().shape == (11, 2) and (some.matrix()[:, 1] == table["q.C"]).all()
    assert (table[::-2].matrix()[:, table.columns.index("q.B")] == table["q.B"][::-2]).all()
    assert type(table["q.B"]) is numpy.ndarray and float(table["q.B"].min()) <= float(table["q.B"].max())
    assert numpy.shares_memory(table.matrix(), table)


def test_arms_and_studies_of_a_model_that_has_changed(source):
    model = kmech.load(source / "models/panda.json")
    mechanism = model.mechanism()
    arm = mechanism.arm("flange/tool")
    study = kmech.Study('{"effector": "flange/tool", "path": {"segments": [{"type": "line", "to": [0.4, 0, 0.5], "steps": 5}]}}',
                        model=model)
    q = [0, -0.7, 0, -2.3, 0, 1.5, 0.7]
    before = arm.place(q).p
    model.set_frame("flange/tool", [0, 0, 1.0])
    for stale in (lambda: arm.place(q), lambda: arm.jacobian(q), lambda: study.track(0)):
        with pytest.raises(kmech.UsageError, match="the model has changed"):
            stale()
    assert model.mechanism().arm("flange/tool").place(q).p != pytest.approx(before)


def test_turning(source):
    mechanism = kmech.Mechanism(kmech.load(source / "models/fourbar.json"))
    found = mechanism.turning("A", "crank.end.x", 0.05, 0.6)
    assert [point.number for point in found.points] == pytest.approx([0.35, 0.45, 0.55], abs=1e-9)
    assert {point.kind for point in found.points} == {"crossing"} and found.complete
    assert [interval.turns for interval in found.intervals] == [True, False, True, False]
    assert set(found.curves["critical"]) == {0.0, 1.0}
    with pytest.raises(kmech.UsageError, match="no file"):
        kmech.Mechanism(kmech.from_string((source / "models/fourbar.json").read_text())).turning("A", "crank.end.x", 0.05, 0.6)


def test_spaces(source):
    """Questions about spaces: as many rows as modes, or as grid points; a five-bar's sheet doesn't come everywhere."""
    modes = kmech.load(source / "models/fourbar.json").modes()
    assert list(modes["mode"]) == [1, 2] and list(modes["circuit"]) == [1, 2] and modes.complete
    crank = kmech.load(source / "models/fourbar.json").turning()
    reach = kmech.load(source / "models/five_bar.json").volume(point=["rod1/P"], samples=2000)
    lens = 4.5 * math.acos(1 / 3) - math.sqrt(2) - 2 * math.pi * 0.09  # test_maps_over_two_drivers
    assert reach["low"][0] < lens < reach["high"][0] and abs(reach["area"][0] - lens) < 4 * reach["standard_error"][0] + 0.01
    with pytest.raises(kmech.UsageError, match="point"):
        kmech.load(source / "models/five_bar.json").volume()
    assert len(crank) == 1 and crank["turns"][0] == 1 and crank["range"][0] == pytest.approx(2 * math.pi) and crank["dead_points"][0] == 0
    found = kmech.load(source / "models/five_bar.json").map(steps=20, first_range=(-2, 2), second_range=(-2, 2))
    reached = found["reached"] == 1
    assert len(reached) == 441 and 0.5 < reached.mean() < 1
    assert found["sigma.input"][~reached].max() == 0 and found["sigma.input"][reached].min() > 0
    with pytest.raises(kmech.UsageError, match="two drivers"):
        kmech.load(source / "models/five_bar.json").map(joints=["A"])
    uneven = kmech.load(source / "models/five_bar.json").map(steps=4, second_steps=6, first_range=(-1, 1), second_range=(-1, 1))
    assert len(uneven) == 35 and sorted(set(uneven["q.E"])) == pytest.approx([-1, -2 / 3, -1 / 3, 0, 1 / 3, 2 / 3, 1])


def five_bar_beside_post(source):
    """A five-bar whose cranks have limits, and whose point must not touch a post."""
    text = (source / "models/five_bar.json").read_text()
    for old, new in (
            ('{"name": "crank1"}', '{"name": "post", "shapes": [{"sphere": 0.08, "T": [0.5, 1.1, 0]}]}, {"name": "crank1"}'),
            ('{"name": "rod1", ', '{"name": "rod1", "shapes": [{"sphere": 0.05, "T": [0.5, 1.3483314773547883, 0]}], '),
            ('"joints": [', '"joints": [{"name": "F", "type": "rigid", "body_frame_pairs": ["fixed", "post"]},'),
            ('"bodies": ["fixed", "crank2"]', '"limits": [-0.5, 0.5], "bodies": ["fixed", "crank2"]')):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return kmech.from_string(text)


def test_limits_clearance_and_figures_of_maps(source):
    """Python's map and the question of kstudy leave out the same cells: those beyond limits, or with bodies too near."""
    model = five_bar_beside_post(source)
    over = {"A": (-1, 1, 21), "E": (-1, 1, 21)}
    plain = model.mechanism().space_map(over, ask="clearance", own=True)
    found = model.mechanism().space_map(over, ask="clearance", own=True, limits=True, clearance=0.02)
    cells = plain.cells
    kept = (abs(cells["q.E"]) <= 0.5 + 1e-12) & (cells["clearance"] >= 0.02)
    assert 0 < kept.sum() < len(cells) and len(found.cells) == kept.sum()
    assert found.cells["clearance"] == pytest.approx(cells["clearance"][kept])
    assert {2, 3} <= set(found.curves["kind"])
    asked = model.map(first_range=(-1, 1), second_range=(-1, 1), steps=20, ask="clearance", limits=True, clearance=0.02)
    reached = asked["reached"] == 1
    assert reached.sum() == kept.sum() and sorted(asked["clearance"][reached]) == pytest.approx(sorted(found.cells["clearance"]))
    left_out = set(zip(cells["q.A"][~kept].round(9), cells["q.E"][~kept].round(9)))
    for a, e, sigma in zip(asked["q.A"][~reached].round(9), asked["q.E"][~reached].round(9), asked["sigma.input"][~reached]):
        assert numpy.isnan(sigma) if (a, e) in left_out or abs(e) > 0.5 else sigma == 0  # left out, or singular
    forces = model.mechanism().space_map(over, ask="forces", own=True).cells
    assert {"f.A", "f.E"} <= set(forces.columns)
    with pytest.raises(kmech.UsageError, match="expected one of mobility"):
        model.mechanism().space_map(over, ask="speed")
    with pytest.raises(kmech.UsageError, match="no analysis.mechanical_advantage"):
        model.mechanism().space_map(over, ask="advantage")
    with pytest.raises(kmech.UsageError, match="no clearance to compute"):
        kmech.load(source / "models/five_bar.json").map(clearance=0.1)


def test_space_path(source):
    mechanism = kmech.Mechanism(kmech.load(source / "models/five_bar.json"))
    path = mechanism.space_path({"A": 2.9, "E": -2.9})
    assert path.outcome == "found" and not path.straight and path.least_margin >= 0.02
    assert math.cos(path.table["q.A"][-1] - 2.9) == pytest.approx(1.0) and min(path.table["sigma.input"]) == pytest.approx(path.least_margin)
    assert path.smooth and path.motion["t"][-1] == 1.0 and path.motion["q.A"][-1] == pytest.approx(path.table["q.A"][-1])
    assert mechanism.space_path({"A": 1.57, "E": -1.57}).outcome == "end"
    limited = kmech.load(source / "models/five_bar.json")
    limited.set_limits("A", -0.5, 3.1)
    limited.set_limits("E", -3.1, 0.5)
    stopped = kmech.Mechanism(limited).space_path({"A": 2.9, "E": -2.9}, margin=0.1, progress=lambda done: False)
    assert stopped.outcome == "stopped" and len(stopped.explored["tree"]) == stopped.configurations
    assert list(mechanism.space_path({"A": 0.0, "E": 0.0}).motion["q.A"]) == pytest.approx([0.0, 0.0])
    with pytest.raises(kmech.UsageError, match="as many drivers as freedoms"):
        mechanism.space_path({"A": 1.0})


def test_space_volume(source):
    mechanism = kmech.Mechanism(kmech.load(source / "models/five_bar.json"))
    area = mechanism.space_volume("rod1/P", samples=1000, jobs=2)
    assert area.dimension == 2 and area.complete and area.low < 3.559617 < area.high
    assert area.reached == list(area.table["reached"]).count(1.0) and len(area.table["reached"]) == area.samples
    assert area.axes == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) and area.box[0] == pytest.approx((-0.51, 1.51), abs=1e-4)
    assert area.picture.data("svg").startswith(b"<?xml") and area.picture.data("pdf").startswith(b"%PDF")
    with pytest.raises(kmech.UsageError, match="1 freedom;"):
        mechanism.space_volume("crank2/D", samples=100)
    with pytest.raises(kmech.UsageError, match="no clearance to compute"):
        mechanism.space_volume("rod1/P", samples=100, clearance=0.1)


def test_all_assembly_modes(source):
    mechanism = kmech.Mechanism(kmech.load(source / "models/fourbar.json"))
    modes = mechanism.all_modes(["A"])
    assert modes.complete and modes.reason == "complete" and modes.complex_solutions == 2
    assert modes.coordinates.shape == modes.mobility_numbers.shape == (2, 4)
    assert modes.circuit.tolist() == [1, 2] and modes.circuits == 2 and modes.circuits_reason == "none"
    assert modes.certified.all() and (modes.error_bound < modes.radius).all() and not modes.moves.any()
    with pytest.raises(kmech.UsageError, match="can still move"):
        mechanism.all_modes()
    with pytest.raises(kmech.Cancelled):
        mechanism.all_modes(["A"], progress=lambda done: False)


def test_maps_over_two_drivers(source):
    mechanism = kmech.Mechanism(kmech.load(source / "models/five_bar.json"))
    found = mechanism.space_map({"A": (-2, 2, 21), "E": (-2, 2, 21)})
    assert found.complete and found.sheet_count == 2 and found.curve_count >= 1
    ends = [(0.6 * numpy.cos(found.curves[c] + numpy.pi / 2), 0.6 * numpy.sin(found.curves[c] + numpy.pi / 2)) for c in ("q.A", "q.E")]
    apart = numpy.hypot(1 + ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])
    assert numpy.minimum(abs(apart - 1.8), apart).max() < 1e-9  # the rods are in line, stretched or folded
    assert abs(sum(found.cells["m." + c] for c in "ABCDE") - 2).max() < 1e-12
    assert found.workspace is None
    turn = (-numpy.pi, numpy.pi, 31)
    workspace = mechanism.space_map({"A": turn, "E": turn}, point="rod1/P").workspace
    lens = 4.5 * numpy.arccos(1 / 3) - numpy.sqrt(2)  # of the circles of both legs, radius 1.5, but for two of radius 0.3
    assert abs(workspace.area - lens + 2 * numpy.pi * 0.09) < 1e-8
    assert (workspace.holes, workspace.gap, workspace.outside) == (2, 0, 0)
    assert max(at.radius for at in workspace.aspects) > 0.59 and workspace.sphere is None
    wrist = kmech.load(source / "models/wrist.json").mechanism().space_map({"A": turn, "E": turn}, point="rod1/P").workspace
    assert abs(wrist.area - 0.0798706241356) < 1e-9  # both chains reach from 10° to 130°
    assert wrist.sphere[0] == pytest.approx((0, 0, 0), abs=1e-12) and wrist.sphere[1] == pytest.approx(0.1)
    with pytest.raises(kmech.UsageError, match="two of them"):
        mechanism.space_map({"A": (-2, 2, 21)})
    seen = []
    mechanism.space_map({"A": (-2, 2, 401), "E": (-2, 2, 401)}, progress=seen.append)
    assert len(seen) > 2 and seen == sorted(seen) and 0.6 < seen[-1] <= 1  # one course for modes, sheets and curves
    with pytest.raises(kmech.Cancelled):
        mechanism.space_map({"A": (-2, 2, 21), "E": (-2, 2, 21)}, progress=lambda done: False)


def test_stored_maps_go_on(source, tmp_path):
    mechanism, over, store = kmech.load(source / "models/five_bar.json").mechanism(), {"A": (-2, 2, 61), "E": (-2, 2, 61)}, str(tmp_path / "s")
    expected = mechanism.space_map(over, point="rod1/P")
    for stop in (0.0, 0.3, 0.6):
        with pytest.raises(kmech.Cancelled):
            mechanism.space_map(over, point="rod1/P", store=store, progress=lambda done: done <= stop)
    found = mechanism.space_map(over, point="rod1/P", store=store)
    for column in expected.cells.columns:
        assert numpy.array_equal(found.cells[column], expected.cells[column], equal_nan=True)
    assert found.workspace.area == expected.workspace.area
    with pytest.raises(kmech.UsageError, match="another map"):
        mechanism.space_map(over, store=store)
    assert mechanism.space_map(over, store=store, replace=True).sheet_count == 2


def test_remedies_end_what_is_redundant(source):
    for name, redundant in (("bennett", 3), ("sarrus3", 4), ("scissor_lift", 9), ("fourbar", 3)):
        model = kmech.load(source / f"models/{name}.json")
        found = model.remedies()
        assert (found.redundant, found.remaining, found.mobility) == (redundant, 0, 1) and found.checked
        assert sum(len(change.motions) for change in found.changes) == redundant
        changed = found.model.mechanism().state.mobility()
        assert (changed.mobility, changed.redundant_constraints) == (1, 0)
        assert found.model.diagnose()["redundancies"] == []
        record = model.diagnose()
        assert [c["joint"] for c in record["remedy_set"]["changes"]] == [c.joint for c in found.changes]
        assert record["finite_mobility"] == 1 and len(record["redundancies"]) == redundant
    with pytest.raises(kmech.Cancelled):
        model.remedies(progress=lambda done: False)


def test_a_study_of_designs(source, tmp_path):
    study = kmech.load_designs(source / "studies/slider_crank_tolerance/study.json", store=tmp_path / "store.sqlite")
    assert study.parameters == ["crank", "rod", "offset"] and study.figures == {"stroke": "m", "inner end": "m"}
    assert study.run(jobs=2) and len(study) == 5120
    rows, spread, share = study.table, study.statistics("stroke"), study.share()
    # A centred slider-crank moves by two cranks r; an offset e adds e² r / (l² - r²), less than 1.2e-5 here.
    assert rows["stroke"] == pytest.approx(2 * rows["crank"], abs=2e-5)
    assert spread.mean == pytest.approx(rows["stroke"].mean(), rel=1e-12)
    assert spread.deviation == pytest.approx(rows["stroke"].std(ddof=1), rel=1e-9)
    assert share.good == rows["accepted"].sum() and share.share == share.good / len(study)
    assert share.good == numpy.sum((rows["stroke"] >= 1.199) & (rows["stroke"] <= 1.201))
    ranks = study.ranks("stroke")
    assert ranks["crank"] > 0.999 and abs(ranks["rod"]) < 0.1
    crank = study.model(7).motion(rate={"A": 1.0}, steps=90).figure("q.B", "span")[0]
    assert crank == pytest.approx(rows["stroke"][7], abs=1e-3)
    del study
    again = kmech.load_designs(source / "studies/slider_crank_tolerance/study.json", store=tmp_path / "store.sqlite")
    assert again.run(progress=lambda done: True) and numpy.array_equal(again.table, rows)


def test_an_optimisation(source):
    study = kmech.load_designs(source / "studies/bonnet_spring/study.json")
    assert study.best is None and len(study) == 0
    assert study.run()
    best, rows = study.best, study.table
    assert rows["accepted"][best] and rows["closing"][best] == rows["closing"][rows["accepted"]].max()


def test_rounded_numbers_mean_the_nearest_mechanism_that_moves():
    points = [[1, 0.2, 0.4], [0.3, 1.1, -0.4], [-1, -0.2, 0.4], [-0.3, -1.1, -0.4]]
    axes = [[-0.6361, 0.1735, 0.7518], [-0.1210, 0.6052, 0.7868], [0.6361, -0.1735, 0.7518], [0.1210, -0.6052, 0.7868]]
    bodies = ["fixed", "one", "two", "three"]
    joints = [{"name": "ABCD"[i], "type": "revolute", "bodies": [bodies[i], bodies[(i + 1) % 4]], "at": points[i], "axis": axes[i]}
              for i in range(4)]
    text = json.dumps({"assemblies": [{"name": "bennett", "drawn": "assembled", "bodies": [{"name": b} for b in bodies[1:]],
                                       "joints": joints}]})
    model = kmech.from_string(text)
    rounding, = model.roundings
    assert (rounding.verdict, rounding.mobility_as_written, rounding.mobility) == ("found", 0, 1)
    assert rounding.closes and all(abs(change.digits) <= 0.5 for change in rounding.changes)
    assert any(change.place == "axis[0] of frame three/D" for change in rounding.changes)
    exact = kmech.from_string(text, exact=True)
    assert exact.roundings == [] and exact.sha256 == model.sha256


def test_a_model_states_its_words(source):
    text = (source / "models/fourbar.json").read_text()
    assert kmech.load(source / "models/fourbar.json").about == {}
    model = kmech.from_string(text.replace("{", '{"title": "A press", "logo": "logo.png",', 1))
    assert model.about == {"title": "A press", "logo": "logo.png"}
