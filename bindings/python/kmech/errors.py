"""Failures of the library as exceptions: each tells the place, what was found and what was expected."""
from __future__ import annotations

import os
from typing import Any

from ._kmech import ffi, lib


class KmechError(Exception):
    """Something in a call or a model is wrong. `status` is the library's word for its kind."""

    status = "error"


class UsageError(KmechError, ValueError):
    """The call asks for something that doesn't exist or doesn't fit."""

    status = "usage"


class FileError(KmechError, OSError):
    """A file can't be read or written."""

    status = "file"


class ModelError(KmechError, ValueError):
    """The model is bad: syntax, contents, or loops that can't close. `messages` holds all that was found."""

    status = "model"
    messages: list["Message"] = []


class NoResult(KmechError):
    """The work is done, and the answer is that there is none."""

    status = "no result"


class Diverged(KmechError, ArithmeticError):
    """An iteration didn't converge."""

    status = "diverged"


class Cancelled(KmechError):
    """The progress function asked to stop."""

    status = "cancelled"


class InternalError(KmechError, RuntimeError):
    """A broken invariant of the library: please report it."""

    status = "internal"


class ModelWarning(UserWarning):
    """The reader found something in a model that is probably meant otherwise."""


class Message:
    """A finding of a reader: `severity` is "note", "warning" or "error"."""

    __slots__ = ("severity", "text")
    words = {lib.KM_NOTE: "note", lib.KM_WARNING: "warning", lib.KM_ERROR: "error"}

    def __init__(self, severity: str, text: str) -> None:
        self.severity, self.text = severity, text

    def __repr__(self) -> str:
        return f"{self.severity}: {self.text}"


_CLASSES = {
    lib.KM_NO_RESULT: NoResult, lib.KM_USAGE: UsageError, lib.KM_IO: FileError, lib.KM_MODEL: ModelError,
    lib.KM_DIVERGED: Diverged, lib.KM_CANCELLED: Cancelled, lib.KM_INTERNAL: InternalError,
}


def text_of(pointer: Any) -> str:
    """A text of the library, which may hold any bytes."""
    return "" if pointer == ffi.NULL else ffi.string(pointer).decode("utf-8", "surrogateescape")


def bytes_of(text: Any, what: str) -> bytes:
    """A name for the library. TypeError, ValueError: no text, or a NUL in it."""
    if not isinstance(text, str):
        raise TypeError(f"{what}: found {type(text).__name__}; expected a text")
    if "\0" in text:
        raise UsageError(f"{what}: found a NUL in the text; expected none")
    return text.encode("utf-8", "surrogateescape")


def new_error() -> Any:
    return ffi.new("km_error *")


def check(status: int, error: Any, partial: bool = False) -> bool:
    """Raises what a status means. With `partial`, KM_PARTIAL is no failure: returns whether everything was done."""
    if status == lib.KM_OK:
        return True
    if status == lib.KM_PARTIAL and partial:
        return False
    if status == lib.KM_MEMORY:
        raise MemoryError(text_of(error.text))
    raise _CLASSES.get(status, KmechError)(text_of(error.text) or "the library gave no reason")


def read_file(path: Any) -> bytes:
    """The bytes of a file, of at most the size that the tools take. OSError: it isn't there, can't be read or is larger."""
    os.stat(path)
    out, error = ffi.new("km_text *"), new_error()
    try:
        check(lib.km_file_read(os.fsencode(os.path.abspath(path)), out, error), error)
        return bytes(ffi.buffer(out.data, out.size))
    finally:
        lib.km_text_free(out)


def messages_of(messages: Any) -> list[Message]:
    return [Message(Message.words[lib.km_messages_severity(messages, i)], text_of(lib.km_messages_text(messages, i)))
            for i in range(lib.km_messages_count(messages))]
