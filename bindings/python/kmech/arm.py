"""Serial arms, and the paths that they follow."""
from __future__ import annotations

from numbers import Integral
from pathlib import Path
from typing import Any, NamedTuple, Optional, Sequence, Union

import numpy

from ._kmech import ffi, lib
from .errors import FileError, UsageError, bytes_of, check, messages_of, new_error, read_file, text_of
from .mechanism import Mechanism, Pose
from .model import Model, load
from .picture import Picture
from .progress import Progress, Watch
from .question import number, numbers
from .table import Table, table_of

TASKS = {"pose": lib.KM_TASK_POSE, "position": lib.KM_TASK_POSITION, "axis": lib.KM_TASK_AXIS}


def _pose(value: Any) -> Any:
    """A km_frame_pose from a Pose, a pair (R, p), or a 4 × 4 matrix."""
    if isinstance(value, numpy.ndarray) and value.shape == (4, 4):
        value = (value[:3, :3], value[:3, 3])
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise TypeError("pose: expected (R, p), or a 4 × 4 matrix")
    return ffi.new("km_frame_pose *", {"R": numbers(numpy.ravel(value[0]), 9, "R"), "p": numbers(numpy.ravel(value[1]), 3, "p")})


def _check_current(made: Any, model: Model, what: str) -> None:
    """Arms and studies are made of numbers, which stay when the model's change."""
    if made._changes != model._changes:
        raise UsageError(f"the model has changed since the {what} was made; expected a new one")


class Arm:
    """A chain of joints from the inertial frame to an effector frame."""

    def __init__(self, mechanism: Mechanism, effector: str, task: str = "pose") -> None:
        if task not in TASKS:
            raise UsageError(f"task: found {task!r}; expected {', '.join(TASKS)}")
        self.mechanism, out, error = mechanism, ffi.new("km_arm **"), new_error()
        with mechanism.model._reading(), mechanism.state._using():
            check(lib.km_arm_create(mechanism._c, mechanism.state._c, mechanism.model._frame(effector), TASKS[task], out,
                                    error), error)
        self._c, self._changes = ffi.gc(out[0], lib.km_arm_free), mechanism.model._changes

    def _current(self) -> Any:
        """The arm, if it still is that of its model."""
        _check_current(self, self.mechanism.model, "arm")
        return self._c

    @property
    def coordinates(self) -> list[str]:
        """Labels of the arm's coordinates, base first."""
        labels = self.mechanism.model.coordinates
        return [labels[lib.km_arm_coordinate(self._c, k)] for k in range(lib.km_arm_coordinates(self._c))]

    @property
    def length(self) -> float:
        """The length by which lengths are divided where they meet angles."""
        return lib.km_arm_length(self._c)

    def _q(self, q: Sequence[float]) -> Any:
        return ffi.new("double[]", numbers(q, lib.km_arm_coordinates(self._c), "q"))

    def place(self, q: Sequence[float]) -> Pose:
        """The effector's pose at q."""
        out, error = ffi.new("km_frame_pose *"), new_error()
        check(lib.km_arm_place(self._current(), self._q(q), out, error), error)
        return Pose(numpy.array(list(out.R)).reshape(3, 3), numpy.array(list(out.p)))

    def jacobian(self, q: Sequence[float]) -> numpy.ndarray:
        """rows × coordinates, of the effector's origin along the inertial axes."""
        J, error = numpy.zeros((lib.km_arm_rows(self._c), lib.km_arm_coordinates(self._c)), order="F"), new_error()
        check(lib.km_arm_jacobian(self._current(), self._q(q), ffi.cast("double *", J.ctypes.data), error), error)
        return J

    def solve(self, pose: Any, near: Sequence[float], seed: int = 1, progress: Progress = None) -> numpy.ndarray:
        """Inverse kinematics: the joints that reach a pose, nearest to `near`. Raises NoResult out of reach."""
        watch, error = Watch(progress), new_error()
        q = numpy.empty(lib.km_arm_coordinates(self._c))
        status = lib.km_arm_solve(self._current(), _pose(pose), self._q(near), _seed(seed), watch.call, watch.context,
                                  ffi.from_buffer("double[]", q), error)
        watch.finish()
        check(status, error)
        return q


def _whole(value: Any, what: str, least: int, most: int, expected: str) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= value <= most:
        raise UsageError(f"{what}: found {value!r}; expected {expected}")
    return int(value)


def _seed(seed: Any) -> int:
    return _whole(seed, "seed", 0, 2 ** 63 - 1, "a whole number of at least 0")


class Summary(NamedTuple):
    """What a track comes to. Effort and energy are those of joint forces by inverse dynamics, NaN without masses."""

    complete: bool
    objective_min: float
    objective_mean: float
    joint_travel: float
    limit_margin: float
    error_position: float
    error_rotation: float
    effort: float
    relative_effort: float
    energy: float
    positive_work: float


class Track:
    """How an arm follows a path by one method."""

    def __init__(self, study: "Study", method: int, pointer: Any, complete: bool) -> None:
        self._c, self.study, self.complete = ffi.gc(pointer, lib.km_track_free), study, complete
        self.method = text_of(lib.km_study_plan(study._c, method).method.word)

    @property
    def table(self) -> Table:
        """The rows: step, s, joints, rates, objectives."""
        return table_of(lib.km_track_rows(self._c), self._c)

    @property
    def summary(self) -> Summary:
        s = lib.km_track_summarise(self._c)
        return Summary(self.complete, s.objective_min, s.objective_mean, s.joint_travel, s.limit_margin,
                       s.error_position, s.error_rotation, s.effort, s.relative_effort, s.energy, s.positive_work)

    def plot(self) -> Picture:
        """The plots that kredund draws of a track."""
        name = ffi.new("char[]", bytes_of(self.study.model.name, "name"))

        def draw(format: int, out: Any, error: Any) -> int:
            items = ffi.new("km_track *[]", [self._c])
            tracks = ffi.new("km_tracks *", [self.study._c, name, name, items, 1])
            return lib.km_tracks_picture(tracks, format, out, error)

        return Picture(draw)

    def _repr_svg_(self) -> str:
        return self.plot()._repr_svg_()

    def __repr__(self) -> str:
        return f"<track by {self.method}: {len(self.table)} samples, {'complete' if self.complete else 'partial'}>"


class Study:
    """A path study: an arm, a path, a start and methods. From a file, or from its text and a model."""

    def __init__(self, text: str, *, folder: Union[str, Path] = "", model: Optional[Model] = None, seed: int = 1) -> None:
        definition = ffi.gc(ffi.new("km_study_def *", lib.km_study_def_default()), lib.km_study_def_free)
        messages = ffi.gc(lib.km_messages_create(), lib.km_messages_free)
        data, error = bytes_of(text, "study"), new_error()
        place = f"{folder}/" if str(folder) else ""
        kept = ffi.new("char[]", bytes_of(place, "folder"))
        check(lib.km_study_read(data, len(data), kept, messages, definition, error), error)
        if model is None:
            if definition.model == ffi.NULL:
                raise UsageError("the study names no model; expected model=…")
            model = load(Path(folder, text_of(definition.model)))
        self.model, self.mechanism, out = model, model.mechanism(), ffi.new("km_study **")
        with model._reading(), self.mechanism.state._using():
            check(lib.km_study_bind(self.mechanism._c, self.mechanism.state._c, definition, _seed(seed), messages, out,
                                    error), error)
        self._c, self._changes = ffi.gc(out[0], lib.km_study_free), model._changes
        self.messages = messages_of(messages)

    @property
    def methods(self) -> list[str]:
        """The methods of the study."""
        return [text_of(lib.km_study_plan(self._c, i).method.word) for i in range(lib.km_study_methods(self._c))]

    def track(self, method: int = 0, *, jobs: int = 1, seed: int = 1, progress: Progress = None) -> Track:
        """Follows the path by one of the study's methods."""
        last = lib.km_study_methods(self._c) - 1
        method = _whole(method, "method", 0, last, f"0 to {last}")
        jobs = _whole(jobs, "jobs", 1, 1024, "1 to 1024")
        watch, error, out = Watch(progress), new_error(), ffi.new("km_track **")
        plan = ffi.new("km_track_plan *", lib.km_study_plan(self._c, method))
        plan.jobs, plan.seed, plan.progress, plan.context = jobs, _seed(seed), watch.call, watch.context
        with self.model._reading():
            _check_current(self, self.model, "study")
            status = lib.km_track_run(lib.km_study_arm(self._c), plan, out, error)
        try:
            watch.finish()
            return Track(self, method, out[0], check(status, error, partial=True))
        except BaseException:
            if out[0] != ffi.NULL:
                lib.km_track_free(out[0])
            raise

    def tracks(self, **given: Any) -> list[Track]:
        """Follows the path by every method of the study."""
        return [self.track(i, **given) for i in range(len(self.methods))]


def load_study(path: Union[str, Path], model: Optional[Model] = None) -> Study:
    """Reads a path study; its model is looked up from the study's folder."""
    path = Path(path)
    try:
        text = read_file(path).decode("utf-8")
    except OSError as bad:
        raise FileError(str(bad)) from bad
    return Study(text, folder=path.parent, model=model)
