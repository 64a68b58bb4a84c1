"""Pictures that notebooks show and files keep."""
from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, Union

from ._kmech import ffi, lib
from .errors import UsageError, check, new_error

FORMATS = {"svg": lib.KM_PICTURE_SVG, "pdf": lib.KM_PICTURE_PDF, "png": lib.KM_PICTURE_PNG}


def taken(out: Any) -> bytes:
    """The bytes that the library hands over, which are freed."""
    try:
        return bytes(ffi.buffer(out.data, out.size))
    finally:
        lib.km_bytes_free(out)


class Picture:
    """A picture that can be drawn as SVG, PDF or PNG: the same answer gives the same bytes."""

    def __init__(self, draw: Callable[[int, Any, Any], int]) -> None:
        self._draw = draw

    def data(self, format: str = "svg") -> bytes:
        """The bytes of a file. `format`: svg, pdf or png."""
        if format not in FORMATS:
            raise UsageError(f"format: found {format!r}; expected svg, pdf or png")
        out, error = ffi.new("km_text *"), new_error()
        try:
            check(self._draw(FORMATS[format], out, error), error)
            return bytes(ffi.buffer(out.data, out.size))
        finally:
            lib.km_text_free(out)

    def save(self, path: Union[str, Path]) -> Path:
        """Writes a file, whose ending tells the format."""
        path = Path(path)
        path.write_bytes(self.data(path.suffix[1:].lower()))
        return path

    def _repr_svg_(self) -> str:
        return self.data("svg").decode("utf-8")

    def __repr__(self) -> str:
        return "<a picture: save(\"name.svg\"), .pdf or .png>"
