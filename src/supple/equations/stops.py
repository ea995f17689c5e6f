"""Times at which steps stop besides output times: the instants that an adaptive step must not skip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from supple.equations.sampling import sampling_of
from supple.integrate import AdaptiveStep, Run
from supple.machine import System, TimeLaw
from supple.machine.laws.instants import instants_of_law

_NEAREST = 1e-5
"""Fraction of the duration: instants nearer to an output time or a call of a controller are skipped, because
accelerations would lose digits. This distance is at most the first step, and at least the smallest step."""

_ROUNDING = 1e-12
"""Times whose relative difference is smaller are equal."""


def laws_of(system: System) -> list[tuple[str, TimeLaw]]:
    """Names and laws of all prescribed motions and loads that have a law, in that order.

    The loads include the force elements that controllers drive.
    """
    every = [(f"joint '{joint.name}'", joint.law) for joint in system.joints]
    every += [(load.label, load.law) for load in system.acting]
    return [(name, law) for name, law in every if law is not None]


def stepping_instants(systems: Sequence[System], run: Run) -> np.ndarray:
    """Ascending times (k,) at which adaptive steps stop besides output times; none for fixed steps."""
    control, times = run.step_control, run.times
    if not isinstance(control, AdaptiveStep):
        return np.zeros(0)
    laws = {id(law): law for system in systems for _, law in laws_of(system)}
    found = [instants_of_law(law, float(times[0]), float(times[-1])) for law in laws.values()]
    instants = np.unique(np.concatenate([np.zeros(0), *found]))
    for system in systems:
        if (sampling := sampling_of(system, run)) is not None:
            times = np.union1d(times, sampling.every)
    nearest = max(control.least, min(control.first, _NEAREST * run.duration))
    after = np.clip(np.searchsorted(times, instants), 1, len(times) - 1)
    apart = np.minimum(np.abs(instants - times[after - 1]), np.abs(times[after] - instants))
    return _spaced(instants[apart > nearest], nearest)


def _spaced(instants: np.ndarray, nearest: float) -> np.ndarray:
    """The instants without those too close to the one before."""
    kept, last = [], -np.inf
    for instant in instants:
        if instant - last > nearest:
            kept.append(instant)
            last = instant
    return np.array(kept)


@dataclass(frozen=True, eq=False)
class Stops:
    """The output times of a run (t,) and the instants between them (k,)."""

    times: np.ndarray
    instants: np.ndarray

    def on_the_way(self, reached: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stops between a time and some output times, and the indices of the output times among the stops."""
        # A resumed run may have reached an instant up to the last digit.
        begun = reached + _ROUNDING * abs(reached)
        between = self.instants[(self.instants > begun) & (self.instants < times[-1])]
        if not between.size:
            return times, np.arange(len(times))
        stops = np.sort(np.concatenate([times, between]))
        return stops, np.searchsorted(stops, times)


def padded_stops(stops: np.ndarray, fewest: int = 1) -> np.ndarray:
    """Stops, with the last one repeated until their number is a power of two, or `fewest` if this is larger.

    Runs of similar length then share a program.
    """
    number = max(fewest, 2 ** (len(stops) - 1).bit_length())
    return np.pad(stops, (0, number - len(stops)), mode="edge")
