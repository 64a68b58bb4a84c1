"""Wrong calls raise, and never crash: more than a hundred of them."""
import pytest

import kmech

NAN, INF = float("nan"), float("inf")
ONE = ('{"assemblies": [{"name": "a", "bodies": [{"name": "b"}], "joints": [{"name": "J", "type": "Rz", '
       '"body_frame_pairs": ["fixed", "b"]}]}]}')

TEXTS = ["", "{", "[]", "null", "3", '"x"', '{"assemblies": 3}', '{"assemblies": [3]}', '{"a": 1, "a": 2}', "\0", "{\"a\": NaN}",
         "<robot", "<robot/>", "<mujoco><worldbody><body><joint type='x'/></body></worldbody></mujoco>", "<sdf/>", "<html/>",
         '{"model_parameters": {"version": "9"}}', '{"model_parameters": {"units": {"length": "mile"}}}',
         '{"assemblies": [{"name": "a", "bodies": [{"name": "b"}]}]}', ONE.replace("Rz", "Rw"), ONE.replace("fixed", "fxed"),
         "[" * 5000, b"\xff\xfe\x00", "<a>" * 3000, ONE.replace('"b"}]', '"b", "mass": -1}]')]


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_texts(text):
    with pytest.raises((kmech.ModelError, kmech.KmechError)) as raised:
        kmech.from_string(text)
    assert str(raised.value)


MODEL = [
    lambda m: kmech.load("/no/such/file"),
    lambda m: kmech.load(3),
    lambda m: kmech.load("/dev/zero"),
    lambda m: kmech.load_study("/dev/zero"),
    lambda m: kmech.load("/"),
    lambda m: kmech.from_string(None),
    lambda m: kmech.from_string(ONE, vary={"J": 1}),
    lambda m: kmech.from_string(ONE, vary={"nothing": 1}),
    lambda m: kmech.from_string(ONE, vary={"J.initial_displacement": "x"}),
    lambda m: kmech.from_string(ONE, vary={"J.initial_displacement": NAN}),
    lambda m: kmech.from_string(ONE, vary={3: 1}),
    lambda m: m.vary(nothing=3),
    lambda m: m.limits("nothing"),
    lambda m: m.limits(3),
    lambda m: m.limits("a\0b"),
    lambda m: m.limits(None),
    lambda m: m.set_position("nothing", 1),
    lambda m: m.set_position("K", "x"),
    lambda m: m.set_position("K", NAN),
    lambda m: m.set_position("K", INF),
    lambda m: m.set_limits("K", 2, 1),
    lambda m: m.set_limits("K", NAN, 1),
    lambda m: m.set_frame("nothing/here", [0, 0, 0]),
    lambda m: m.set_frame("bridge/left_arm_pivot", [0, 0]),
    lambda m: m.set_frame("bridge/left_arm_pivot", [0, 0, NAN]),
    lambda m: m.set_frame("bridge/left_arm_pivot", [0, 0, 0], [[2, 0, 0], [0, 1, 0], [0, 0, 1]]),
    lambda m: m.set_frame("bridge/left_arm_pivot", [0, 0, 0], [1, 2]),
    lambda m: m.set_frame("bridge/left_arm_pivot", "abc"),
    lambda m: m.set_mass("nothing", 1),
    lambda m: m.set_mass("fixed", 1),
    lambda m: m.set_mass("bridge", -1),
    lambda m: m.set_mass("bridge", INF),
    lambda m: m.set_mass("bridge", 1, [1, 2]),
    lambda m: m.set_mass("bridge", 1, None, [-1, -1, -1, 0, 0, 0]),
    lambda m: m.save("/no/such/folder/x.json"),
    lambda m: m.to_json(3),
    lambda m: m.mechanism(set={"nothing": 1}),
    lambda m: m.mechanism(set={"K": "x"}),
    lambda m: m.mechanism(set={"K": NAN}),
    lambda m: m.mechanism(set=[1, 2]),
    lambda m: m.mechanism(hold={"K": 1e9}),
    lambda m: m.mechanism(set={"K": 1e9}),
    lambda m: kmech.Mechanism(3),
    lambda m: kmech.Model(3),
    lambda m: kmech.documentation("km_nothing"),
]
QUESTION = [
    lambda m: m.sweep("nothing", 0, 1),
    lambda m: m.sweep("K", 0),
    lambda m: m.sweep("K", "a", "b"),
    lambda m: m.sweep("K", NAN, 1),
    lambda m: m.sweep("K", 20, 32, 0),
    lambda m: m.sweep("K", 20, 32, -5),
    lambda m: m.sweep("K", 20, 32, 1e3),
    lambda m: m.sweep("K", 20, 32, 2 ** 40),
    lambda m: m.sweep("K", 20, 32, "many"),
    lambda m: m.sweep("K", 20, 32, nothing=1),
    lambda m: m.sweep(3, 20, 32),
    lambda m: m.mobility(range=3),
    lambda m: m.mobility(range=(1, 2, 3)),
    lambda m: m.mobility(range="ab"),
    lambda m: m.mobility(point=3),
    lambda m: m.mobility(point="bridge/origin"),
    lambda m: m.mobility(point=["nothing/here"]),
    lambda m: m.mobility(point=[3]),
    lambda m: m.mobility(arclength=-1),
    lambda m: m.mobility(arclength=NAN),
    lambda m: m.mobility(direction=3),
    lambda m: m.mobility(branch=99),
    lambda m: m.mobility(state=3),
    lambda m: m.mobility(progress=3),
    lambda m: m.forces(actuators=["nothing"]),
    lambda m: m.forces(actuators="K"),
    lambda m: m.forces(actuators=["K", "K"]),
    lambda m: m.forces(gravity=(1, 2)),
    lambda m: m.forces(gravity=(1, 2, NAN)),
    lambda m: m.forces(load=[3]),
    lambda m: m.forces(load=[{"force": [1, 2, 3]}]),
    lambda m: m.forces(load=[{"frame": "bridge/origin", "force": [1, 2]}]),
    lambda m: m.forces(load=[{"frame": "nothing/here"}]),
    lambda m: m.forces(load=[{"frame": "bridge/origin", "mass": 3}]),
    lambda m: m.forces(push=[("bridge/origin", [0, 0, 0])]),
    lambda m: m.forces(push=["bridge/origin"]),
    lambda m: m.forces(push=[("bridge/origin", [1, 2])]),
    lambda m: m.forces(axes="round"),
    lambda m: m.forces(axes=1),
    lambda m: m.advantage(input="nothing"),
    lambda m: m.advantage(input=3),
    lambda m: m.advantage(input="K", output="K"),
    lambda m: m.advantage(input=("bridge/origin", [0, 0, NAN])),
    lambda m: m.sweep("K", 20, 32, 3).figure("nothing"),
    lambda m: m.sweep("K", 20, 32, 3).figure("s", "most"),
    lambda m: m.sweep("K", 20, 32, 3).figure(3),
    lambda m: m.sweep("K", 20, 32, 3).save_csv("/no/such/folder/x.csv"),
    lambda m: m.sweep("K", 20, 32, 3).save_xlsx("/no/such/folder/x.xlsx"),
    lambda m: m.sweep("K", 20, 32, 3).save_xlsx("x.xlsx", sheet="chart"),
    lambda m: m.sweep("K", 20, 32, 3).save_xlsx("x.xlsx", sheet="a/b"),
    lambda m: m.sweep("K", 20, 32, 3).plot().data("gif"),
    lambda m: m.sweep("K", 20, 32, 3).plot().save("x.gif"),
    lambda m: m.sweep("K", 20, 32, 3)["nothing"],
    lambda m: m.sweep("K", 20, 32, 3).table.__setitem__(0, 0),
]
STATE = [
    lambda s: s["nothing"],
    lambda s: s[3],
    lambda s: s.__setitem__("K", NAN),
    lambda s: s.__setitem__("K", "x"),
    lambda s: s.__setitem__("nothing", 1),
    lambda s: s.reach(nothing=1),
    lambda s: s.reach(K=NAN),
    lambda s: s.reach(K=1e9),
    lambda s: s.reach_all(3),
    lambda s: s.frame("nothing"),
    lambda s: s.frame(""),
    lambda s: s.frame("bridge/origin\0"),
    lambda s: s.jacobian("nothing/here"),
    lambda s: s.jacobian(None),
    lambda s: s.mechanism.arm("bridge/origin"),
    lambda s: s.mechanism.arm("nothing/here"),
    lambda s: s.mechanism.arm("bridge/origin", "dance"),
    lambda s: s.mechanism.arm(3),
]
BUILDER = [
    lambda b: b.body(""),
    lambda b: b.body("fixed"),
    lambda b: b.body(3),
    lambda b: b.body("x", mass=-1),
    lambda b: b.body("x", mass="heavy"),
    lambda b: b.body("x", center=[1]),
    lambda b: b.body("x", inertia=[NAN] * 6),
    lambda b: b.body("b"),
    lambda b: b.frame("nothing", "t"),
    lambda b: b.frame("b", "origin"),
    lambda b: b.frame("b", "t", R=[1] * 9),
    lambda b: b.joint("J", "Rw", "fixed", "b"),
    lambda b: b.joint("J", "Rz", "fixed", "c"),
    lambda b: b.joint("J", "Rz", "b", "b"),
    lambda b: b.joint("J", "Rz", "fixed", "b", position=NAN),
    lambda b: b.joint("J", "Rz", "fixed", "b", position=[0] * 9),
    lambda b: b.joint("J", "Rz", "fixed", "b", max_rate=-1),
    lambda b: b.joint("J", "Rz", "fixed", "b", colour=1),
    lambda b: b.joint("J", "Rz", 3, "b"),
    lambda b: b.couple("c", {"nothing": 1}),
    lambda b: b.couple("c"),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").couple("c", {"J": 1, "J[1]": 1}),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").couple("c", {"J[x]": 1}),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").couple("c", {"J[-1]": 1}),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").couple("c", {"J[1": 1}),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").couple("c", {"J[2]": 1}),
    lambda b: b.joint("J", "cylindrical", "fixed", "b").actuator("J"),
    lambda b: b.joint("J", "cylindrical", "fixed", "b", damping=2),
    lambda b: b.joint("J", "cylindrical", "fixed", "b", position=[1, 2, 3]),
    lambda b: b.joint("J", "universal", "fixed", "b").couple("c", {"J[0]": 1, "J[1]": 1}, polynomial=[0, 1]),
    lambda b: b.joint("J", "universal", "fixed", "b").couple(
        "c", follower="J[0]", leader="J[1]", polynomial=[0, 1], constant=1),
    lambda b: b.load("l", "nothing/here"),
    lambda b: b.actuator("nothing"),
    lambda b: b.finish(),
    lambda b: b.joint("J", "Rz", "fixed", "b").finish() and b.finish(),
    lambda b: kmech.Builder(angle="turns"),
    lambda b: kmech.Builder(gravity=[1]),
    lambda b: kmech.Builder(closure_tolerance=2),
]
ARM = [
    lambda a: a.place([0] * 6),
    lambda a: a.place([NAN] * 7),
    lambda a: a.place("abcdefg"),
    lambda a: a.jacobian([0] * 8),
    lambda a: a.solve(3, [0] * 7),
    lambda a: a.solve(([1] * 9, [0, 0, 0]), [0] * 7),
    lambda a: a.solve(a.place([0.1] * 7), [0] * 6),
    lambda a: a.solve(a.place([0.1] * 7), [0.1] * 7, seed=-1),
    lambda a: a.solve(([1, 0, 0, 0, 1, 0, 0, 0, 1], [9, 0, 0]), [0.1] * 7),
    lambda a: kmech.Study("{}"),
    lambda a: kmech.Study("{"),
    lambda a: kmech.Study(3),
    lambda a: kmech.Study('{"effector": ["x", "y"]}', model=a.mechanism.model),
    lambda a: kmech.load_study("/no/such/study.json"),
]
EXPECTED = (kmech.KmechError, TypeError, ValueError, OSError, KeyError, IndexError)


@pytest.mark.filterwarnings("ignore::kmech.ModelWarning")
@pytest.mark.parametrize("call", MODEL + QUESTION)
def test_models_and_questions(call, brake):
    with pytest.raises(EXPECTED) as raised:
        call(brake)
    assert str(raised.value)


@pytest.mark.parametrize("call", STATE)
def test_states(call, brake):
    with pytest.raises(EXPECTED):
        call(brake.mechanism().state)


@pytest.mark.parametrize("call", BUILDER)
def test_builders(call):
    with pytest.raises(EXPECTED):
        call(kmech.Builder().body("b"))


@pytest.mark.parametrize("call", ARM)
def test_arms(call, iiwa):
    with pytest.raises(EXPECTED):
        call(iiwa.mechanism().arm("flange/tool"))


def test_there_are_more_than_a_hundred():
    assert len(TEXTS + MODEL + QUESTION + STATE + BUILDER + ARM) > 100


PLY = """ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4
property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"""


@pytest.mark.parametrize("size", [len(PLY), len(PLY) - 13, len(PLY) - 30, 150, 40, 0])
def test_damaged_meshes(size, tmp_path):
    """assimp crashes on files that end early, and the interpreter goes on."""
    (tmp_path / "m.json").write_text(ONE.replace('{"name": "b"}', '{"name": "b", "density": 6, "definition": "m.ply"}'))
    (tmp_path / "m.ply").write_text(PLY[:size])
    if size == len(PLY):
        assert kmech.load(tmp_path / "m.json")
    else:
        with pytest.raises(kmech.ModelError, match="m.ply"):
            kmech.load(tmp_path / "m.json")


def test_errors_tell_the_place():
    with pytest.raises(kmech.ModelError) as raised:
        kmech.from_string(ONE.replace("Rz", "Rw"))
    assert "assemblies[0].joints[0].type" in str(raised.value) and raised.value.messages
    assert isinstance(raised.value, ValueError) and raised.value.status == "model"


def test_a_state_is_of_one_thread_at_a_time(brake):
    state = brake.mechanism().state
    with state._lock, pytest.raises(kmech.UsageError, match="another thread"):
        state.mobility()


def test_a_model_in_use_does_not_change(brake):
    with brake._reading(), pytest.raises(kmech.UsageError, match="in use"):
        brake.set_position("K", 20)


DESIGNS = '''{"model": "m.json", "parameters": {"q": "J.initial_displacement"}, "grid": {"q": [0, 1]},
 "ask": [{"question": "mobility", "options": {"joint": "J", "range": [0, 1], "steps": 2}, "figures": {"dof": "min dof"}}]}'''


@pytest.mark.parametrize("call", [
    lambda d: kmech.load_designs("/no/such/file"),
    lambda d: kmech.load_designs("/dev/zero"),
    lambda d: kmech.DesignStudy(3),
    lambda d: kmech.DesignStudy(""),
    lambda d: kmech.DesignStudy("{}"),
    lambda d: kmech.DesignStudy(DESIGNS, folder="/no/such/folder"),
    lambda d: kmech.DesignStudy(DESIGNS.replace("mobility", "nothing"), folder=d),
    lambda d: kmech.DesignStudy(DESIGNS.replace("min dof", "min nothing"), folder=d).run(jobs=0),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d, store="/no/such/folder/store"),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).run(jobs="2"),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).run(progress=3),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).statistics("nothing"),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).ranks(None),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).model(99),
    lambda d: kmech.DesignStudy(DESIGNS, folder=d).model("best"),
], ids=range(15))
def test_designs(call, tmp_path):
    (tmp_path / "m.json").write_text(ONE)
    with pytest.raises((kmech.KmechError, TypeError)) as raised:
        call(tmp_path)
    assert str(raised.value)
