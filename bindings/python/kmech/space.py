"""Configuration spaces: all assembly modes, their circuits, maps over two drivers, turning curves, singularity-free paths."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Iterator, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy

from ._kmech import ffi, lib
from .errors import UsageError, check, new_error, text_of
from .mechanism import Mechanism, State
from .picture import Picture
from .progress import Progress, Watch
from .table import Table, table_of


class AssemblyModes(NamedTuple):
    """All assembly modes. Rows of the arrays are modes; the first one is the state's own.

    complete: there are no other modes; else reason: "trace", "lost", "singular", "self-motion" or "limit". coordinates:
    modes × coordinates, in the model's units. mobility_numbers: the same shape, with all coordinates free. certified: the
    proof holds, that exactly one solution lies within error_bound and no other within radius (radians, lengths over the
    substructure's size). moves: bodies move although the locked joints stay. within_limits: joints within their limits.
    complex_solutions: complex solutions over a generic closure error; estimate: their estimated number. circuit: number of
    each mode's circuit, from 1; modes of one circuit are connected by the mechanism's motion, limits ignored. circuits:
    their number, 0 if circuits_reason is "freedoms" (several), "self-motion" or "ball"; with "lost" some may be connected."""

    complete: bool
    reason: str
    coordinates: numpy.ndarray
    mobility_numbers: numpy.ndarray
    certified: numpy.ndarray
    error_bound: numpy.ndarray
    radius: numpy.ndarray
    moves: numpy.ndarray
    within_limits: numpy.ndarray
    complex_solutions: int
    estimate: int
    circuit: numpy.ndarray
    circuits: int
    circuits_reason: str


def all_modes(mechanism: Mechanism, state: State, hold: Sequence[str], within_limits: bool, seed: int,
              progress: Progress) -> AssemblyModes:
    """All assembly modes with the joints of `hold` at the state's values."""
    error, modes, watch = new_error(), ffi.new("km_all_modes *"), Watch(progress)
    circuits = ffi.new("km_mode_circuits *")
    locked = ffi.new("int[]", [mechanism.model._coordinate(label) for label in hold])
    definition = ffi.new("km_all_modes_def *", {"locked": locked, "locked_count": len(locked),
                                                "within_limits": within_limits, "seed": seed})
    try:
        with mechanism.model._reading(), state._using():
            status = lib.km_modes_and_circuits_find(mechanism._c, state._c, definition, watch.call, watch.context, modes, circuits,
                                                    error)
        watch.finish()
        check(status, error)
        count, width = modes.count, len(mechanism.model.coordinates)

        def table(pointer: object) -> numpy.ndarray:
            return numpy.frombuffer(ffi.buffer(pointer, 8 * count * width)).reshape(count, width).copy()

        def figures(name: str) -> numpy.ndarray:
            return numpy.array([getattr(modes.evidence[i], name) for i in range(count)])

        return AssemblyModes(modes.is_complete, text_of(lib.km_mode_gap_name(modes.gap)), table(modes.coordinates),
                             table(modes.mobility_numbers), figures("is_certified"), figures("error_bound"),
                             figures("radius"), figures("moves"), figures("is_within_limits"), modes.complex_solutions,
                             modes.estimate, numpy.array([circuits.circuit[i] for i in range(count)]), circuits.count,
                             text_of(lib.km_circuit_gap_name(circuits.gap)))
    finally:
        lib.km_mode_circuits_free(circuits)
        lib.km_all_modes_free(modes)


class AspectWorkspace(NamedTuple):
    """The places of the point in an aspect. area: NaN if an outline doesn't close. circle and rectangle: centres of the largest ones
    without a singularity; radius, width or height 0: none. cone: on a sphere the axis of the largest cone from its centre, a unit vector;
    half_angle: in radians, 0: none."""

    aspect: int
    area: float
    circle: Tuple[float, float, float]
    radius: float
    rectangle: Tuple[float, float, float]
    width: float
    height: float
    cone: Tuple[float, float, float]
    half_angle: float


class Workspace(NamedTuple):
    """The workspace of a map's point. outline: loop, kind, curve and place of its points, the workspace on the left. gap: longest gap
    that a straight line closes. outside: of `checked` grid points those beyond the outline, 0 unless a curve is missing. aspects: one by one.
    sphere: centre and radius of that on which the point moves; None: a plane."""

    outline: Table
    area: float
    holes: int
    gap: float
    outside: int
    checked: int
    aspects: Tuple[AspectWorkspace, ...]
    sphere: Optional[Tuple[Tuple[float, float, float], float]] = None


class SpaceMap(NamedTuple):
    """A map over two drivers. cells: a row for each grid point that a sheet reaches, with the sheet's mode, q. and m. of every
    coordinate, sigma.input and sigma.closure, with a point its place, sigma.output and manipulability, then the columns of `ask`.
    curves: points of the curves; kind 0: singularity of the drivers, 1: of the point, 2: an end of a range or a limit, 3: the
    least clearance. complete: the modes from which the sheets
    were followed are all modes at the state. workspace: of the point; None without one."""

    cells: Table
    curves: Table
    sheet_count: int
    curve_count: int
    complete: bool
    workspace: Optional[Workspace] = None


def _workspace(found: Any) -> Workspace:
    aspects = tuple(AspectWorkspace(at.aspect, at.area, tuple(at.circle), at.radius, tuple(at.rectangle), at.width, at.height, tuple(at.cone),
                                    at.half_angle)
                    for at in found.workspaces[0:found.workspace_count])
    surface = found.surface
    return Workspace(table_of(found.boundary, found), found.workspace_area, found.hole_count, found.gap, found.unbounded, found.checked,
                     aspects, (tuple(surface.origin), surface.radius) if surface.radius > 0.0 else None)


QUANTITIES = ("mobility", "advantage", "forces", "clearance")  # in the order of km_map_quantity


def _kept_pairs(mechanism: Mechanism, state: State, clearance: Optional[float]) -> Any:
    """The pairs of bodies that keep a clearance; NULL: none."""
    error, pairs = new_error(), ffi.new("km_clearance **")
    if clearance is None:
        return ffi.NULL
    lib.km_poses_compute(mechanism._c, state._c)
    check(lib.km_clearance_create(mechanism._c, state._c, ffi.NULL, 0, pairs, error), error)
    return ffi.gc(pairs[0], lib.km_clearance_free)


def _map_parts(mechanism: Mechanism, state: State, ask: str, locked: Any, clearance: Optional[float]) -> Tuple[Any, Any]:
    """The figures that the map adds to its cells, and the pairs of bodies that keep a clearance; NULL: none."""
    error, figures = new_error(), ffi.new("km_map_figures **")
    if ask not in QUANTITIES:
        raise UsageError(f"ask={ask!r}: expected one of {', '.join(QUANTITIES)}")
    check(lib.km_map_figures_create(mechanism._c, state._c, QUANTITIES.index(ask), locked, figures, error), error)
    added = ffi.gc(figures[0], lib.km_map_figures_free) if figures[0] else ffi.NULL
    return added, _kept_pairs(mechanism, state, clearance)


@contextmanager
def _map_store(mechanism: Mechanism, state: State, definition: Any, seed: int, path: Optional[str], replace: bool) -> Iterator[None]:
    """Opens the store of the definition's map, unless path is None, and closes it."""
    error, opened = new_error(), ffi.new("km_map_store **")
    if path is not None:
        name = ffi.new("char[]", str(path).encode())
        check(lib.km_map_store_open(name, mechanism._c, state._c, definition, seed, replace, opened, error), error)
    definition.store = opened[0]
    try:
        yield
    finally:
        lib.km_map_store_free(opened[0])


def space_map(mechanism: Mechanism, state: State, over: Mapping[str, Tuple[float, float, int]], point: Optional[str], ask: str,
              own: bool, limits: bool, clearance: Optional[float], store: Optional[str], replace: bool, seed: int,
              progress: Progress) -> SpaceMap:
    """The map over the drivers of `over`, label: (from, to, values); point: "body/frame"; store: a file, or None."""
    error, watch = new_error(), Watch(progress)
    modes = ffi.gc(ffi.new("km_all_modes *"), lib.km_all_modes_free)
    found = ffi.gc(ffi.new("km_space_map *"), lib.km_space_map_free)
    if len(over) != 2:
        raise UsageError(f"a map over {len(over)} drivers; expected two of them")
    axes = [{"coordinate": mechanism.model._coordinate(label), "from": a, "to": b, "steps": values - 1}
            for label, (a, b, values) in over.items()]
    name = ffi.new("char[]", (point or "").encode())
    definition = ffi.new("km_space_map_def *", {"axis": axes, "has_point": point is not None, "point_name": name,
                                                "frame": mechanism.model._frame(point) if point is not None else 0,
                                                "own_sheet": own, "within_limits": limits,
                                                "least_clearance": float(clearance or 0.0)})
    locked = ffi.new("int[]", [axis["coordinate"] for axis in axes])
    with mechanism.model._reading(), state._using():
        figures, pairs = _map_parts(mechanism, state, ask, locked, clearance)
        definition.figures, definition.clearance = figures, pairs
        with _map_store(mechanism, state, definition, seed, store, replace):
            status = lib.km_space_map_find(mechanism._c, state._c, definition, seed, watch.call, watch.context, modes, found, error)
    watch.finish()
    check(status, error)
    return SpaceMap(table_of(found.cells, found), table_of(found.curves, found), found.sheet_count, found.curve_count,
                    modes.is_complete, _workspace(found) if point is not None else None)


class TurningPoint(NamedTuple):
    """A critical value of a design's number. kind: "crossing" (circuits join or part), "isolated" (a circuit appears or
    vanishes) or "cusp" (two dead points meet). driver: its value there, in the model's unit."""

    number: float
    driver: float
    kind: str
    curve: int


class TurningInterval(NamedTuple):
    """What holds between two critical values, found in the middle. defined: the file can be read with the number.
    assembled: the model's circuit is there. turns: the driver goes fully round on it; else it swings from low to high.
    dead_points: their number in all circuits."""

    start: float
    end: float
    defined: bool
    assembled: bool
    turns: bool
    low: float
    high: float
    dead_points: int


class Turning(NamedTuple):
    """Dead points of a driver over a number of the design. curves: points of the curves of dead points. complete: circuits
    were followed from all assembly modes of the model."""

    intervals: Tuple[TurningInterval, ...]
    points: Tuple[TurningPoint, ...]
    curves: Table
    curve_count: int
    complete: bool


def turning(mechanism: Mechanism, state: State, driver: str, path: str, low: float, high: float, steps: int, seed: int,
            progress: Progress) -> Turning:
    """Dead points of the driver over the number at `path` of the model's file."""
    error, watch = new_error(), Watch(progress)
    found = ffi.gc(ffi.new("km_turning *"), lib.km_turning_free)
    if not mechanism.model.file:
        raise UsageError("the model has no file, from which its number could be varied; expected one that was loaded")
    file, number = ffi.new("char[]", mechanism.model.file.encode()), ffi.new("char[]", path.encode())
    definition = ffi.new("km_turning_def *", {"driver": mechanism.model._coordinate(driver), "file": file, "path": number,
                                              "from": low, "to": high, "steps": steps, "seed": seed})
    with mechanism.model._reading(), state._using():
        status = lib.km_turning_find(mechanism._c, state._c, definition, watch.call, watch.context, found, error)
    watch.finish()
    check(status, error)
    intervals = tuple(TurningInterval(getattr(at, "from"), at.to, at.is_defined, at.is_assembled, at.turns, at.low, at.high,
                                      at.dead_points)
                      for at in (found.intervals[i] for i in range(found.interval_count)))
    points = tuple(TurningPoint(at.number, at.driver, text_of(lib.km_turning_kind_name(at.kind)), at.curve)
                   for at in (found.points[i] for i in range(found.point_count)))
    return Turning(intervals, points, table_of(found.curves, found), found.curve_count, found.is_complete)



class SpaceVolume(NamedTuple):
    """The size of a point's workspace: a volume, or with dimension 2 an area in a plane; with standard error and 95 % interval. table:
    point. x y z, reached (1, 0, -1: undecided), q. of every coordinate; a row for each sample. axes and box: unit vectors, and
    (from, to) along each. picture: its views along the axes, save("name.svg")."""

    dimension: int
    volume: float
    standard_error: float
    low: float
    high: float
    samples: int
    reached: int
    not_reached: int
    undecided: int
    axes: Tuple[Tuple[float, float, float], ...]
    box: Tuple[Tuple[float, float], ...]
    table: Table
    complete: bool
    picture: Picture


def space_volume(mechanism: Mechanism, state: State, point: str, samples: int, own: bool, limits: bool, clearance: Optional[float],
                 seed: int, jobs: int, progress: Progress) -> SpaceVolume:
    """The size of the workspace of "body/frame"."""
    error, watch = new_error(), Watch(progress)
    found = ffi.gc(ffi.new("km_space_volume *"), lib.km_space_volume_free)
    name = ffi.new("char[]", point.encode())
    definition = ffi.new("km_space_volume_def *", {"frame": mechanism.model._frame(point), "point_name": name, "own_circuit": own,
                                                   "within_limits": limits, "samples": samples, "seed": seed, "jobs": jobs,
                                                   "least_clearance": float(clearance or 0.0)})
    with mechanism.model._reading(), state._using():
        definition.clearance = pairs = _kept_pairs(mechanism, state, clearance)
        status = lib.km_space_volume_find(mechanism._c, state._c, definition, watch.call, watch.context, found, error)
    watch.finish()
    check(status, error)
    sides = range(found.dimension)

    def draw(format: int, out: Any, error: Any) -> int:
        return lib.km_space_volume_picture(found, ffi.new("char[]", f"Workspace of {point}".encode()), format, out, error)

    return SpaceVolume(found.dimension, found.volume, found.standard_error, found.low, found.high, found.samples, found.reached,
                       found.not_reached, found.undecided, tuple(tuple(found.axis[k]) for k in sides),
                       tuple((found.box_low[k], found.box_high[k]) for k in sides), table_of(found.points, found), found.is_complete,
                       Picture(draw))


class SpacePath(NamedTuple):
    """A path of the drivers. outcome: "found", "separated" (the determinant of the input has opposite signs at both ends: every path
    passes a singularity), "end" (an end isn't allowed), "not found" or "stopped" (progress returned False). table: s, q. of the drivers and of the
    others, sigma.input; a row for each step. motion: t from 0 to 1, q. of the drivers, at equal steps of time, at rest at both ends. smooth:
    the drivers turn no corner. least_margin: infinite where the drivers move no loop. explored: tree (1: from the start, 2: from the end),
    parent (a row; -1: an end), the configuration; a row for each configuration of a search that found no path so far."""

    outcome: str
    table: Table
    length: float
    least_margin: float
    straight: bool
    configurations: int
    motion: Table
    smooth: bool
    explored: Table


def space_path(mechanism: Mechanism, state: State, to: Union[State, Mapping[str, float]], drivers: Optional[Sequence[str]], margin: float,
        ignore_limits: bool, seed: int, progress: Progress) -> SpacePath:
    """A path to a state, or to values of the drivers."""
    error, watch = new_error(), Watch(progress)
    found = ffi.gc(ffi.new("km_space_path *"), lib.km_space_path_free)
    model = mechanism.model
    if drivers is None and isinstance(to, State):
        actuators = [lib.km_model_actuator(model._c, i) for i in range(lib.km_model_actuator_count(model._c))]
    else:
        actuators = [model._coordinate(label) for label in (to if drivers is None else drivers)]
    wanted = ffi.new("int[]", actuators)
    if isinstance(to, State):
        place = ffi.new("double[]", [float(value) for value in to.coordinates])
        end = {"to": place}
    else:
        values = {model._coordinate(label): float(value) for label, value in to.items()}
        if set(values) != set(actuators):
            raise UsageError("the end states other joints than the drivers; expected a value for each driver")
        place = ffi.new("double[]", [values[c] for c in actuators])
        end = {"to_drivers": place}
    definition = ffi.new("km_space_path_def *", {"drivers": wanted, "driver_count": len(actuators), "margin": margin,
                                          "ignore_limits": ignore_limits, "seed": seed, **end})
    with model._reading(), state._using():
        status = lib.km_space_path_find(mechanism._c, state._c, definition, watch.call, watch.context, found, error)
    watch.finish()
    if status != lib.KM_CANCELLED:
        check(status, error)
    return SpacePath(text_of(lib.km_space_path_outcome_name(found.outcome)), table_of(found.table, found), found.length,
               found.least_margin, found.is_straight, found.configurations, table_of(found.motion, found), found.is_smooth, table_of(found.explored, found))
