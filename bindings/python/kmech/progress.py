"""Long work: who is asked how far it is, and how Ctrl-C ends it."""
from __future__ import annotations

import sys
from typing import Any, Callable, Optional, Union

import numpy

from ._kmech import ffi, lib

Progress = Union[None, bool, Callable[[float], Any]]


class Watch:
    """Asked during a call. A function that returns False, or raises, ends the work; so does Ctrl-C."""

    def __init__(self, progress: Progress) -> None:
        if progress is not None and not isinstance(progress, bool) and not callable(progress):
            raise TypeError("progress: expected True, or a function of how much is done (0 … 1)")
        self.shown = progress is True
        self.function = progress if callable(progress) else None
        self.raised: Optional[BaseException] = None
        self.handle = ffi.new_handle(self)
        self.context = ffi.new("kmech_watch *", {"handle": self.handle})
        self.call = lib.kmech_progress_function()

    def ask(self, done: float) -> bool:
        if self.shown:
            sys.stderr.write(f"\r{100 * done:3.0f} %")
            sys.stderr.flush()
        found = None if self.function is None else self.function(done)
        return not isinstance(found, (bool, numpy.bool_)) or bool(found)

    def finish(self) -> None:
        """After the call: what ended it is raised again."""
        if self.shown:
            sys.stderr.write("\r     \r")
        if self.raised is not None:
            raise self.raised


def _keep(kind: Any, value: BaseException, trace: Any) -> bool:
    """What was raised while the library asked waits until the call is over."""
    frame = trace.tb_frame if trace else None
    watch = frame.f_locals.get("watch") if frame else None
    if watch is None and frame is not None:
        watch = ffi.from_handle(frame.f_locals["context"]) if "context" in frame.f_locals else None
    if watch is not None:
        watch.raised = value
    return False


@ffi.def_extern(name="kmech_python_progress", error=False, onerror=_keep)
def _progress(context: Any, done: float) -> bool:
    watch = ffi.from_handle(context)
    try:
        return bool(watch.ask(done))
    except BaseException as raised:
        watch.raised = raised
        return False
