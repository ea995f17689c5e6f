"""A tangent of the whole machine that serves several iterations and steps, and is made again from numbers.

It is that of an earlier iterate, of bodies that neither deform nor accelerate against their frames: both
change it in the measure of what a step deforms the body. So it depends on few numbers, which a recorded run
keeps, and a resumed one takes the same iterations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.integrate import StepFactors
from supple.methods.floating.full.elimination import Elimination
from supple.methods.floating.full.full_interior import InteriorState
from supple.methods.floating.full.full_system import FullSystem
from supple.methods.floating.full.full_tangent import FullTangent

__all__ = ["FrozenTangent", "frozen_tangent", "numbers_of", "serves", "tangent_of"]

SIMILAR = 0.1
"""Part by which the step factors may differ from those of a frozen tangent."""

_FIELDS = ("rotation", "angular_velocity", "angular_acceleration", "acceleration", "time", "coordinates")


class FrozenTangent(NamedTuple):
    """Eliminated interiors, and what they were made for."""

    eliminations: tuple[Elimination, ...]
    states: tuple[InteriorState, ...]
    turns: np.ndarray
    """Rotation of each interior's frame within the step, (b, 3)"""
    factors: StepFactors
    symmetric: bool
    """Whether the interiors' tangents are their symmetric parts"""
    proven: bool = False
    """Whether an iteration with it has gained tenfold"""


def frozen_tangent(
    machine: FullSystem,
    states: tuple[InteriorState, ...],
    turns: np.ndarray,
    factors: StepFactors,
    *,
    symmetric: bool,
) -> FrozenTangent:
    """Factor every interior's tangent at these states, or its symmetric part."""
    none = [np.zeros(interior.full.n_coordinates) for interior in machine.interiors]
    still = tuple(
        state._replace(rates=zero, accelerations=zero, frame_multipliers=np.zeros(6))
        for state, zero in zip(states, none, strict=True)
    )
    factor = FullTangent.symmetric if symmetric else FullTangent.exact
    return FrozenTangent(machine.eliminated(still, turns, factors, factor), still, turns, factors, symmetric)


def serves(tangent: FrozenTangent, factors: StepFactors) -> bool:
    """Whether it is of about the same step."""
    return bool(np.allclose(factors, tangent.factors, rtol=SIMILAR, atol=0.0))


def numbers_of(machine: FullSystem, tangent: FrozenTangent | None) -> np.ndarray:
    """What a frozen tangent was made for, as one row of numbers; NaN where there is none."""
    if tangent is None:
        return np.full(_size(machine), np.nan)
    of_step = [*tangent.factors, float(tangent.symmetric), float(tangent.proven)]
    parts = [np.ravel(getattr(state, name)) for state in tangent.states for name in _FIELDS]
    return np.concatenate([of_step, np.ravel(tangent.turns), *parts]).astype(float)


def tangent_of(machine: FullSystem, numbers: np.ndarray) -> FrozenTangent | None:
    """The tangent that `numbers_of` describes, factored again."""
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
