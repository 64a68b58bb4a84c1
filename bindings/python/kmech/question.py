"""Questions: every analysis of a motion, made from the library's own table of questions and their options."""
from __future__ import annotations

import functools
import inspect
import keyword
import os
from typing import Any, Iterable, Mapping, NamedTuple, Optional

from ._kmech import ffi, lib
from .errors import Message, UsageError, bytes_of, check, messages_of, new_error, text_of
from .picture import Picture
from .progress import Progress, Watch
from .table import Table, table_of

_EXPECTED = {
    lib.KM_OPTION_FLAG: "True or False", lib.KM_OPTION_WHOLE: "a whole number", lib.KM_OPTION_NUMBER: "a number",
    lib.KM_OPTION_RANGE: "two numbers", lib.KM_OPTION_VECTOR: "three numbers", lib.KM_OPTION_WORD: "one of its words",
    lib.KM_OPTION_COORDINATE: "a joint's label", lib.KM_OPTION_SENSE: "a joint's label, or \"-label\" for backwards",
    lib.KM_OPTION_COORDINATES: "a list of joints' labels", lib.KM_OPTION_POINTS: "a list of \"body/frame\"",
    lib.KM_OPTION_END: "a joint's label, or (\"body/frame\", [dx, dy, dz])",
    lib.KM_OPTION_ENDS: "a list of (\"body/frame\", [dx, dy, dz])",
    lib.KM_OPTION_FILE: "a file's name",
    lib.KM_OPTION_SETTINGS: "{joint's label: number}", lib.KM_OPTION_PAIR: "a number, or two",
    lib.KM_OPTION_MODULES: "a list of force modules' names, or \"all\"",
    lib.KM_OPTION_BODY_PAIRS: "a list of pairs of bodies, (\"arm\", \"frame\")",
    lib.KM_OPTION_LOADS: "a list of {\"frame\": \"body/frame\", \"force\": […], \"torque\": […], \"turning\": False}",
}


class Option(NamedTuple):
    """An option of a kind of question."""

    name: str
    type: int
    unit: str
    otherwise: str
    help: str
    words: tuple[str, ...]

    @property
    def argument(self) -> str:
        name = self.name.replace("-", "_")
        return name + "_" if keyword.iskeyword(name) else name


class Event(NamedTuple):
    """A place that was located along a motion: a toggle, a zero, a peak, a limit, a crossing …"""

    name: str
    subject: str
    s: float
    value: float


def kinds() -> list[str]:
    """The kinds of question that the library knows."""
    return [text_of(lib.km_question_kind_name(k)) for k in range(lib.km_question_kinds())]


@functools.lru_cache(maxsize=None)
def options(kind: int) -> tuple[Option, ...]:
    """What a kind of question can be asked with."""
    found: list[Option] = []
    while True:
        o = lib.km_question_option(kind, len(found))
        if o == ffi.NULL:
            return tuple(found)
        words = text_of(o.words).replace(" or ", ",").replace(" ", "")
        found.append(Option(text_of(o.name), o.type, text_of(o.unit), text_of(o.otherwise), text_of(o.help),
                            tuple(w for w in words.split(",") if w)))


def number(value: Any, what: str) -> float:
    if isinstance(value, (bool, str, bytes)) or not hasattr(value, "__float__"):
        raise TypeError(f"{what}: found {value!r}; expected a number")
    return float(value)


def numbers(value: Any, count: int, what: str) -> list[float]:
    try:
        items = [number(v, what) for v in value]
    except TypeError:
        raise TypeError(f"{what}: found {value!r}; expected {count} numbers") from None
    if len(items) != count:
        raise UsageError(f"{what}: found {len(items)} numbers; expected {count}")
    return items


def _items(value: Any, option: Option) -> list[Any]:
    if isinstance(value, (str, bytes, dict)) or not isinstance(value, Iterable):
        raise TypeError(f"{option.argument}: found {value!r}; expected {_EXPECTED[option.type]}")
    return list(value)


class Values:
    """Turns Python's values into the library's. What they point to is kept as long as this is."""

    def __init__(self, model: Any) -> None:
        self.model, self.kept = model, []

    def text(self, text: str) -> Any:
        kept = ffi.new("char[]", bytes_of(text, "name"))
        self.kept.append(kept)
        return kept

    def array(self, kind: str, items: list[Any]) -> Any:
        kept = ffi.new(f"{kind}[]", items) if items else ffi.NULL
        self.kept.append(kept)
        return kept

    def modules(self, names: Optional[list[Any]], what: str) -> list[int]:
        """Indices of force modules; None: all."""
        if names is None:
            return list(range(lib.km_model_module_count(self.model._c)))
        found = [lib.km_model_find_module(self.model._c, bytes_of(name, what)) for name in names]
        if -1 in found:
            raise UsageError(f"{what}: no force module is called {names[found.index(-1)]!r}")
        return found

    def end(self, value: Any, option: Option) -> dict[str, Any]:
        if isinstance(value, str):
            c = self.model._coordinate(value)
            return {"kind": lib.KM_PORT_JOINT, "coordinate": c, "frame": -1,
                    "name": lib.km_model_coordinate_label(self.model._c, c)}
        if not isinstance(value, (tuple, list)) or len(value) != 2:
            raise TypeError(f"{option.argument}: found {value!r}; expected {_EXPECTED[option.type]}")
        direction = numbers(value[1], 3, f"{option.argument}: direction")
        length = sum(d * d for d in direction) ** 0.5
        if not 0.0 < length < float("inf"):
            raise UsageError(f"{option.argument}: found the direction {direction}; expected one with a length")
        name = f"{value[0]}:" + ",".join(f"{d:g}" for d in direction)
        return {"kind": lib.KM_PORT_POINT, "frame": self.model._frame(value[0]), "coordinate": -1,
                "direction": [d / length for d in direction], "name": self.text(name)}

    def bodies(self, value: Any, option: Option) -> dict[str, Any]:
        if isinstance(value, str) or not isinstance(value, (tuple, list)) or len(value) != 2:
            raise TypeError(f"{option.argument}: found {value!r}; expected {_EXPECTED[option.type]}")
        return {"body": [lib.km_model_frame_body(self.model._c, self.model._frame(name)) for name in value]}

    def load(self, value: Any, option: Option) -> dict[str, Any]:
        if not isinstance(value, dict) or "frame" not in value or set(value) - {"frame", "force", "torque", "turning"}:
            raise TypeError(f"{option.argument}: found {value!r}; expected {_EXPECTED[option.type]}")
        return {"frame": self.model._frame(value["frame"]),
                "force": numbers(value.get("force", (0, 0, 0)), 3, "force"),
                "torque": numbers(value.get("torque", (0, 0, 0)), 3, "torque"), "turning": bool(value.get("turning"))}

    def option(self, option: Option, value: Any) -> Any:
        """A km_option_value."""
        kind, out, what = option.type, ffi.new("km_option_value *"), option.argument
        if kind == lib.KM_OPTION_FLAG:
            out.flag = bool(value)
        elif kind == lib.KM_OPTION_WHOLE:
            if isinstance(value, bool) or not hasattr(value, "__index__"):
                raise TypeError(f"{what}: found {value!r}; expected a whole number")
            if not -2 ** 31 <= value.__index__() < 2 ** 31:
                raise UsageError(f"{what}: found {value}; expected a smaller number")
            out.whole = value.__index__()
        elif kind == lib.KM_OPTION_NUMBER:
            out.numbers[0] = number(value, what)
        elif kind in (lib.KM_OPTION_RANGE, lib.KM_OPTION_VECTOR):
            for i, x in enumerate(numbers(value, 2 if kind == lib.KM_OPTION_RANGE else 3, what)):
                out.numbers[i] = x
        elif kind == lib.KM_OPTION_WORD:
            if value not in option.words:
                raise UsageError(f"{what}: found {value!r}; expected {' or '.join(option.words)}")
            out.whole = option.words.index(value)
        elif kind == lib.KM_OPTION_FILE:
            out.text = self.text(os.fspath(value))
        elif kind == lib.KM_OPTION_COORDINATE:
            out.coordinate = self.model._coordinate(value)
        elif kind == lib.KM_OPTION_SENSE:
            back = isinstance(value, str) and value.startswith("-") and value not in self.model.coordinates
            out.coordinate, out.numbers[0] = self.model._coordinate(value[1:] if back else value), -1.0 if back else 1.0
        elif kind == lib.KM_OPTION_END:
            out.end = self.end(value, option)
        elif kind == lib.KM_OPTION_PAIR:
            pair = numbers(value, 2, what) if isinstance(value, Iterable) else [number(value, what), 0.0]
            out.numbers[0], out.numbers[1] = pair
        elif kind == lib.KM_OPTION_MODULES:
            modules = self.modules(_items(value, option) if value != "all" else None, what)
            out.modules, out.count = self.array("int", modules), len(modules)
        elif kind == lib.KM_OPTION_SETTINGS:
            if not isinstance(value, Mapping):
                raise TypeError(f"{what}: found {value!r}; expected {_EXPECTED[kind]}")
            out.count = len(value)
            out.coordinates = self.array("int", [self.model._coordinate(label) for label in value])
            out.settings = self.array("double", [number(v, f"{what}: {label}") for label, v in value.items()])
        else:
            items = _items(value, option)
            out.count = len(items)
            if kind == lib.KM_OPTION_COORDINATES:
                out.coordinates = self.array("int", [self.model._coordinate(v) for v in items])
            elif kind == lib.KM_OPTION_POINTS:
                out.points = self.array("km_sweep_point", [{"frame": self.model._frame(v), "name": self.text(v)} for v in items])
            elif kind == lib.KM_OPTION_ENDS:
                out.ends = self.array("km_port", [self.end(v, option) for v in items])
            elif kind == lib.KM_OPTION_BODY_PAIRS:
                out.pairs = self.array("km_body_pair", [self.bodies(v, option) for v in items])
            elif kind == lib.KM_OPTION_LOADS:
                out.loads = self.array("km_load", [self.load(v, option) for v in items])
            else:
                raise UsageError(f"{what}: this package can't set options of this type")
        return out


class Answer:
    """What a question gave: rows, located events, figures of merit, a plot."""

    def __init__(self, mechanism: Any, kind: str) -> None:
        self._mechanism, self.kind, self.complete = mechanism, kind, False
        error, out = new_error(), ffi.new("km_question **")
        check(lib.km_question_create(mechanism._c, bytes_of(kind, "kind"), out, error), error)
        self._c = ffi.gc(out[0], lib.km_question_free)
        self._table: Optional[Table] = None

    def _set(self, given: dict[str, Any]) -> None:
        known = {o.argument: o for o in options(kinds().index(self.kind))}
        values, error = Values(self._mechanism.model), new_error()
        for name, value in given.items():
            if name not in known:
                raise TypeError(f"{self.kind}: there is no option {name!r}; expected some of {', '.join(known)}")
            if value is None:
                continue
            check(lib.km_question_set(self._c, bytes_of(known[name].name, "option"), values.option(known[name], value),
                                      error), error)

    def _ask(self, state: Any, here: bool, progress: Progress) -> None:
        watch, error = Watch(progress), new_error()
        lib.km_question_observe(self._c, watch.call, watch.context)
        try:
            with self._mechanism.model._reading(), state._using():
                status = (lib.km_question_compute_here if here else lib.km_question_compute)(self._c, state._c, error)
        finally:
            lib.km_question_observe(self._c, ffi.NULL, ffi.NULL)
        watch.finish()
        self.complete = check(status, error, partial=True)

    @property
    def table(self) -> Table:
        """The rows, as a structured array over the library's own memory."""
        if self._table is None:
            self._table = table_of(lib.km_question_table(self._c), self._c)
        return self._table

    def frame(self) -> Any:
        """The rows as a pandas.DataFrame."""
        return self.table.frame()

    @property
    def notes(self) -> list[Message]:
        """How the options were understood."""
        return messages_of(lib.km_question_notes(self._c))

    @property
    def events(self) -> list[Event]:
        """The places that were located along the motion, in its order."""
        found = (lib.km_question_event_at(self._c, i) for i in range(lib.km_question_event_count(self._c)))
        return [Event(text_of(e.name), text_of(e.subject), e.s, e.value) for e in found]

    def figure(self, column: str, figure: str = "max", at: float = 0.0) -> tuple[float, float]:
        """A figure of merit of a column over the driver, the arc length or the time, and where it is.

        figure: min, max, span, mean, rms, peak (largest magnitude), last, at (the value there), settling (the time after
        which the column stays within `at` times its largest distance from its last value, 0.02: to 2 %)."""
        words = {word: getattr(lib, f"KM_FIGURE_{word.upper()}") for word in
                 ("min", "max", "span", "mean", "at", "rms", "peak", "last", "settling")}
        if figure not in words:
            raise UsageError(f"figure: found {figure!r}; expected {', '.join(words)}")
        value, where, error = ffi.new("double *"), ffi.new("double *"), new_error()
        check(lib.km_table_figure(lib.km_question_table(self._c), bytes_of(column, "column"), words[figure],
                                  number(at, "at"), value, where, error), error)
        return value[0], where[0]

    def save_csv(self, path: str) -> None:
        """Writes the rows as the tools do."""
        error = new_error()
        check(lib.km_table_write_csv(lib.km_question_table(self._c), bytes_of(str(path), "path"), error), error)

    def save_xlsx(self, path: str, sheet: str = "table") -> None:
        """Writes the rows as a workbook: a sheet with the table, and one with a chart."""
        out, error = ffi.new("km_text *"), new_error()
        try:
            check(lib.km_question_xlsx(self._c, bytes_of(sheet, "sheet"), out, error), error)
            check(lib.km_file_write(bytes_of(str(path), "path"), out, error), error)
        finally:
            lib.km_text_free(out)

    def plot(self) -> Picture:
        """The plot that the tools draw of this answer."""
        name = ffi.new("char[]", bytes_of(self._mechanism.model.name, "name"))

        def draw(format: int, out: Any, error: Any) -> int:
            answer = ffi.new("km_answered *", {"question": self._c, "name": name})
            comparison = ffi.new("km_comparison *", {"answers": answer, "count": 1})
            chart = ffi.new("km_chart **")
            status = lib.km_question_chart(comparison, chart, error)
            if status:
                return status
            try:
                return lib.km_chart_picture(chart[0], format, out, error)
            finally:
                lib.km_chart_free(chart[0])

        return Picture(draw)

    def _repr_svg_(self) -> str:
        return self.plot()._repr_svg_()

    def __len__(self) -> int:
        return len(self.table)

    def __getitem__(self, column: Any) -> Any:
        return self.table[column]

    def __repr__(self) -> str:
        return f"<{self.kind} of {self._mechanism.model.name}: {len(self)} rows, {len(self.events)} events>"


def _document(kind: str, known: tuple[Option, ...]) -> str:
    lines = [f"Asks the question \"{kind}\" over a motion, or (here=True) at the present pose.", ""]
    for o in known:
        unit = f" ({o.unit})" if o.unit else ""
        otherwise = f" Without it: {o.otherwise}." if o.otherwise else ""
        lines.append(f"{o.argument}: {_EXPECTED.get(o.type, 'a value')}{unit}. {o.help}.{otherwise}")
    lines += ["progress: True for a line of progress, or a function of how much is done, which may return False to stop.",
              "", "Returns an Answer. It raises NoResult where no row is in reach; Answer.complete tells whether the whole",
              "range was."]
    return "\n".join(lines)


def _method(kind: str, known: tuple[Option, ...]) -> Any:
    def ask(self: Any, *, here: bool = False, progress: Progress = None, **given: Any) -> Answer:
        return self._ask(kind, here, progress, given)

    parameters = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    parameters += [inspect.Parameter(o.argument, inspect.Parameter.KEYWORD_ONLY, default=None) for o in known]
    parameters += [inspect.Parameter("here", inspect.Parameter.KEYWORD_ONLY, default=False),
                   inspect.Parameter("progress", inspect.Parameter.KEYWORD_ONLY, default=None)]
    ask.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    ask.__name__ = ask.__qualname__ = kind.replace("-", "_")
    ask.__doc__ = _document(kind, known)
    return ask


def add_methods(target: type) -> None:
    """Gives a class a method for each kind of question that the library knows."""
    for index, kind in enumerate(kinds()):
        name = kind.replace("-", "_")
        if not hasattr(target, name):
            setattr(target, name, _method(kind, options(index)))
