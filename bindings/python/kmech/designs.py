"""Studies of designs: grids, tolerances and optimisations, as kstudy reads them."""
from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy

from ._kmech import ffi, lib
from .errors import FileError, Message, UsageError, bytes_of, check, messages_of, new_error, read_file, text_of
from .model import Model
from .progress import Progress, Watch


class Statistics(NamedTuple):
    """Statistics of a figure over the designs. mean_half_width: of the mean's 95 % interval. quantiles: by probability.
    good: designs within the figure's limits."""

    count: int
    mean: float
    mean_half_width: float
    deviation: float
    least: float
    greatest: float
    quantiles: dict[float, float]
    good: int


class Yield(NamedTuple):
    """Accepted designs of all, and the 95 % interval of their share."""

    good: int
    count: int
    share: float
    share_low: float
    share_high: float


class DesignStudy:
    """A study of designs from its text, as in the files of kstudy. folder: where its model is looked up. store: file of the
    results; without it they are in memory."""

    def __init__(self, text: str, *, folder: Union[str, Path] = "", store: Optional[Union[str, Path]] = None,
                 replace: bool = False) -> None:
        self._def = ffi.gc(ffi.new("km_design_study_def *", lib.km_design_study_default()), lib.km_design_study_def_free)
        messages, data, error = ffi.gc(lib.km_messages_create(), lib.km_messages_free), bytes_of(text, "study"), new_error()
        try:
            check(lib.km_design_study_read(data, len(data), messages, self._def, error), error)
        finally:
            self.messages: list[Message] = messages_of(messages)
        if self._def.sample_file != ffi.NULL:
            raise UsageError("the study's sample is a CSV file; expected its rows in the study, or kstudy")
        self._kept = [ffi.new("char[]", bytes_of(str(folder), "folder"))]
        if self._def.model != ffi.NULL:
            self._kept.append(ffi.new("char[]", bytes_of(str(Path(folder, text_of(self._def.model))), "model")))
            self._def.model = self._kept[1]
        self._def.folder = self._kept[0]
        out, file = ffi.new("km_design_study **"), ffi.NULL if store is None else bytes_of(str(store), "store")
        check(lib.km_design_study_open(self._def, file, bool(replace), out, error), error)
        self._c = ffi.gc(out[0], lib.km_design_study_free)

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters."""
        return [text_of(self._def.parameters[p].name) for p in range(self._def.parameter_count)]

    @property
    def figures(self) -> dict[str, str]:
        """The figures of merit with their units."""
        return {text_of(lib.km_design_study_figure(self._c, f).name): text_of(lib.km_design_study_figure_unit(self._c, f))
                for f in range(lib.km_design_study_figures(self._c))}

    def run(self, *, jobs: int = 1, progress: Progress = None) -> bool:
        """Computes the designs that the store lacks. Returns whether every design has an answer."""
        if isinstance(jobs, bool) or not isinstance(jobs, int) or not 1 <= jobs <= 1024:
            raise UsageError(f"jobs: found {jobs!r}; expected 1 to 1024")
        watch, error = Watch(progress), new_error()
        status = lib.km_design_study_run(self._c, jobs, watch.call, watch.context, error)
        watch.finish()
        check(status, error)
        return bool(lib.km_design_study_is_complete(self._c))

    def __len__(self) -> int:
        return lib.km_design_study_designs(self._c)

    @property
    def table(self) -> numpy.ndarray:
        """A row for each design: parameters, figures, and whether the design is accepted. Values that the model leaves at
        its own are the model's."""
        parameters, figures = self.parameters, list(self.figures)
        out = numpy.empty(len(self), [(n, float) for n in parameters + figures] + [("accepted", bool)])
        values, result, error = ffi.new("double[]", len(parameters) + 1), ffi.new("km_design_result *"), new_error()
        base = [lib.km_design_study_base(self._c, p) for p in range(len(parameters))]
        for i in range(len(out)):
            check(lib.km_design_study_values(self._c, i, values, error), error)
            check(lib.km_design_study_result(self._c, i, result, error), error)
            stated = [values[p] if values[p] == values[p] else base[p] for p in range(len(parameters))]
            out[i] = (*stated, *(result.figures[f] for f in range(len(figures))),
                      lib.km_design_study_accepts(self._c, result))
        return out

    @property
    def best(self) -> Optional[int]:
        """The best accepted design of an optimisation; None if there is none."""
        found = lib.km_design_study_best(self._c)
        return None if found < 0 else found

    @property
    def front(self) -> list[int]:
        """The designs of two goals that no other design beats in both, in the order of the first goal."""
        room = max(len(self), 1)
        found = ffi.new("int[]", room)
        return list(found[0:lib.km_design_study_front(self._c, found, room)])

    def _figure(self, name: str) -> int:
        names = list(self.figures)
        if name not in names:
            raise UsageError(f"figure: found {name!r}; expected one of {', '.join(names)}")
        return names.index(name)

    def statistics(self, figure: str) -> Statistics:
        """Statistics of a figure over all designs with a value."""
        out, error = ffi.new("km_design_statistics *"), new_error()
        check(lib.km_design_study_statistics(self._c, self._figure(figure), out, error), error)
        quantiles = {lib.km_design_quantile(k): out.quantiles[k] for k in range(lib.KM_DESIGN_QUANTILES)}
        return Statistics(out.count, out.mean, out.mean_half_width, out.deviation, out.least, out.greatest, quantiles,
                          out.good)

    def share(self) -> Yield:
        """How many designs are accepted."""
        out, error = ffi.new("km_design_yield *"), new_error()
        check(lib.km_design_study_yield(self._c, out, error), error)
        return Yield(out.good, out.count, out.share, out.share_low, out.share_high)

    def ranks(self, figure: str) -> dict[str, float]:
        """Spearman's rank correlation of a figure with each parameter: what the figure depends on."""
        out, error = ffi.new("double[]", self._def.parameter_count + 1), new_error()
        check(lib.km_design_study_ranks(self._c, self._figure(figure), out, error), error)
        return dict(zip(self.parameters, out))

    def model(self, design: int) -> Model:
        """The model of a design."""
        out, error = ffi.new("km_model **"), new_error()
        if isinstance(design, bool) or not isinstance(design, int) or not 0 <= design < len(self):
            raise UsageError(f"design: found {design!r}; expected 0 to {len(self) - 1}")
        check(lib.km_design_study_model(self._c, design, out, error), error)
        return Model._of(out[0])

    def __repr__(self) -> str:
        return f"<study of {len(self)} designs: {', '.join(self.figures)}>"


def load_designs(path: Union[str, Path], *, store: Optional[Union[str, Path]] = None, replace: bool = False) -> DesignStudy:
    """Reads a study of designs; its model is looked up from the study's folder."""
    path = Path(path)
    try:
        text = read_file(path).decode("utf-8")
    except OSError as bad:
        raise FileError(str(bad)) from bad
    return DesignStudy(text, folder=path.parent, store=store, replace=replace)
