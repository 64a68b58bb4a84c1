"""The facts that scripts/evidence measures: groups of (fact, command, our value, reference, tolerance, source of the
reference, source of the tolerance).

The command runs in the project's folder; where it writes files, {} is a name for them. Our value is a function of what it
prints: `.answer` (JSON), `.column(NAME)` (a column of CSV, its unit left out), `.table` (rows of CSV without names) and
`.said(PATTERN)` (a number in a text). References are computed here, apart from kmech; what isn't a number must be equal."""
import math

CLOSED = "the loops are closed to 1e-12 of their size, and no pivot is below 1e-3"
PRINTED = "half of the last digit that is printed"
WHOLE = "none: whole numbers, names, yes or no"

SQUARE = "kmob at models/bricard.json --set B=1.5707963267948966 --format json"
TRIANGLE = "kmob at models/bricard.json --set B=0 --format json"
CRANK = "kmob sweep models/slider_crank.json --format csv -o -"
KLANN = "kmob sweep models/klann.json --format csv -o -"
EXCAVATOR = "kmob info models/excavator.json --format json"
VEHICLE = "kmob info models/vehicle.json --format json"
FOLDED = "kmob at models/a02.json --set A0=-1.5707963267948966 --format json"
LINE = "kmob sweep models/peaucellier.json --point AP/P --format csv -o -"
LEVER = "kma sweep models/fourbar.json --format json -o -"
JACK = "kma at models/scissor_lift.json --set S=%g --format json"
JACK_FORCE = "kstatic at models/scissor_lift.json --set S=%g --format json"
ANDREWS = "ksim run models/andrews.json --until 0.03 --every 0.03 --rtol 1e-12 --atol 1e-12 --format csv -o -"
BRICARD_RUN = "ksim run models/bricard.json --until 100 --every 0.1 --rtol 1e-11 --atol 1e-11 --format csv -o -"
THESIS_RUN = "ksim run models/slider_crank.json --until 20 --every 0.03 --rtol 1e-4 --atol 1e-4 --max-step 0.01 --format csv -o -"
GOVERNOR = "ksim run models/governor.json --until 10 --every 10 --format csv -o -"
GROWTH = "ksim linearise models/a02.json --set A0=0 --format json"
MATRIX = "kredund matrix tests/evidence/thesis_jacobian.csv"
FLANGE = "kmob frame models/panda.json --frame flange/tool --format json"
BRANCHES = "kredund ik studies/iiwa_weld/study.json --format json"
LOOKAHEAD = "kredund track studies/panda_limit/study.json --method lookahead --format json -o -"
GREEDY = "kredund track studies/panda_limit/study.json --method greedy --format json -o -"
TOLERANCE = "kstudy run studies/slider_crank_tolerance/study.json --store :memory: -o {}"


def numbers(answer, joint):
    return answer["mobility_numbers"][joint]


def slider_crank(angle):
    """Mobility numbers of A, B, C, D from the rates in closed form: rod 1.5 m, crank 0.4 of it, lengths over 1 m."""
    sine = 0.4 * math.sin(angle)
    rod = -0.4 * math.cos(angle) / math.sqrt(1 - sine * sine)  # the rod turns so much where the crank turns by 1
    squares = [1, (1.5 * (rod * sine - sine)) ** 2, rod ** 2, (rod - 1) ** 2]
    return [square / sum(squares) for square in squares]


def least_of_turn(joint):
    return min(slider_crank(2 * math.pi * k / 200)[joint] for k in range(201))


def tangent(slide):
    """Of the slope of a scissor lift's arms of 2 m whose foot stands `slide` from the pin."""
    return math.sqrt(4 - slide ** 2) / slide


# What rises with the lift's platform: itself, the payload and the head; the lower arms a quarter as fast, the upper ones three.
LIFT = 4905 + 9.81 * (120 + 6 + 2 * 45 * 0.25 + 2 * 45 * 0.75)

# The thesis's path and pose column, rows A to G and the path.
COLUMNS = [(0.2906, -0.0847), (-0.0348, 0.0148), (0.0217, 0.8156), (0.5621, -0.0026), (-0.3434, 0.4313),
           (0.5439, 0.0146), (-0.3967, -0.3758), (0.1638, 0)]

SQUEEZER = {"beta": 15.81077119629904, "Theta": -15.75637105984298, "gamma": 0.04082224013073101,
            "phi": -0.5347301163226948, "delta": 0.5244099658805304, "Omega": 0.5347301163226948,
            "epsilon": 1.048080741042263}

# A normal distribution cut off at three deviations: its variance over the whole one's, and the share within one.
CUT = 1 - 6 * math.exp(-4.5) / math.sqrt(2 * math.pi) / math.erf(3 / math.sqrt(2))
WITHIN_ONE = math.erf(1 / math.sqrt(2)) / math.erf(3 / math.sqrt(2))

MOBILITY = [
    ("Bricard's linkage, square pose: the largest number", SQUARE, lambda p: max(p.answer["mobility_numbers"].values()),
     1 / 6, 1e-9, "thesis 10.1.2", CLOSED),
    ("Bricard's linkage, square pose: the least number", SQUARE, lambda p: min(p.answer["mobility_numbers"].values()), 1 / 6, 1e-9, "thesis 10.1.2", CLOSED),
    ("Bricard's linkage, planar triangle: joint A", TRIANGLE, lambda p: numbers(p.answer, "A"), 0.0, 1e-9, "thesis 10.1.2",
     CLOSED),
    ("Bricard's linkage, planar triangle: joint B", TRIANGLE, lambda p: numbers(p.answer, "B"), 1 / 3, 1e-9, "thesis 10.1.2", CLOSED),
    ("Bricard's linkage, planar triangle: angle of A, rad", TRIANGLE, lambda p: p.answer["configuration"]["A"], -2 * math.pi / 3, 1e-9,
     "2 cos A + 1 = 0", CLOSED),
    ("Bricard's linkage: Kutzbach's count", TRIANGLE, lambda p: p.answer["kutzbach"], 0, 0, "thesis 10.1.2", WHOLE),
    ("Bricard's linkage: mobility", TRIANGLE, lambda p: p.answer["mobility"], 1, 0, "thesis 10.1.2", WHOLE),
    ("README's slider-crank: the least number of A", CRANK, lambda p: min(p.column("m.A")), least_of_turn(0), 1e-9,
     "closed form of its rates", CLOSED),
    ("README's slider-crank: the least number of D", CRANK, lambda p: min(p.column("m.D")), least_of_turn(3), 1e-9, "closed form of its rates", CLOSED),
    ("Slider-crank: the slide's number at its dead centres", CRANK, lambda p: max(p.column("m.B")[0:201:100]), 0.0, 1e-9, "thesis 10.1.1",
     CLOSED),
    ("Slider-crank: the loop's largest error over the turn", CRANK, lambda p: max(p.column("residual")), 0.0, 1e-12, "the loop is closed",
     "what every pose is closed to"),
    ("Klann's leg: joints whose numbers stay above 0.05", KLANN,
     lambda p: " ".join(j for j in "ABCDEFG" if min(p.column("m." + j)) > 0.05), "A D", 0, "thesis 10.2.2: above 0", WHOLE),
    ("Two windows folded flat (IFToMM A02): mobility", FOLDED, lambda p: p.answer["mobility"], 2 + 1, 0,
     "IFToMM's library of benchmarks", WHOLE),
    ("Excavator: substructures", EXCAVATOR, lambda p: ", ".join("".join(s["joints"]) for s in p.answer["substructures"]),
     "CHILMPQ, DJNR, EFGKOST", 0, "thesis table 7", WHOLE),
    ("Vehicle: joints in its substructures", VEHICLE,
     lambda p: ", ".join(str(len(s["joints"])) for s in p.answer["substructures"]), "7, 27, 7", 0, "thesis table 28", WHOLE),
    ("Peaucellier's linkage: farthest from the line x = 100 mm", LINE,
     lambda p: max(abs(x - 100) for x in p.column("point.AP/P.x")), 0.0, 1e-9, "|OQ| |OP| is constant",
     "the loops are closed to 1e-12 of 100 mm, times ten for its slope"),
]

LEVERAGE = [
    ("Four-bar: the first dead centre of its rocker, rad", LEVER, lambda p: p.answer["toggles"][0]["s"],
     math.acos((0.4 ** 2 + 0.65 ** 2 - 0.45 ** 2) / (2 * 0.4 * 0.65)), 1e-9, "cosine rule", "events are located to 1e-9"),
    *[row for s in (1.9, 0.9) for row in (
        (f"Scissor lift, S = {s} m: advantage of the jack over the platform", JACK % s,
         lambda p: p.answer["mechanical_advantage"], -tangent(s) / 2, 1e-9, "−tan θ/2", CLOSED),
        (f"Scissor lift, S = {s} m: what the jack holds, N", JACK_FORCE % s, lambda p: p.answer["actuator_forces"]["S"],
         -2 * LIFT / tangent(s), 1e-6, "virtual work: 2 W/tan θ", CLOSED + "; forces are some 1e4 N"))],
]

MOTION = [
    *[(f"Andrews' squeezer (IFToMM A03) at 0.03 s: {name}, rad", ANDREWS, lambda p, name=name: p.column("q." + name)[-1],
       value, 1e-8, "IVP test set; Hairer and Wanner II, VII.7", "steps of 1e-12 add up over the run")
      for name, value in SQUEEZER.items()],
    ("Bricard's linkage, 100 s (IFToMM A04, thesis tables 23 to 25): largest change of energy, over it", BRICARD_RUN,
     lambda p: max(abs(e / p.column("energy_kinetic")[0] - 1) for e in p.column("energy_kinetic")), 0.0, 1e-9,
     "nothing drives or brakes it", "420 steps of 1e-11 each"),
    ("Slider-crank, 20 s (thesis tables 20 to 22): largest loop error", THESIS_RUN, lambda p: max(p.column("loop_error")), 0.0,
     1.5e-10, "the thesis's largest one, 1.5e-10", "what the thesis reached"),
    ("Slider-crank, 20 s: new partitions", THESIS_RUN, lambda p: int(p.column("repartitions")[-1]), 0, 0,
     "thesis 7.1: one serves throughout", WHOLE),
    ("Porter's governor at 12.13 rad/s: the sleeve comes to, m", GOVERNOR, lambda p: p.column("q.S")[-1],
     0.6 - 2 * 3 * 9.81 / 12.130539970747 ** 2, 1e-8, "(m + M)/m · g/w²", "what its damper has left after 10 s"),
    ("IFToMM A02 upright grows with, 1/s", GROWTH, lambda p: max(e["real"] for e in p.answer["eigenvalues"]),
     math.sqrt(3.5 * 9.81 / 3), 1e-7, "3 θ̈ = −3.5 g cos θ", "differences of forces err by 1e-8"),
]

ARMS = [
    *[(f"Thesis's 7R robot, {'pose' if c else 'path'} column: {'path' if k == 7 else 'joint ' + 'ABCDEFG'[k]}", MATRIX,
       lambda p, k=k, c=c: p.table[k][c], COLUMNS[k][c], 1e-4, "thesis section 11.4",
       "the Jacobian is printed with four digits") for c in range(2) for k in range(8)],
    ("Panda's flange at (0, −π/4, 0, −3π/4, 0, π/2, π/4): x, m", FLANGE, lambda p: p.answer["position"][0], 0.306891, 5e-7,
     "the maker's parameters", PRINTED),
    ("Panda's flange at that pose: z, m", FLANGE, lambda p: p.answer["position"][2], 0.590282, 5e-7, "the maker's parameters", PRINTED),
    ("iiwa 14: branches that reach the weld's first pose", BRANCHES, lambda p: p.answer["count"], 2 ** 3, 0,
     "shoulder, elbow and wrist have two ways each", WHOLE),
    ("README: share of a half range that look-ahead keeps", LOOKAHEAD, lambda p: p.answer["tracks"][0]["summary"]["objective_min"],
     0.15, 0.005, "README", "half of the last digit that README tells"),
    ("README: largest distance from the path, m", LOOKAHEAD, lambda p: p.answer["tracks"][0]["summary"]["error_position"], 0.0,
     1e-12, "README", "what README promises"),
    ("README: greedy runs into a limit", GREEDY, lambda p: "joint2 is at its limit" in p.answer["tracks"][0]["stopped_by"], True,
     0, "README", WHOLE),
]

DESIGNS = [
    ("Slider-crank, crank ±0.5 mm: deviation of the stroke, m", TOLERANCE, lambda p: p.said(r"stroke +m +\S+ +\S+ +(\S+)"),
     0.001 * math.sqrt(CUT), 3e-5, "a normal distribution cut off at three deviations, twice the crank",
     "three times 1/√(2 · 5120) of it"),
    ("Slider-crank, crank ±0.5 mm: share of strokes from 1199 to 1201 mm, %", TOLERANCE, lambda p: p.said(r"5120, (\S+) %"), 100 * WITHIN_ONE,
     300 * math.sqrt(WITHIN_ONE * (1 - WITHIN_ONE) / 5120), "the same distribution", "three times √(p (1 − p)/5120)"),
]

GROUPS = [("Mobility", MOBILITY), ("Leverage and forces", LEVERAGE), ("Motion over time", MOTION), ("Redundant arms", ARMS),
          ("Designs", DESIGNS)]
