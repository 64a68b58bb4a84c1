"""Compiled mechanisms at a pose, and their states."""
from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import Any, Iterator, Mapping, NamedTuple, Optional, Sequence

import numpy

from ._kmech import ffi, lib
from .errors import UsageError, check, new_error
from .model import Model
from .progress import Progress
from .question import Answer, add_methods, number


class Mobility(NamedTuple):
    """What a pose's mobility is, by Kutzbach's count and by rank, with each coordinate's mobility number."""

    mobility: int
    kutzbach: int
    kutzbach_extended: int
    redundant_constraints: int
    residual: float
    numbers: dict[str, float]


class Pose(NamedTuple):
    """Where a frame is in the inertial frame: rotation (its columns are the frame's axes) and origin."""

    R: numpy.ndarray
    p: numpy.ndarray


def _holds(model: Model, values: Optional[Mapping[str, float]], what: str) -> list[dict[str, Any]]:
    if values is None:
        return []
    if not isinstance(values, Mapping):
        raise TypeError(f"{what}: found {values!r}; expected {{label: value}}")
    return [{"coordinate": model._coordinate(label), "value": number(value, f"{what} {label}")}
            for label, value in values.items()]


class State:
    """One pose of a mechanism: a workspace that one thread uses at a time."""

    def __init__(self, mechanism: "Mechanism", pointer: Any) -> None:
        self._c = ffi.gc(pointer, lib.km_state_free)
        self.mechanism, self._lock = mechanism, threading.Lock()
        self._changes = mechanism.model._changes

    @contextmanager
    def _using(self) -> Iterator[None]:
        if not self._lock.acquire(blocking=False):
            raise UsageError("this state is in use by another thread; expected one state for each thread (copy())")
        try:
            self.mechanism._check_current()
            yield
        finally:
            self._lock.release()

    @property
    def values(self) -> numpy.ndarray:
        """All coordinates, in the model's units."""
        out, error = numpy.empty(len(self.mechanism.model.coordinates)), new_error()
        with self._using():
            check(lib.km_state_coordinates(self.mechanism._c, self._c, ffi.from_buffer("double[]", out), error), error)
        return out

    def __getitem__(self, label: str) -> float:
        with self._using():
            return lib.km_state_coordinate(self._c, self.mechanism.model._coordinate(label))

    def __setitem__(self, label: str, value: float) -> None:
        error = new_error()
        with self._using():
            check(lib.km_state_set_coordinate(self.mechanism._c, self._c, self.mechanism.model._coordinate(label),
                                              number(value, label), error), error)

    def assemble(self) -> float:
        """Closes all loops from the present coordinates; returns what is left. Raises ModelError where they can't."""
        evidence, error = ffi.new("km_assembly *"), new_error()
        with self.mechanism.model._reading(), self._using():
            check(lib.km_assemble(self.mechanism._c, self._c, evidence, error), error)
        return evidence.residual

    def reach(self, **values: float) -> "State":
        """Moves along the branch until each coordinate has its value. Raises NoResult where one can't be reached."""
        return self.reach_all(values)

    def reach_all(self, values: Mapping[str, float]) -> "State":
        """The same from a mapping, for labels that are no names of Python."""
        goals, error = _holds(self.mechanism.model, values, "value"), new_error()
        sets = ffi.new("km_hold[]", goals) if goals else ffi.NULL
        with self.mechanism.model._reading(), self._using():
            check(lib.km_state_move_to(self.mechanism._c, self._c, sets, len(goals), error), error)
        return self

    def mobility(self) -> Mobility:
        """Mobility, counts and mobility numbers of this pose."""
        model, out, closed = self.mechanism.model, ffi.new("km_mobility *"), new_error()
        with model._reading(), self._using():
            check(lib.km_assemble(self.mechanism._c, self._c, ffi.NULL, closed), closed)
            check(lib.km_mobility_compute(self.mechanism._c, self._c, out), closed)
            found = {label: lib.km_mobility_number(self._c, c) for c, label in enumerate(model.coordinates)}
        return Mobility(out.mobility, out.kutzbach, out.kutzbach_extended, out.redundant_constraints, out.residual, found)

    def frame(self, path: str) -> Pose:
        """Where a frame is: "body/frame"."""
        index, out, error = self.mechanism.model._frame(path), ffi.new("km_frame_pose *"), new_error()
        with self.mechanism.model._reading(), self._using():
            lib.km_poses_compute(self.mechanism._c, self._c)
            check(lib.km_frame_place(self.mechanism._c, self._c, index, out, error), error)
        return Pose(numpy.array(list(out.R)).reshape(3, 3), numpy.array(list(out.p)))

    def jacobian(self, path: str) -> numpy.ndarray:
        """6 × coordinates: the twist (vx vy vz wx wy wz) of a frame per unit rate of each coordinate along the
        spanning tree; radians and the model's length unit, inertial axes."""
        columns = len(self.mechanism.model.coordinates)
        out, error = numpy.zeros((6, columns), order="F"), new_error()
        index = self.mechanism.model._frame(path)
        with self.mechanism.model._reading(), self._using():
            lib.km_poses_compute(self.mechanism._c, self._c)
            check(lib.km_frame_jacobian(self.mechanism._c, self._c, index,
                                        ffi.cast("double *", out.ctypes.data), error), error)
        return out

    def copy(self) -> "State":
        """Another state at the same coordinates, for another thread."""
        twin = self.mechanism.new_state()
        values, error = self.values, new_error()
        with twin._using():
            check(lib.km_state_set_coordinates(self.mechanism._c, twin._c, ffi.from_buffer("double[]", values), error),
                  error)
        twin.assemble()
        return twin

    def __repr__(self) -> str:
        return f"<state of {self.mechanism.model.name}: {dict(zip(self.mechanism.model.coordinates, self.values.tolist()))}>"


class Mechanism:
    """A compiled model, with a state at the pose that was asked for.

    Every kind of question is a method, asked from that state."""

    def __init__(self, model: Model, *, set: Optional[Mapping[str, float]] = None,
                 hold: Optional[Mapping[str, float]] = None) -> None:
        if not isinstance(model, Model):
            raise TypeError(f"model: found {type(model).__name__}; expected a Model")
        holds, sets = _holds(model, hold, "hold"), _holds(model, set, "set")
        out, state, error = ffi.new("km_mechanism **"), ffi.new("km_state **"), new_error()
        with model._reading():
            check(lib.km_mechanism_compile_at(model._c, ffi.new("km_hold[]", holds) if holds else ffi.NULL, len(holds),
                                    ffi.new("km_hold[]", sets) if sets else ffi.NULL, len(sets), out, state, error), error)
        self._c, self.model, self._changes = ffi.gc(out[0], lib.km_mechanism_free), model, model._changes
        self.state, self._turn = State(self, state[0]), threading.Lock()

    def _check_current(self) -> None:
        if self._changes != self.model._changes:
            raise UsageError("the model has changed since the mechanism was compiled; expected renumber(), or a new one")

    def renumber(self) -> None:
        """Takes over the model's numbers after they were changed, and closes the loops again."""
        error = new_error()
        with self.state._lock, self.model._reading():
            if not check(lib.km_mechanism_renumber(self._c, error), error, partial=True):
                raise UsageError("the new numbers change how a loop can move; expected to compile the model again")
            lib.km_state_restart(self.state._c)
            self._changes = self.model._changes
            check(lib.km_assemble(self._c, self.state._c, ffi.NULL, error), error)

    def new_state(self) -> State:
        """A state at the model's initial displacements, closed."""
        out, error = ffi.new("km_state **"), new_error()
        with self.model._reading():
            check(lib.km_state_create(self._c, out, error), error)
        state = State(self, out[0])
        state.assemble()
        return state

    @property
    def length(self) -> float:
        """The characteristic length, in the model's unit."""
        return lib.km_mechanism_characteristic_length(self._c, ffi.NULL)

    def sweep(self, joint: Optional[str] = None, start: Optional[float] = None, stop: Optional[float] = None,
              steps: Optional[int] = None, **given: Any) -> Answer:
        """The mobility over the range of a joint, by default the one of the model's analysis."""
        if (start is None) != (stop is None):
            raise UsageError("found one end of a range; expected both, or none")
        span = None if start is None else (start, stop)
        return self._ask("mobility", False, given.pop("progress", None), {"joint": joint, "range": span, "steps": steps, **given})

    def _ask(self, kind: str, here: bool, progress: Progress, given: dict[str, Any], state: Optional[State] = None) -> Answer:
        state = given.pop("state", None) or state or self._copy()
        if not isinstance(state, State) or state.mechanism is not self:
            raise TypeError("state: expected a state of this mechanism")
        answer = Answer(self, kind)
        answer._set(given)
        answer._ask(state, here, progress)
        return answer

    def _copy(self) -> State:
        """A state of the caller's own: threads that ask at once take turns here."""
        with self._turn:
            return self.state.copy()

    def linearise(self, state: Optional[State] = None) -> Any:
        """The equations of motion, linearised about a state (a Linear): state matrices, eigenvalues, modes, stability."""
        from .linear import linearise

        return linearise(self, state or self._copy())

    def equilibrium(self, *, settle: bool = False, progress: Progress = None, state: Optional[State] = None) -> State:
        """A state at rest under the model's forces, near the given one. settle: lets the mechanism fall first, so that the
        equilibrium is a stable one."""
        from .linear import equilibrium

        return equilibrium(self, state or self._copy(), settle, progress)

    def all_modes(self, hold: Sequence[str] = (), *, within_limits: bool = False, seed: int = 1,
                  progress: Progress = None, state: Optional[State] = None) -> Any:
        """All assembly modes with the joints of hold at a state's values (an AssemblyModes): each once, with its proof, and
        whether there are no others."""
        from .space import all_modes

        return all_modes(self, state or self._copy(), hold, within_limits, seed, progress)

    def space_map(self, over: Any, *, point: Optional[str] = None, ask: str = "mobility", own: bool = False, limits: bool = False,
                  clearance: Optional[float] = None, store: Optional[str] = None, replace: bool = False, seed: int = 1,
                  progress: Progress = None, state: Optional[State] = None) -> Any:
        """A map over two drivers, {label: (from, to, values)} (a SpaceMap): one sheet for each assembly mode at a state, and
        the singularity curves of the drivers. point: "body/frame" that moves on a plane or a sphere, with its workspace. ask: "advantage",
        "forces" or "clearance" adds these to each cell. own: the sheet of the state only. limits: leaves out cells beyond the
        joint limits; clearance: those in which bodies are nearer than so much. store: a file that keeps what is found, so that
        an equal call goes on where one was cancelled; replace: results of another map in it are deleted."""
        from .space import space_map

        return space_map(self, state or self._copy(), over, point, ask, own, limits, clearance, store, replace, seed, progress)

    def space_path(self, to: Any, *, drivers: Optional[Sequence[str]] = None, margin: float = 0.0, ignore_limits: bool = False,
            seed: int = 1, progress: Progress = None, state: Optional[State] = None) -> Any:
        """A path from a state without a singularity of the drivers: km_space_path_find. to: another State, or {driver: value} in any
        assembly mode. drivers: as many as freedoms; default: those of `to`, or the model's analysis.actuators."""
        from .space import space_path

        return space_path(self, state or self._copy(), to, drivers, margin, ignore_limits, seed, progress)

    def space_volume(self, point: str, *, samples: int = 0, own: bool = False, limits: bool = False,
                     clearance: Optional[float] = None, seed: int = 1, jobs: int = 1, progress: Progress = None,
                     state: Optional[State] = None) -> Any:
        """How large the workspace of "body/frame" is, a volume or an area in a plane (a SpaceVolume): km_space_volume_find. own: only
        configurations that a motion from the state leads to. limits: only those within the joint limits; clearance: only those in
        which bodies are not nearer than so much."""
        from .space import space_volume

        return space_volume(self, state or self._copy(), point, samples, own, limits, clearance, seed, jobs, progress)

    def turning(self, driver: str, path: str, low: float, high: float, *, steps: int = 20, seed: int = 1,
                progress: Progress = None, state: Optional[State] = None) -> Any:
        """Where the driver goes fully round, over a number of the model's file from low to high: km_turning_find. path: a
        parameter, or a number such as "crank.tip.x". Circuits are followed at steps + 1 values of it."""
        from .space import turning

        return turning(self, state or self._copy(), driver, path, low, high, steps, seed, progress)

    def diagnose(self, *, progress: Progress = None, state: Optional[State] = None) -> dict[str, Any]:
        """What kmob info --format json tells at a state: mobility, finite mobility and motions, idle freedoms, redundant
        constraints, single remedies and a set of remedies."""
        from .diagnosis import diagnose

        return diagnose(self, state or self._copy(), progress)

    def remedies(self, *, progress: Progress = None, state: Optional[State] = None) -> Any:
        """Joint types that together end the redundant constraints and keep the mobility (a RemedySet), with the changed
        model."""
        from .diagnosis import remedies

        return remedies(self, state or self._copy(), progress)

    def arm(self, effector: str, task: str = "pose") -> Any:
        """The chain of joints to a frame, as an arm."""
        from .arm import Arm

        return Arm(self, effector, task)

    def __repr__(self) -> str:
        return f"<mechanism of {self.model!r}>"


add_methods(Mechanism)
