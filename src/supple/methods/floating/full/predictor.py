"""First guess of a step's iteration: linearly extrapolated accelerations and multipliers."""

from __future__ import annotations

from typing import NamedTuple

import jax
import numpy as np

from supple.methods.floating.full.full_state import FullState, Unknowns
from supple.methods.floating.full.full_system import FullSystem


class Earlier(NamedTuple):
    """Unknowns at the start of the last step, and its size."""

    unknowns: Unknowns
    step: float


def predicted_unknowns(state: FullState, earlier: Earlier | None, h: float) -> Unknowns:
    """Unknowns at the end of a step of size h: `x_1 + (h / h_0) (x_1 - x_0)`; without `earlier`, `x_1`."""
    if earlier is None:
        return state.unknowns
    ratio = h / earlier.step
    return jax.tree.map(lambda own, old: own + ratio * (own - old), state.unknowns, earlier.unknowns)


def earlier_numbers(machine: FullSystem, earlier: Earlier | None) -> np.ndarray:
    """`Earlier` as one row of numbers; NaN before the first step."""
    if earlier is None:
        return np.full(_size(machine), np.nan)
    acceleration, multipliers, frames = earlier.unknowns
    return np.concatenate([[earlier.step], acceleration, multipliers, *frames])


def earlier_of(machine: FullSystem, numbers: np.ndarray) -> Earlier | None:
    """The `Earlier` described by `earlier_numbers`; None for NaN or numbers of another machine."""
    if len(numbers) != _size(machine) or not np.isfinite(numbers).all():
        return None
    m = len(machine.model.active)
    acceleration, multipliers, frames = np.split(numbers[1:], [machine.n, machine.n + m])
    return Earlier(Unknowns(acceleration, multipliers, tuple(frames.reshape(-1, 6))), float(numbers[0]))


def _size(machine: FullSystem) -> int:
    return 1 + machine.n + len(machine.model.active) + 6 * len(machine.interiors)
