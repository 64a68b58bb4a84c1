"""Steps of a motion over time, with inputs that a program sets between them."""
from __future__ import annotations

from typing import Any, Callable, Mapping, NamedTuple, Optional, Sequence

import numpy

from ._kmech import ffi, lib
from .errors import UsageError, bytes_of, check, new_error
from .mechanism import Mechanism
from .model import Model
from .question import number, numbers

_INTEGRATORS = ("adams", "bdf", "fixed")


class FrameMotion(NamedTuple):
    """Motion of a frame along the fixed axes: origin, rotation matrix, velocity of the origin, angular velocity (rad)."""

    origin: numpy.ndarray
    axes: numpy.ndarray
    velocity: numpy.ndarray
    angular_velocity: numpy.ndarray


class Crossing(NamedTuple):
    """A joint that passed a value: time and sense (+1: upwards)."""

    joint: str
    value: float
    time: float
    sense: int


class PassedLimit(NamedTuple):
    """A joint that passed a limit where no stop acts: the limit, the time at the end of that step, the largest excess."""

    joint: str
    upper: bool
    limit: float
    time: float
    beyond: float


class _Forces:
    """Forces of a function, in every evaluation of the equations of motion."""

    def __init__(self, function: Callable[..., Any], model: Model, frames: dict[str, int]) -> None:
        self.function, self.model, self.frames = function, model, frames
        self.count = len(model.coordinates)
        self.raised: Optional[BaseException] = None

    def add(self, sample: Any, joint_forces: Any, wrenches: Any) -> None:
        size = 8 * self.count
        q = numpy.frombuffer(ffi.buffer(sample.q, size)) if size else numpy.zeros(0)
        v = numpy.frombuffer(ffi.buffer(sample.rate, size)) if size else numpy.zeros(0)
        for name, value in (self.function(sample.time, q, v) or {}).items():
            if name in self.frames:
                wrenches[self.frames[name]] = numbers(value, 6, f"forces: {name}")
            else:
                joint_forces[self.model._coordinate(name)] = number(value, f"forces: {name}")


@ffi.def_extern(name="kmech_python_forces", error=False)
def _forces(context: Any, sample: Any, joint_forces: Any, wrenches: Any) -> bool:
    forces = ffi.from_handle(context)
    try:
        forces.add(sample, joint_forces, wrenches)
        return True
    except BaseException as raised:
        forces.raised = raised
        return False


class Session:
    """A motion over time that a program advances step by step.

    step: length of a step in the model's time unit (default 1 ms). integrator: "fixed" (bounded work in every step),
    "adams" or "bdf". frames: "body/frame" on which loads act and whose motion is read. set, rate: values and rates of
    joints at the start. stop: values of joints at which a step ends early (crossings). limit_stops: stiffness and damping
    of stops at the limits of joints without one. forces: function(time, q, v) of
    the time and of arrays of all coordinates and rates, called in every evaluation; it returns {joint: force along +q} and
    {frame of `frames`: [force, moment], six numbers}, which are added to the model's forces; a continuous function of its
    arguments. A session is used by one thread at a time."""

    def __init__(self, model: Model, *, step: Optional[float] = None, integrator: str = "fixed",
                 frames: Sequence[str] = (), set: Optional[Mapping[str, float]] = None,
                 rate: Optional[Mapping[str, float]] = None, hold: Optional[Mapping[str, float]] = None,
                 stop: Optional[Mapping[str, float]] = None, limit_stops: Optional[Sequence[float]] = None,
                 forces: Optional[Callable[..., Any]] = None) -> None:
        if integrator not in _INTEGRATORS:
            raise UsageError(f"integrator: found {integrator!r}; expected {', '.join(_INTEGRATORS)}")
        self.mechanism, self.model, self._error = Mechanism(model, set=set, hold=hold), model, new_error()
        self._frames = {name: index for index, name in enumerate(frames)}
        for label, value in (rate or {}).items():
            check(lib.km_state_set_rate(self.mechanism._c, self.mechanism.state._c, model._coordinate(label),
                                        number(value, f"rate {label}"), self._error), self._error)
        places = ffi.new("int[]", [model._frame(name) for name in frames])
        definition, out = ffi.new("km_session_def *", lib.km_session_default(model._c)), ffi.new("km_session **")
        definition.simulation.integrator = _INTEGRATORS.index(integrator)
        definition.step = definition.step if step is None else number(step, "step")
        definition.frames, definition.frame_count = places, len(frames)
        if limit_stops is not None:
            definition.limit_stop = numbers(limit_stops, 2, "limit_stops")
        self._stops = [(label, number(value, f"stop {label}")) for label, value in (stop or {}).items()]
        crossings = ffi.new("km_crossing[]", [{"coordinate": model._coordinate(label), "value": value, "stops": True}
                                              for label, value in self._stops])
        definition.simulation.crossings, definition.simulation.crossing_count = crossings, len(self._stops)
        self._forces = None if forces is None else _Forces(forces, model, self._frames)
        self._handle = ffi.new_handle(self._forces)
        if self._forces:
            user = ffi.new("km_user_forces *", {"compute": lib.kmech_python_forces, "context": self._handle,
                                                "frames": places, "frame_count": len(frames)})
            definition.user = user
        with model._reading():
            status = lib.km_session_create(self.mechanism._c, self.mechanism.state._c, definition, out, self._error)
        self._raise()
        check(status, self._error)
        self._c = ffi.gc(out[0], lib.km_session_free)
        self._state = lib.km_session_state(self._c)

    def _module(self, name: str) -> int:
        index = lib.km_model_find_module(self.model._c, bytes_of(name, "module"))
        if index < 0:
            raise UsageError(f"no force module is called {name!r}")
        return index

    def _frame(self, name: str) -> int:
        if name not in self._frames:
            raise UsageError(f"frame {name!r} isn't one of the session's: {', '.join(self._frames) or 'none'}")
        return self._frames[name]

    def force(self, joint: str, value: float) -> None:
        """Sets the force of a joint along +q, which is added to all others; for an angle force × length per radian."""
        check(lib.km_session_set_force(self._c, self.model._coordinate(joint), number(value, "force"), self._error),
              self._error)

    def load(self, frame: str, force: Sequence[float] = (0, 0, 0), torque: Sequence[float] = (0, 0, 0)) -> None:
        """Sets force and moment on a frame, along the fixed axes at its origin."""
        wrench = ffi.new("double[6]", numbers(force, 3, "force") + numbers(torque, 3, "torque"))
        check(lib.km_session_set_wrench(self._c, self._frame(frame), wrench, self._error), self._error)

    def reference(self, module: str, value: Optional[float]) -> None:
        """Sets the reference of a controller; None: that of the model."""
        given = float("nan") if value is None else number(value, "reference")
        check(lib.km_session_set_reference(self._c, self._module(module), given, self._error), self._error)

    def set_rate(self, joint: str, value: float) -> None:
        """Changes the rate of a joint now, as after an impact; the rates of others follow the loops."""
        check(lib.km_session_set_rate(self._c, self.model._coordinate(joint), number(value, "rate"), self._error),
              self._error)

    def step(self, count: int = 1) -> float:
        """Makes steps and returns the time: of the last step's end, or of the crossing that ended a step."""
        status = lib.km_session_step(self._c, count, self._error)
        self._raise()
        check(status, self._error, partial=True)
        return self.time

    def _raise(self) -> None:
        """Raises what the function of forces raised."""
        if self._forces and self._forces.raised is not None:
            raised, self._forces.raised = self._forces.raised, None
            raise raised

    @property
    def crossings(self) -> list[Crossing]:
        """Passages of the values of `stop` so far."""
        run = lib.km_session_run(self._c)
        found = [lib.km_simulation_crossing(run, i) for i in range(lib.km_simulation_crossing_count(run))]
        return [Crossing(*self._stops[c.crossing], c.time, c.sense) for c in found]

    @property
    def passed_limits(self) -> list[PassedLimit]:
        """Limits that the steps so far have passed where no stop acts."""
        found = [lib.km_session_limit(self._c, i) for i in range(lib.km_session_limit_count(self._c))]
        return [PassedLimit(self.model.coordinates[p.coordinate], p.upper, p.limit, p.time, p.beyond)
                for p in found]

    @property
    def time(self) -> float:
        """Time, in the model's unit."""
        return lib.km_session_time(self._c)

    def q(self, joint: str) -> float:
        """Value of a joint, in its unit."""
        return lib.km_state_coordinate(self._state, self.model._coordinate(joint))

    def v(self, joint: str) -> float:
        """Rate of a joint, its unit over the time unit."""
        return lib.km_state_rate(self._state, self.model._coordinate(joint))

    def a(self, joint: str) -> float:
        """Acceleration of a joint."""
        return lib.km_state_acceleration(self._state, self.model._coordinate(joint))

    def frame(self, name: str) -> FrameMotion:
        """Motion of a frame of the session."""
        m: Any = lib.km_session_frame(self._c, self._frame(name))
        vectors = [numpy.array(list(part)) for part in (m.origin, m.axes, m.velocity, m.angular_velocity)]
        return FrameMotion(vectors[0], vectors[1].reshape(3, 3), vectors[2], vectors[3])
