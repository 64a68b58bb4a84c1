"""Diagnosis of a configuration: finite mobility, redundant constraints and the joint types that remove them."""
from __future__ import annotations

import json
from typing import Any, NamedTuple

from ._kmech import ffi, lib
from .errors import bytes_of, check, new_error, text_of
from .mechanism import Mechanism, State
from .model import Model
from .progress import Progress, Watch

_MOTIONS = ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz")


class JointChange(NamedTuple):
    """Another type of one joint. motions: the freedoms that it adds, in the joint's parent frame."""

    joint: str
    to: str
    motions: tuple[str, ...]


class RemedySet(NamedTuple):
    """Joint types that together end the redundant constraints and keep the mobility.

    redundant, remaining: redundant constraints before and after. checked: an analysis of the changed model found them.
    infinitesimal: no set exists, since some motions are infinitesimal. model: the changed model without masses and forces."""

    changes: list[JointChange]
    redundant: int
    remaining: int
    mobility: int
    checked: bool
    infinitesimal: bool
    model: Model


def remedies(mechanism: Mechanism, state: State, progress: Progress) -> RemedySet:
    """The set of remedies at a state."""
    error, found, changed, watch = new_error(), ffi.new("km_remedy_set *"), ffi.new("km_model **"), Watch(progress)
    try:
        with mechanism.model._reading(), state._using():
            status = lib.km_remedy_set_find(mechanism._c, state._c, watch.call, watch.context, found, error)
            watch.finish()
            check(status, error)
            check(lib.km_remedy_set_model(mechanism._c, state._c, found, changed, error), error)
        labels = mechanism.model.joints
        changes = [JointChange(labels[c.joint], text_of(c.to),
                               tuple(word for k, word in enumerate(_MOTIONS) if c.motions >> k & 1))
                   for c in found.changes[0:found.change_count]]
        return RemedySet(changes, found.redundant, found.remaining, found.mobility, found.is_checked,
                         found.is_infinitesimal, Model._of(changed[0]))
    finally:
        lib.km_remedy_set_free(found)


def diagnose(mechanism: Mechanism, state: State, progress: Progress) -> dict[str, Any]:
    """The record of kmob info at a state."""
    error, found, watch = new_error(), ffi.new("km_diagnosis *"), Watch(progress)
    mobility, arena, out = ffi.new("km_mobility *"), ffi.new("km_arena *"), ffi.new("km_text *")
    try:
        with mechanism.model._reading(), state._using():
            status = lib.km_diagnosis_find(mechanism._c, state._c, watch.call, watch.context, found, error)
            watch.finish()
            check(status, error)
            check(lib.km_mobility_compute(mechanism._c, state._c, mobility), error)
            record = lib.km_mobility_record(mechanism._c, state._c, mobility, bytes_of(mechanism.model.name, "name"), arena)
            lib.km_diagnosis_record(mechanism._c, found, record, arena)
            lib.km_json_write(record, out)
        return json.loads(ffi.buffer(out.data, out.size)[:].decode("utf-8", "surrogateescape"))
    finally:
        lib.km_diagnosis_free(found)
        lib.km_text_free(out)
        lib.km_arena_free(arena)
