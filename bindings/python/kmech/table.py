"""Tables of numbers as NumPy structured arrays, without a copy."""
from __future__ import annotations

from typing import Any

import numpy
from numpy.lib.recfunctions import structured_to_unstructured

from ._kmech import ffi, lib
from .errors import text_of


class Table(numpy.ndarray):
    """A structured array of the library's own numbers, which it keeps alive: table["q.A"], table[0].

    `units` gives each column's unit ("" where it has none). Read only."""

    units: dict[str, str]

    def __array_finalize__(self, source: Any) -> None:
        self.units = getattr(source, "units", {})

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns' names."""
        return self.dtype.names or ()

    def __getitem__(self, key: Any) -> Any:
        """Rows, or several columns, as a Table; one column as a plain array."""
        found = super().__getitem__(key)
        return numpy.asarray(found) if isinstance(found, Table) and found.dtype.names is None else found

    def matrix(self) -> numpy.ndarray:
        """The same numbers as rows and columns, without a copy where NumPy can do that."""
        return structured_to_unstructured(numpy.asarray(self))

    def frame(self) -> Any:
        """A pandas.DataFrame, where pandas is installed."""
        import pandas

        return pandas.DataFrame(self.matrix(), columns=list(self.columns))

    def _repr_html_(self) -> str:
        from html import escape

        head = "".join(f"<th>{escape(n)} {escape(self.units.get(n, ''))}</th>" for n in self.columns)
        shown = [self[i] for i in range(min(len(self), 20))]
        rows = "".join("<tr>" + "".join(f"<td>{v:.6g}</td>" for v in row) + "</tr>" for row in shown)
        more = f"<p>{len(self)} rows</p>" if len(self) > 20 else ""
        return f"<table><tr>{head}</tr>{rows}</table>{more}"


def table_of(pointer: Any, owner: Any) -> Table:
    """A km_table as an array. `owner` keeps the numbers alive."""
    rows, columns = lib.km_table_rows(pointer), lib.km_table_columns(pointer)
    names = [text_of(lib.km_table_name(pointer, c)) for c in range(columns)]
    dtype = numpy.dtype([(name, numpy.float64) for name in names])
    if rows and columns:
        # NumPy keeps the buffer of every view, the buffer its pointer, and the pointer the owner.
        first = ffi.gc(lib.km_table_row(pointer, 0), lambda _, owner=owner: None)
        memory = numpy.frombuffer(ffi.buffer(first, rows * columns * 8), dtype=dtype)
    else:
        memory = numpy.empty(0, dtype=dtype)
    memory.flags.writeable = False
    table = memory.view(Table)
    table.units = {name: text_of(lib.km_table_unit(pointer, c)) for c, name in enumerate(names)}
    return table
