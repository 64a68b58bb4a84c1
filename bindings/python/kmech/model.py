"""Models: read from files and texts, built by calls, changed, written."""
from __future__ import annotations

import threading
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional, Sequence, Union

import numpy

from ._kmech import ffi, lib
from .errors import (Message, ModelError, ModelWarning, UsageError, bytes_of, check, messages_of, new_error, read_file, text_of)
from .picture import taken
from .question import Answer, add_methods, number, numbers


def load(path: Union[str, Path], *, floating: bool = False, vary: Optional[Mapping[str, float]] = None,
         closure_tolerance: Optional[float] = None, exact: bool = False) -> "Model":
    """Reads a model from a file: JSON of the model format, URDF, MJCF or SDF, told by the content.

    floating: what a robot description leaves untied is free to move. vary: other values for numbers of the file, by
    their paths ("crank.tip.x", a parameter's name); JSON only. closure_tolerance: instead of the file's. exact: rounded
    numbers are taken as written; otherwise those of the nearest mechanism that moves are used, if rounding explains the
    difference (Model.roundings).
    Raises ModelError with the place in the file, and warns with ModelWarning."""
    return Model(read_file(path), file=str(path), floating=floating, vary=vary, closure_tolerance=closure_tolerance,
                 exact=exact)


def from_string(text: Union[str, bytes], *, floating: bool = False, vary: Optional[Mapping[str, float]] = None,
                file: Optional[str] = None, closure_tolerance: Optional[float] = None, exact: bool = False) -> "Model":
    """Reads a model from a text. `file`: where it is from, for meshes and files that it names."""
    return Model(text, file=file, floating=floating, vary=vary, closure_tolerance=closure_tolerance, exact=exact)


@dataclass(frozen=True)
class NumberChange:
    """A number of the file that was replaced: its place, values as written and used, change in units of its last digit."""

    place: str
    written: float
    nearest: float
    digits: float


@dataclass(frozen=True)
class Rounding:
    """Verdict on the rounded numbers of one substructure.

    verdict: "exact" (nothing to explain), "found" (numbers within half a last digit give `mobility`), "beyond" (rounding
    doesn't explain the gap: the numbers stand as written). closes: the loops close as written. changes: what was
    replaced."""

    substructure: int
    verdict: str
    closes: bool
    mobility_as_written: int
    mobility: int
    changes: tuple[NumberChange, ...]

    @classmethod
    def _of(cls, c: Any, found: Any) -> "Rounding":
        changes = (found.change[i] for i in range(found.change_count))
        return cls(c.substructure, ("exact", "found", "beyond")[c.verdict], c.closes, c.mobility_as_written, c.mobility,
                   tuple(NumberChange(text_of(n.place), n.written, n.nearest, n.digits) for n in changes
                         if n.substructure == c.substructure))


class Model:
    """What the user wrote: bodies, joints and couplings, with units and defaults.

    Every kind of question is a method of it (Model.mobility, Model.advantage, Model.forces …), asked at the model's own
    pose; Mechanism has the same ones."""

    def __init__(self, text: Union[str, bytes], *, file: Optional[str] = None, floating: bool = False,
                 vary: Optional[Mapping[str, float]] = None, closure_tolerance: Optional[float] = None,
                 exact: bool = False) -> None:
        if not isinstance(text, (str, bytes, bytearray)):
            raise TypeError(f"text: found {type(text).__name__}; expected the text of a model")
        self._source = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else bytes(text)
        self._read_with = {"file": file, "floating": bool(floating), "vary": dict(vary or {}),
                           "closure_tolerance": closure_tolerance, "exact": bool(exact)}
        self.file = file
        messages = ffi.gc(lib.km_messages_create(), lib.km_messages_free)
        out, error = ffi.new("km_model **"), new_error()
        status = lib.km_model_read_as(self._source, len(self._source), self._definition(), messages, out, error)
        self.roundings: list[Rounding] = []
        if status == lib.KM_OK and not exact:
            found = ffi.gc(ffi.new("km_idealisation *"), lib.km_idealisation_free)
            status = lib.km_model_idealise(out[0], False, messages, found, error)
            self.roundings = [Rounding._of(found.verdict[i], found) for i in range(found.count)]
        self.messages: list[Message] = messages_of(messages)
        try:
            check(status, error)
        except ModelError as bad:
            bad.messages = self.messages
            raise
        self._take(out[0])
        for message in self.messages:
            if message.severity == "warning":
                warnings.warn(f"{file or 'model'}: {message.text}", ModelWarning, stacklevel=3)

    def _definition(self) -> Any:
        given = self._read_with
        file = ffi.new("char[]", bytes_of(given["file"], "file")) if given["file"] is not None else ffi.NULL
        paths = [ffi.new("char[]", bytes_of(path, "vary")) for path in given["vary"]]
        values = [{"path": p, "value": number(v, "vary")} for p, v in zip(paths, given["vary"].values())]
        assignments = ffi.new("km_assignment[]", values) if values else ffi.NULL
        tolerance = given["closure_tolerance"]
        tolerance = number(tolerance, "closure_tolerance") if tolerance is not None else 0.0
        self._kept = (file, paths, assignments)
        return ffi.new("km_read_def *", {"file": file, "assignments": assignments, "assignment_count": len(values),
                                         "floating": given["floating"], "closure_tolerance": tolerance})

    def _take(self, pointer: Any) -> None:
        self._c = ffi.gc(pointer, lib.km_model_free)
        self._lock, self._readers, self._changes = threading.Lock(), 0, 0

    @classmethod
    def _of(cls, pointer: Any) -> "Model":
        """A model that was built by calls."""
        model = cls.__new__(cls)
        model._source, model.file, model.messages, model.roundings = None, None, [], []
        model._take(pointer)
        return model

    @contextmanager
    def _reading(self) -> Iterator[None]:
        with self._lock:
            self._readers += 1
        try:
            yield
        finally:
            with self._lock:
                self._readers -= 1

    @contextmanager
    def _changing(self) -> Iterator[None]:
        with self._lock:
            if self._readers:
                raise UsageError("the model is in use by another thread; expected to change it when no work is under way")
            yield
            self._changes += 1

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return Path(self.file).stem if self.file else "model"

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies; the first is the inertial frame, "fixed"."""
        return [text_of(lib.km_model_body_name(self._c, b)) for b in range(lib.km_model_body_count(self._c) + 1)]

    @property
    def joints(self) -> list[str]:
        """Labels of the joints, in the order of the file."""
        return [text_of(lib.km_model_joint_label(self._c, j)) for j in range(lib.km_model_joint_count(self._c))]

    @property
    def coordinates(self) -> list[str]:
        """Labels of the coordinates: of a joint with several, "label[k]"."""
        return [text_of(lib.km_model_coordinate_label(self._c, c))
                for c in range(lib.km_model_coordinate_count(self._c))]

    @property
    def units(self) -> dict[str, str]:
        """The unit of every coordinate: {"A": "rad"}."""
        return {label: text_of(lib.km_model_coordinate_unit(self._c, c)) for c, label in enumerate(self.coordinates)}

    @property
    def frames(self) -> list[str]:
        """The frames, as "body/frame"."""
        bodies = self.bodies
        return [f"{bodies[lib.km_model_frame_body(self._c, f)]}/{text_of(lib.km_model_frame_name(self._c, f))}"
                for f in range(lib.km_model_frame_count(self._c))]

    @property
    def poses(self) -> list[str]:
        """The poses that the model names."""
        return [text_of(lib.km_model_pose_name(self._c, p)) for p in range(lib.km_model_pose_count(self._c))]

    @property
    def about(self) -> dict[str, str]:
        """What the model says about itself for reports: those of title, author, date, notes and logo that it states."""
        words = {key: lib.km_model_word_text(self._c, i)
                 for i, key in enumerate(("title", "author", "date", "notes", "logo"))}
        return {key: text_of(word) for key, word in words.items() if word != ffi.NULL}

    @property
    def sha256(self) -> str:
        """Of the bytes that were read."""
        return text_of(lib.km_model_sha256(self._c))

    def limits(self, label: str) -> tuple[float, float]:
        """Limits of a coordinate, infinite where there is none."""
        low, high = ffi.new("double *", -float("inf")), ffi.new("double *", float("inf"))
        lib.km_model_coordinate_limits(self._c, self._coordinate(label), low, high)
        return low[0], high[0]

    def _coordinate(self, label: Any) -> int:
        out, error = ffi.new("int *"), new_error()
        check(lib.km_model_find_coordinate(self._c, bytes_of(label, "joint"), out, error), error)
        return out[0]

    def _frame(self, path: Any) -> int:
        if isinstance(path, (tuple, list)):
            names = [bytes_of(part, "frame") for part in path]
        else:
            names = bytes_of(path, "frame").split(b"/")
        parts = [ffi.new("char[]", name) for name in names]
        out, error = ffi.new("int *"), new_error()
        check(lib.km_model_find_frame(self._c, ffi.new("const char *[]", parts), len(parts), out, error), error)
        return out[0]

    def _body(self, name: Any) -> int:
        bytes_of(name, "body")
        if self.bodies.count(name) != 1:
            raise UsageError(f"\"{name}\" names {self.bodies.count(name) or 'no'} bodies; expected one of {self.bodies[1:]}")
        return self.bodies.index(name)

    def vary(self, **values: float) -> "Model":
        """The variant with other numbers: parameters by their names, other numbers by paths, as
        model.vary(crank=0.3) or model.vary(**{"A.limits.1": 90})."""
        if self._source is None:
            raise UsageError("this model was built by calls: there is no text whose numbers could change")
        return Model(self._source, **{**self._read_with, "vary": {**self._read_with["vary"], **values}})

    def set_position(self, label: str, value: float) -> None:
        """The value that a coordinate starts the assembly from."""
        self._edit(lib.km_model_set_position, self._coordinate(label), number(value, "value"))

    def set_limits(self, label: str, low: float, high: float) -> None:
        """Limits of a coordinate; infinite ones are none."""
        self._edit(lib.km_model_set_limits, self._coordinate(label), number(low, "low"), number(high, "high"))

    def set_frame(self, path: str, T: Sequence[float], R: Optional[Any] = None) -> None:
        """Moves a frame on its body: T, and R as three rows."""
        rows = ffi.NULL if R is None else ffi.new("double[9]", numbers(numpy.ravel(R), 9, "R"))
        self._edit(lib.km_model_set_frame, self._frame(path), ffi.new("double[3]", numbers(T, 3, "T")), rows)

    def set_mass(self, body: str, mass: float, center: Optional[Sequence[float]] = None,
                 inertia: Optional[Sequence[float]] = None) -> None:
        """Mass, centre of mass and inertia (Ixx Iyy Izz Ixy Iyz Izx) of a body; what is None stays."""
        c = ffi.NULL if center is None else ffi.new("double[3]", numbers(center, 3, "center"))
        i = ffi.NULL if inertia is None else ffi.new("double[6]", numbers(inertia, 6, "inertia"))
        self._edit(lib.km_model_set_mass, self._body(body), number(mass, "mass"), c, i)

    def _edit(self, function: Any, *values: Any) -> None:
        error = new_error()
        with self._changing():
            check(function(self._c, *values, error), error)

    def to_json(self, pose: Optional[Any] = None) -> str:
        """The model in its own format. pose: a State of it, whose pose is written."""
        return self._written(lib.KM_FORMAT_JSON, pose)[0].decode("utf-8", "surrogateescape")

    def save(self, path: Union[str, Path], pose: Optional[Any] = None) -> list[Message]:
        """Writes a file: .urdf, .xml (MJCF) or .sdf at a closed pose (by default that of a new mechanism), or else the
        model's own format. Meshes are named as from its folder. Returns notes on what the format can't hold."""
        path = Path(path)
        name = bytes_of(str(path), "path")
        data, notes = self._written(lib.km_model_format_of(name), pose, name)
        path.write_bytes(data)
        return notes

    def _written(self, format: int, pose: Optional[Any], file: Any = ffi.NULL) -> tuple[bytes, list[Message]]:
        if pose is None and format != lib.KM_FORMAT_JSON:
            pose = self.mechanism().state
        q = ffi.NULL
        if pose is not None:
            if getattr(getattr(pose, "mechanism", None), "model", None) is not self:
                raise TypeError("pose: expected a State of this model")
            q = ffi.new("double[]", [float(v) for v in pose.values])
        messages = ffi.gc(lib.km_messages_create(), lib.km_messages_free)
        out, error = ffi.new("km_bytes *"), new_error()
        with self._reading():
            check(lib.km_model_write_as(self._c, format, q, file, messages, out, error), error)
        return taken(out), messages_of(messages)

    def mechanism(self, *, set: Optional[Mapping[str, float]] = None,
                  hold: Optional[Mapping[str, float]] = None) -> "Any":
        """Compiles the model and brings it to a pose: its own, then moved along its branch until each coordinate of
        `set` has its value. `hold` keeps coordinates rigid, beside those of the file."""
        from .mechanism import Mechanism

        return Mechanism(self, set=set, hold=hold)

    def sweep(self, joint: Optional[str] = None, start: Optional[float] = None, stop: Optional[float] = None,
              steps: Optional[int] = None, **given: Any) -> Answer:
        """The mobility over the range of a joint, by default the one of the model's analysis."""
        return self.mechanism().sweep(joint, start, stop, steps, **given)

    def linearise(self, *, set: Optional[Mapping[str, float]] = None, hold: Optional[Mapping[str, float]] = None) -> Any:
        """The equations of motion, linearised about the initial configuration, or one with joints `set` to values."""
        return self.mechanism(set=set, hold=hold).linearise()

    def equilibrium(self, *, settle: bool = False, progress: Any = None, set: Optional[Mapping[str, float]] = None,
                    hold: Optional[Mapping[str, float]] = None) -> Any:
        """A State at rest under the model's forces, near the initial configuration. settle: lets the mechanism fall first."""
        return self.mechanism(set=set, hold=hold).equilibrium(settle=settle, progress=progress)

    def diagnose(self, *, set: Optional[Mapping[str, float]] = None, hold: Optional[Mapping[str, float]] = None,
                 progress: Any = None) -> dict[str, Any]:
        """What kmob info --format json tells at the initial configuration, or one with joints `set` to values."""
        return self.mechanism(set=set, hold=hold).diagnose(progress=progress)

    def remedies(self, *, set: Optional[Mapping[str, float]] = None, hold: Optional[Mapping[str, float]] = None,
                 progress: Any = None) -> Any:
        """Joint types that together end the redundant constraints (a RemedySet)."""
        return self.mechanism(set=set, hold=hold).remedies(progress=progress)

    def _ask(self, kind: str, here: bool, progress: Any, given: dict[str, Any]) -> Answer:
        return self.mechanism()._ask(kind, here, progress, given)

    def __repr__(self) -> str:
        return f"<model {self.name}: {len(self.bodies) - 1} bodies, {len(self.joints)} joints>"


add_methods(Model)
