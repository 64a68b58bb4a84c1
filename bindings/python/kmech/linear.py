"""Linearised equations of motion, and configurations at rest."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Iterator, NamedTuple

import numpy

from ._kmech import ffi, lib
from .errors import check, new_error, text_of
from .mechanism import Mechanism, State
from .progress import Progress, Watch


class Linear(NamedTuple):
    """Linearised equations of motion dx/dt = A x + B f about a configuration, in radians and the model's length, force and
    time units.

    independent: labels of the n independent coordinates; x: deviations of these, then of their rates. A: 2n × 2n. B: 2n ×
    coordinates, f: forces in all coordinates. N: coordinates × n, derivative of all coordinates by the independent ones.
    eigenvalues: 2n complex numbers per time unit. modes: coordinates × 2n, complex. stability: "stable", "unstable",
    "indifferent", or that the configuration isn't at rest. residual: largest acceleration there; 0 at rest."""

    independent: list[str]
    A: numpy.ndarray
    B: numpy.ndarray
    N: numpy.ndarray
    eigenvalues: numpy.ndarray
    modes: numpy.ndarray
    stability: str
    residual: float


@contextmanager
def _dynamics(mechanism: Mechanism) -> Iterator[Any]:
    """Equations of motion under the model's own forces."""
    error, forces, dynamics = new_error(), ffi.new("km_forces **"), ffi.new("km_dynamics **")
    try:
        check(lib.km_forces_create_own(mechanism._c, forces, error), error)
        check(lib.km_dynamics_create(mechanism._c, forces[0], dynamics, error), error)
        yield dynamics[0]
    finally:
        lib.km_dynamics_free(dynamics[0])
        lib.km_forces_free(forces[0])


def _array(pointer: Any, rows: int, columns: int) -> numpy.ndarray:
    """Copy of a column-major matrix."""
    flat = numpy.frombuffer(ffi.buffer(pointer, 8 * rows * columns)) if rows * columns else numpy.zeros(0)
    return flat.reshape(columns, rows).T.copy()


def _taken(mechanism: Mechanism, linear: Any) -> Linear:
    n, coordinates = linear.freedom, linear.coordinate_count
    parts = _array(linear.modes, 1, 4 * n * coordinates).reshape(2 * n, 2, coordinates)
    labels = mechanism.model.coordinates
    return Linear([labels[linear.independent[i]] for i in range(n)], _array(linear.A, 2 * n, 2 * n),
                  _array(linear.B, 2 * n, coordinates), _array(linear.N, coordinates, n),
                  (_array(linear.real, 1, 2 * n) + 1j * _array(linear.imaginary, 1, 2 * n)).ravel(),
                  (parts[:, 0] + 1j * parts[:, 1]).T,
                  text_of(lib.km_stability_name(lib.km_linear_stability(linear))), linear.residual)


def linearise(mechanism: Mechanism, state: State) -> Linear:
    """Linearised equations of motion about a state."""
    error, linear = new_error(), ffi.new("km_linear *")
    with mechanism.model._reading(), state._using(), _dynamics(mechanism) as dynamics:
        try:
            check(lib.km_linearise(dynamics, state._c, linear, error), error)
            return _taken(mechanism, linear)
        finally:
            lib.km_linear_free(linear)


def equilibrium(mechanism: Mechanism, state: State, settle: bool, progress: Progress) -> State:
    """Moves a state to a configuration at rest."""
    error, watch = new_error(), Watch(progress)
    with mechanism.model._reading(), state._using(), _dynamics(mechanism) as dynamics:
        status = lib.km_equilibrium_find(dynamics, state._c, settle, watch.call, watch.context, error)
    watch.finish()
    check(status, error)
    return state
