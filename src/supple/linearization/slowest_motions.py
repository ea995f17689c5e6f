"""The slowest modes of a machine with full bodies, by shift and invert.

    ( s^2 M + s C + K ) x + A^T l = 0,    A x = 0

A basis of slow motions is extended by the response t to the residual of each requested mode (s, x), computed
at a fixed shift z,

    t = K(z)^-1 ( s^2 M + s C + K ) x,    K(z) = K + z C + z^2 M,

until t is negligible. For an undamped machine at rest these are steps of the block Lanczos method with shift
and invert.
Source: [Voss2004].
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.errors import AccuracyError, ModelError
from supple.linearization.linear_machine import Array, LinearMachine, mass_squares
from supple.linearization.sparse_machine import LARGEST_DENSE, SlowMotions, SparseMachine

_GUARD = 4
"""Number of modes computed in addition to the requested ones, so that none of the latter is missed."""

_LEFT = 1e-8
"""Allowed norm of t, relative to that of the mode."""

_ALLOWED = 1e-5
"""Allowed norm of t if it no longer decreases to a third in a round, because of rounding."""

_ROUNDS = 60
"""Largest number of extensions of the basis."""

_NEW = 1e-5
"""Norm of the part of a motion outside the basis, relative to that of the motion, below which it is
rounding."""


Pairs = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Eigenvalues, motions (k, ..) of unit kinetic energy and states of controllers of modes, slowest first."""


def slowest_motions(
    machine: SparseMachine, n_modes: int | None, modes_of: Callable[[LinearMachine], Pairs]
) -> Array:
    """Motions (n, k), mass-orthonormal, whose span contains the slowest modes.

    For a small machine, they may be all motions.

    Raises
    ------
    ModelError      all modes of a large machine
    AccuracyError   modes that do not converge
    """
    most = machine.size // 4 - _GUARD
    if n_modes is None or n_modes > most:
        if machine.size <= LARGEST_DENSE:
            return machine.all_motions
        raise ModelError(
            f"a machine with full bodies has {machine.size} freedoms, of which the slowest modes are found: "
            f"give their number, from 1 to {most}"
        )
    slow, mass = machine.slow, machine.equations.mass
    wanted = n_modes + _GUARD
    fresh = np.random.default_rng(1).standard_normal((mass.shape[0], wanted))
    images = slow.factor.solve(mass @ fresh)
    basis = _enlarged(machine, slow.motions, images / np.sqrt(mass_squares(images, mass)))
    left = np.inf
    for _ in range(_ROUNDS):
        values, independent, states = modes_of(machine.along(basis))
        shapes = basis @ independent[:, :wanted]
        responses = _left_over(machine, slow, values[:wanted], shapes, states[:, :wanted])
        parts = np.sqrt(mass_squares(responses, mass))
        before, left = left, float(parts[:n_modes].max())
        if len(values) >= wanted and (left <= _LEFT or (left <= _ALLOWED and left > before / 3)):
            return basis
        # Real and imaginary part are scaled by one factor, so that a far smaller part counts as rounding.
        new = responses[:, parts > _LEFT] / parts[parts > _LEFT]
        larger = _enlarged(machine, basis, np.hstack([new.real, new.imag]))
        if larger.shape[1] == basis.shape[1]:
            break
        basis = larger
    if machine.size <= LARGEST_DENSE:
        return machine.all_motions
    raise AccuracyError(
        f"the {n_modes} slowest modes have not converged: {left:.1e} of a mode is missing; request another "
        "number of modes, or reduce the bodies"
    )


def _left_over(
    machine: SparseMachine, slow: SlowMotions, values: np.ndarray, shapes: np.ndarray, states: np.ndarray
) -> np.ndarray:
    """`t = x + K(z)^-1 ( ( (s^2 - z^2) M + (s - z) C ) x - H c )`, complex (n, k), of shapes of unit size.

    states : c, of the controllers
    """
    equations, shift = machine.equations, slow.shift
    loads = (equations.mass @ shapes) * (values**2 - shift**2)
    loads = loads + equations.damped(shapes) * (values - shift) - equations.control.forces @ states
    responses = slow.factor.solve(np.hstack([loads.real, loads.imag]))
    real, imaginary = np.split(responses, 2, axis=1)
    return shapes + real + 1j * imaginary


def _enlarged(machine: SparseMachine, basis: Array, more: Array) -> Array:
    """The basis with the new parts of some motions of unit size or less, orthonormal."""
    mass, constraint = machine.equations.mass, machine.equations.constraint
    for smallest in (_NEW, 0.5):
        for _ in range(2):
            more = more - basis @ (basis.T @ (mass @ more))
        # The new part may be small relative to its motion, whose rounding opens the joints.
        more = more + machine.slow.factor.solve(np.zeros_like(more), -(constraint @ more))
        gram = more.T @ (mass @ more)
        squares, weights = np.linalg.eigh((gram + gram.T) / 2)
        kept = squares > smallest**2
        more = more @ (weights[:, kept] / np.sqrt(squares[kept]))
    return np.hstack([basis, more])
