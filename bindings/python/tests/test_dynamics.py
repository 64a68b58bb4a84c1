"""Motions over time, inverse dynamics, equilibria and small motions, against closed forms."""
import json
import math

import numpy
import pytest

import kmech

G, MASS, LENGTH = 9.81, 2.0, 0.7


@pytest.fixture
def pendulum():
    """A point mass on a rod without mass that hangs from a hinge, horizontal at the start."""
    return kmech.from_string(json.dumps({
        "model_parameters": {"version": "1.0", "units": {"angle": "radians"}, "gravity": [0, -G, 0]},
        "assemblies": [{"name": "pendulum", "bodies": [
            {"name": "bob", "mass": MASS, "center_of_mass": [LENGTH, 0, 0],
             "moment_of_inertia": {"Ixx": 0, "Iyy": 0, "Izz": 0}}],
            "joints": [{"name": "A", "type": "Rz", "body_frame_pairs": [["fixed", "origin"], ["bob", "origin"]]}]}]}))


def test_a_run_keeps_energy_and_locates_a_stop(pendulum):
    answer = pendulum.run(until=5, rtol=1e-10, atol=1e-10, stop={"A": -math.pi / 2}, event={"A": -1.0})
    assert answer.complete and [e.name for e in answer.events] == ["crossing", "crossing"]
    assert answer.events[0].value == -1.0
    rate, where = answer.figure("v.A", "peak")
    assert rate == pytest.approx(math.sqrt(2 * G / LENGTH), rel=1e-8) and where == answer.figure("t", "last")[0]
    energy = MASS * G * LENGTH * numpy.sin(answer["q.A"]) + 0.5 * MASS * LENGTH ** 2 * answer["v.A"] ** 2
    assert abs(energy).max() < 1e-8 * MASS * G * LENGTH
    assert "<svg" in answer._repr_svg_()


def test_an_inverse_motion_has_the_weights_torque(pendulum):
    answer = pendulum.inverse(rate={"A": 2.0}, steps=90)
    assert len(answer) == 91 and answer["t"][-1] == pytest.approx(math.pi)
    assert answer["f.A"] == pytest.approx(MASS * G * LENGTH * numpy.cos(2.0 * answer["t"]), abs=1e-10)
    assert answer.figure("f.A", "rms")[0] == pytest.approx(MASS * G * LENGTH / math.sqrt(2), rel=1e-3)
    with pytest.raises(kmech.KmechError, match="no motion is prescribed"):
        pendulum.inverse(until=1)


def test_a_load_follows_an_angle_and_a_motion_its_segments():
    """A force on a slide over the angle of a hinge that rises by 180 degrees in 2 s."""
    answer = kmech.from_string(json.dumps({
        "model_parameters": {"version": "1.2", "units": {"angle": "degrees"}},
        "assemblies": [{"name": "a", "bodies": [{"name": "cam"}, {"name": "ram", "mass": MASS}], "joints": [
            {"name": "A", "type": "Rz", "body_frame_pairs": ["fixed", "cam"],
             "prescribed": {"segments": [{"rise": 180, "duration": 2, "law": "3-4-5"}]}},
            {"name": "B", "type": "Tx", "body_frame_pairs": ["fixed", "ram"], "prescribed": {"polynomial": [0, 0, 0.5]}}]}],
        "analysis": {"loads": [{"name": "push", "frame": "ram", "force": [10, 0, 0],
                                "scale": {"over": "A", "period": 360, "cosine": {"offset": 1, "amplitude": 1}}}]}
    })).inverse(until=3, steps=60)
    z = numpy.minimum(answer["t"] / 2, 1)
    angle = 180 * z ** 3 * (10 - 15 * z + 6 * z ** 2)
    assert answer["q.A"] == pytest.approx(angle, abs=1e-10)
    assert answer["f.B"] == pytest.approx(MASS - 10 * (1 + numpy.cos(numpy.radians(angle))), abs=1e-10)


def test_options_with_a_number_for_each_joint(pendulum):
    with pytest.raises(TypeError, match="joint's label: number"):
        pendulum.run(rate=3.0)
    with pytest.raises(TypeError, match="rate: A"):
        pendulum.run(rate={"A": "fast"})
    with pytest.raises(kmech.UsageError):
        pendulum.run(rate={"B": 1.0})
    with pytest.raises(kmech.KmechError, match="isn't about one pose"):
        pendulum.run(here=True)


def test_rest_and_small_motions(pendulum):
    rest = pendulum.equilibrium(settle=True)
    assert math.cos(rest["A"]) == pytest.approx(0, abs=1e-9) and math.sin(rest["A"]) == pytest.approx(-1)
    linear = rest.mechanism.linearise(rest)
    assert linear.independent == ["A"] and linear.residual < 1e-6
    assert linear.A == pytest.approx(numpy.array([[0, 1], [-G / LENGTH, 0]]), abs=1e-6)
    assert linear.B == pytest.approx(numpy.array([[0], [1 / (MASS * LENGTH ** 2)]]), abs=1e-9)
    assert sorted(linear.eigenvalues.imag) == pytest.approx([-math.sqrt(G / LENGTH), math.sqrt(G / LENGTH)], rel=1e-6)
    assert linear.stability == "stable" or linear.stability == "indifferent"
    with pytest.raises(kmech.Cancelled):
        pendulum.equilibrium(settle=True, progress=lambda done: False)


def test_columns_of_a_linear_system_are_its_own(source):
    model = kmech.load(source / "models/double_pendulum.json")
    linear, n = model.linearise(set={model.coordinates[1]: 0.4}), 2
    independent = [model.coordinates.index(c) for c in linear.independent]
    assert linear.modes.shape == (linear.N.shape[0], 2 * n) and linear.A[:n, :n] == pytest.approx(0)
    assert linear.A[:n, n:] == pytest.approx(numpy.eye(n))
    for k in range(2 * n):  # A v = λ v for v = (z, λ z), z the independent rows of the mode
        z = linear.modes[independent, k]
        v = numpy.concatenate([z, linear.eigenvalues[k] * z])
        assert linear.A @ v == pytest.approx(linear.eigenvalues[k] * v, abs=1e-9 * numpy.linalg.norm(linear.A) * numpy.linalg.norm(v))


def test_forces_of_a_function(pendulum):
    """A torsion spring that balances the weight at the start: a damped swing about the balance, as by closed form."""
    stiffness, damping = 60.0, 3.0
    inertia = MASS * LENGTH ** 2
    free = kmech.from_string(pendulum.to_json().replace("-9.81", "0"))
    session = kmech.Session(free, step=0.01, integrator="adams", set={"A": 0.3},
                            forces=lambda time, q, v: {"A": -stiffness * q[0] - damping * v[0]})
    decay = damping / (2 * inertia)
    w = math.sqrt(stiffness / inertia - decay ** 2)
    for _ in range(5):
        t = session.step(20)
        assert session.q("A") == pytest.approx(0.3 * math.exp(-decay * t) * (math.cos(w * t) + decay / w * math.sin(w * t)), abs=1e-6)


def test_a_frame_is_pushed_by_a_function(pendulum):
    """The weight as a function's force on the bob's frame."""
    free = kmech.from_string(pendulum.to_json().replace("-9.81", "0"))
    pushed = kmech.Session(free, step=0.01, frames=["bob/origin"],
                           forces=lambda time, q, v: {"bob/origin": [0, 0, 0, 0, 0, -MASS * G * LENGTH * math.cos(q[0])]})
    falling = kmech.Session(pendulum, step=0.01)
    pushed.step(50), falling.step(50)
    assert pushed.q("A") == pytest.approx(falling.q("A"), abs=1e-9)


def test_a_step_ends_where_a_joint_passes_a_value(pendulum):
    session = kmech.Session(pendulum, step=0.5, integrator="adams", stop={"A": -math.pi / 2})
    quarter = 1.8540746773013719 * math.sqrt(LENGTH / G)
    times = [session.step() for _ in range(2)]
    assert times[0] == pytest.approx(quarter, abs=1e-6) and times[1] == 0.5
    assert session.crossings[0].sense == -1 and session.crossings[0].time == times[0]


def test_limits_of_a_session(pendulum):
    """A pendulum that falls past its limit is reported; a stop holds it near the limit."""
    limited = kmech.from_string(pendulum.to_json().replace('"name": "A"', '"name": "A", "limits": [-0.5, 1]', 1))
    free = kmech.Session(limited, step=0.01)
    free.step(20)
    assert free.passed_limits == []
    free.step(80)
    [passed] = free.passed_limits
    assert (passed.joint, passed.upper, passed.limit) == ("A", False, -0.5)
    assert 0.2 < passed.time < 1.0 and passed.beyond > 0.1
    stopped = kmech.Session(limited, step=0.001, limit_stops=[1e4, 100])
    stopped.step(3000)
    assert stopped.passed_limits == [] and stopped.q("A") == pytest.approx(-0.5, abs=0.01)
    with pytest.raises(kmech.UsageError):
        kmech.Session(limited, limit_stops=[-1, 0])


def test_a_function_that_fails_ends_the_step(pendulum):
    def late(time, q, v):
        if time > 0.05:
            raise RuntimeError("no force")
        return None

    session = kmech.Session(pendulum, step=0.01, forces=late)
    with pytest.raises(RuntimeError, match="no force"):
        session.step(10)
    with pytest.raises(kmech.UsageError):
        kmech.Session(pendulum, forces=lambda time, q, v: {"B": 1.0}).step()
    with pytest.raises(TypeError, match="forces: A"):
        kmech.Session(pendulum, forces=lambda time, q, v: {"A": "much"}).step()
