"""Models by calls: the definitions of kmech/build.h with Python's words."""
from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence

import numpy

from ._kmech import ffi, lib
from .errors import UsageError, bytes_of, check, new_error
from .model import Model
from .question import number, numbers

TYPES = {"Rx": lib.KM_RX, "Ry": lib.KM_RY, "Rz": lib.KM_RZ, "Tx": lib.KM_TX, "Ty": lib.KM_TY, "Tz": lib.KM_TZ,
         "revolute": lib.KM_RZ, "prismatic": lib.KM_TX, "rigid": lib.KM_RIGID, "spherical": lib.KM_SPHERICAL,
         "float": lib.KM_FLOAT, "cylindrical": lib.KM_CYLINDRICAL, "universal": lib.KM_UNIVERSAL,
         "planar": lib.KM_PLANAR, "screw": lib.KM_SCREW}
_SEVERAL = {"rigid": 0, "spherical": 3, "float": 6, "cylindrical": 2, "universal": 2, "planar": 3}  # others have one
_PER_COORDINATE = ("position", "velocity", "damping", "low", "high", "max_rate", "max_force", "armature",
                   "constant_friction")
_SINGLE = ("pitch", "friction", "friction_radius", "stiction_velocity", "stop_stiffness", "stop_damping")


class Builder:
    """Adds bodies, frames and joints one by one, and gives the same model that a file would:

        b = kmech.Builder(angle="degrees", length="millimeters")
        b.body("crank", mass=0.5)
        b.frame("crank", "tip", T=[30, 0, 0])
        b.joint("A", "Rz", "fixed", "crank", position=20)
        model = b.finish()
    """

    def __init__(self, *, angle: str = "radians", length: str = "meters", mass: str = "kilograms",
                 time: str = "seconds", force: str = "newtons", gravity: Sequence[float] = (0, 0, 0),
                 characteristic_length: float = 0.0, closure_tolerance: float = 0.0) -> None:
        out, self._error = ffi.new("km_builder **"), new_error()
        check(lib.km_builder_create(out, self._error), self._error)
        self._c = ffi.gc(out[0], lib.km_builder_free)
        self._bodies = {"fixed": lib.km_builder_fixed(self._c)}
        self._frames: dict[tuple[str, str], Any] = {}
        self._joints: dict[str, Any] = {}
        self._freedoms: dict[str, int] = {}
        words = [ffi.new("char[]", bytes_of(w, "unit")) for w in (angle, length, mass, time, force)]
        settings = ffi.new("km_settings_def *", lib.km_settings_default())
        settings.angle, settings.length, settings.mass, settings.time, settings.force = words
        settings.gravity = numbers(gravity, 3, "gravity")
        settings.characteristic_length = number(characteristic_length, "characteristic_length")
        settings.closure_tolerance = number(closure_tolerance, "closure_tolerance")
        check(lib.km_model_set(self._c, settings, self._error), self._error)

    def _alive(self) -> None:
        if self._c is None:
            raise UsageError("the model is finished; expected a new Builder")

    def _body(self, name: Any) -> Any:
        bytes_of(name, "body")
        if name not in self._bodies:
            raise UsageError(f"\"{name}\" names no body; expected one of {list(self._bodies)}")
        return self._bodies[name]

    def _frame(self, path: Any) -> Any:
        if isinstance(path, str):
            body, _, frame = path.partition("/") if path not in self._bodies else (path, "", "")
        else:
            body, frame = path
        if not frame or frame == "origin":
            return lib.km_builder_origin(self._c, self._body(body))
        if (body, frame) not in self._frames:
            raise UsageError(f"\"{body}/{frame}\" names no frame of this model")
        return self._frames[body, frame]

    def body(self, name: str, *, mass: float = 0.0, center: Sequence[float] = (0, 0, 0),
             inertia: Sequence[float] = (0, 0, 0, 0, 0, 0)) -> "Builder":
        """Adds a body: mass, centre of mass, inertia about it (Ixx Iyy Izz Ixy Iyz Izx)."""
        self._alive()
        kept, out = ffi.new("char[]", bytes_of(name, "name")), ffi.new("km_body_id *")
        d = ffi.new("km_body_def *", lib.km_body_default())
        d.name, d.mass = kept, number(mass, "mass")
        d.center_of_mass, d.inertia = numbers(center, 3, "center"), numbers(inertia, 6, "inertia")
        check(lib.km_model_add_body(self._c, d, out, self._error), self._error)
        self._bodies[name] = out[0]
        return self

    def frame(self, body: str, name: str, T: Sequence[float] = (0, 0, 0), R: Optional[Any] = None) -> "Builder":
        """Adds a frame to a body: its origin, and its rotation as three rows."""
        self._alive()
        kept, out = ffi.new("char[]", bytes_of(name, "name")), ffi.new("km_frame_id *")
        d = ffi.new("km_frame_def *", lib.km_frame_default())
        d.name, d.T = kept, numbers(T, 3, "T")
        if R is not None:
            d.R = numbers(numpy.ravel(R), 9, "R")
        check(lib.km_model_add_frame(self._c, self._body(body), d, out, self._error), self._error)
        self._frames[body, name] = out[0]
        return self

    def joint(self, name: str, type: str, parent: Any, child: Any, **values: Any) -> "Builder":
        """Adds a joint between two frames ("body" or "body/frame"). values: position, velocity, damping, low, high,
        max_rate, max_force, armature, constant_friction (a number or one for each coordinate); pitch, friction,
        friction_radius, stiction_velocity, stop_stiffness, stop_damping."""
        self._alive()
        if type not in TYPES:
            raise UsageError(f"type: found {type!r}; expected one of {', '.join(TYPES)}")
        kept, out = ffi.new("char[]", bytes_of(name, "name")), ffi.new("km_joint_id *")
        d = ffi.new("km_joint_def *", lib.km_joint_default())
        freedom = _SEVERAL.get(type, 1)
        d.name, d.type, d.parent, d.child = kept, TYPES[type], self._frame(parent), self._frame(child)
        for key, value in values.items():
            if key in _SINGLE:
                setattr(d, key, number(value, key))
            elif key in _PER_COORDINATE:
                given = [number(value, key)] if not hasattr(value, "__iter__") else [number(v, key) for v in value]
                if len(given) != freedom:
                    raise UsageError(f"{key}: found {len(given)} number{'s' * (len(given) != 1)}; "
                                     f"expected {freedom}, one a coordinate")
                for k, x in enumerate(given):
                    getattr(d, key)[k] = x
            else:
                raise TypeError(f"joint: there is no value {key!r}; expected {', '.join(_PER_COORDINATE + _SINGLE)}")
        check(lib.km_model_add_joint(self._c, d, out, self._error), self._error)
        self._joints[name], self._freedoms[name] = out[0], freedom
        return self

    def _ref(self, joint: Any) -> dict[str, Any]:
        label, _, rest = joint.partition("[") if isinstance(joint, str) and joint not in self._joints else (joint, "", "")
        if label not in self._joints:
            raise UsageError(f"{joint!r} names no joint; expected one of {list(self._joints)}")
        freedom, index = self._freedoms[label], rest[:-1]
        if not rest and freedom == 1:
            return {"joint": self._joints[label], "index": 0}
        if not (rest.endswith("]") and index.isdigit() and int(index) < freedom):
            expected = f"{label}[0] to {label}[{freedom - 1}]" if freedom else "a joint that moves"
            raise UsageError(f"{joint!r}: joint {label!r} has {freedom} coordinate{'s' * (freedom != 1)}; expected {expected}")
        return {"joint": self._joints[label], "index": int(index)}

    def couple(self, name: str, ratios: Optional[Mapping[str, float]] = None, *, constant: Optional[float] = None,
               follower: Optional[str] = None, leader: Optional[str] = None,
               polynomial: Optional[Sequence[float]] = None) -> "Builder":
        """Σ ratio · q = constant, or follower = Σ c_k leader^k; angles in radians."""
        self._alive()
        kept = ffi.new("char[]", bytes_of(name, "name"))
        d = ffi.new("km_coupling_def *", {"name": kept})
        if (ratios is None) == (polynomial is None) or (polynomial is not None and constant is not None):
            raise UsageError("a coupling: expected ratios, perhaps with a constant, or follower, leader and polynomial")
        if ratios is not None:
            refs = ffi.new("km_coordinate_ref[]", [self._ref(j) for j in ratios])
            values = ffi.new("double[]", [number(r, "ratio") for r in ratios.values()])
            d.count, d.coordinates, d.ratios = len(ratios), refs, values
            if constant is not None:
                d.constant_given, d.constant = True, number(constant, "constant")
        else:
            if follower is None or leader is None:
                raise UsageError("a polynomial coupling: expected follower and leader")
            refs = ffi.new("km_coordinate_ref[]", [self._ref(follower), self._ref(leader)])
            values = ffi.new("double[]", [number(c, "polynomial") for c in polynomial])
            d.count, d.coordinates, d.polynomial, d.polynomial_count = 2, refs, values, len(values)
        check(lib.km_model_add_coupling(self._c, d, self._error), self._error)
        return self

    def load(self, name: str, frame: Any, force: Sequence[float] = (0, 0, 0), torque: Sequence[float] = (0, 0, 0),
             turning: bool = False) -> "Builder":
        """A force and a torque at a frame, along the inertial axes or turning with it."""
        self._alive()
        kept = ffi.new("char[]", bytes_of(name, "name"))
        d = ffi.new("km_load_def *", {"name": kept, "frame": self._frame(frame), "force": numbers(force, 3, "force"),
                                      "torque": numbers(torque, 3, "torque"), "turning": bool(turning)})
        check(lib.km_model_add_load(self._c, d, self._error), self._error)
        return self

    def actuator(self, joint: str) -> "Builder":
        """Lists a joint among the actuators that hold the mechanism."""
        self._alive()
        check(lib.km_model_add_actuator(self._c, self._ref(joint), self._error), self._error)
        return self

    def finish(self) -> Model:
        """Checks the whole and hands the model over; the builder is then empty."""
        self._alive()
        out, builder = ffi.new("km_model **"), self._c
        self._c = None
        check(lib.km_builder_finish(builder, out, self._error), self._error)
        return Model._of(out[0])
