"""Frozen tangent of the whole machine for several iterations and steps, reconstructed from few numbers.

The frozen tangent is that of an earlier iterate, with zero deformation rates and accelerations relative to
the frames; the resulting error is of the size of the deformation in one step. The tangent then depends on
few numbers. A recorded run stores these numbers, so that a resumed run has the same iterations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.integrate import StepFactors
from supple.methods.floating.full.elimination import Elimination
from supple.methods.floating.full.full_state import InteriorState
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.floating.full.full_tangent import FullTangent

SIMILAR = 0.1
"""Largest relative difference of step factors from those of a frozen tangent that is still used."""

_FIELDS = ("rotation", "angular_velocity", "angular_acceleration", "acceleration", "time", "coordinates")
"""Fields of an `InteriorState` on which a frozen tangent depends."""


class FrozenTangent(NamedTuple):
    """Eliminated interiors, and the states for which they were computed."""

    eliminations: tuple[Elimination, ...]
    states: tuple[InteriorState, ...]
    turns: np.ndarray
    """Rotation of each interior's frame within the step, (b, 3)"""
    factors: StepFactors
    symmetric: bool
    """Whether only the symmetric parts of the interiors' tangents were factored"""
    proven: bool = False
    """Whether an iteration with this tangent has reduced the correction tenfold"""


def frozen_tangent(
    machine: FullSystem,
    states: tuple[InteriorState, ...],
    turns: np.ndarray,
    factors: StepFactors,
    *,
    symmetric: bool,
) -> FrozenTangent:
    """Eliminations of every interior at these states, by its tangent or the symmetric part of it."""
    none = [np.zeros(interior.full.n_coordinates) for interior in machine.interiors]
    still = tuple(
        state._replace(rates=zero, accelerations=zero, frame_multipliers=np.zeros(6))
        for state, zero in zip(states, none, strict=True)
    )
    factor = FullTangent.symmetric if symmetric else FullTangent.exact
    return FrozenTangent(machine.eliminated(still, turns, factors, factor), still, turns, factors, symmetric)


def tangent_numbers(machine: FullSystem, tangent: FrozenTangent | None) -> np.ndarray:
    """State of a frozen tangent as one row of numbers; NaN without a tangent."""
    if tangent is None:
        return np.full(_size(machine), np.nan)
    of_step = [*tangent.factors, float(tangent.symmetric), float(tangent.proven)]
    parts = [np.ravel(getattr(state, name)) for state in tangent.states for name in _FIELDS]
    return np.concatenate([of_step, np.ravel(tangent.turns), *parts]).astype(float)


def tangent_of(machine: FullSystem, numbers: np.ndarray) -> FrozenTangent | None:
    """The tangent described by `tangent_numbers`, factored again; None for NaN or for another machine."""
    if len(numbers) != _size(machine) or not np.isfinite(numbers).all():
        return None
    b = len(machine.interiors)
    of_step, turns, left = np.split(numbers, [4, 4 + 3 * b])
    states = []
    for interior in machine.interiors:
        n = interior.full.n_coordinates
        own, left = np.split(left, [19 + n])
        rotation, spin, spin_rate, acceleration, time, coordinates = np.split(own, [9, 12, 15, 18, 19])
        none = np.zeros(n)
        states.append(
            InteriorState(
                rotation=rotation.reshape(3, 3),
                coordinates=coordinates,
                rates=none,
                accelerations=none,
                angular_velocity=spin,
                angular_acceleration=spin_rate,
                acceleration=acceleration,
                frame_multipliers=np.zeros(6),
                time=float(time[0]),
            )
        )
    factors = StepFactors(float(of_step[0]), float(of_step[1]))
    turns = turns.reshape(b, 3)
    tangent = frozen_tangent(machine, tuple(states), turns, factors, symmetric=bool(of_step[2]))
    return tangent._replace(proven=bool(of_step[3]))


def _size(machine: FullSystem) -> int:
    return 4 + sum(3 + 19 + interior.full.n_coordinates for interior in machine.interiors)
