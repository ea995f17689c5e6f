"""The motion of the tip relative to the root, and the largest difference of two such motions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TipMotion", "apart"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TipMotion:
    """Tip displacement in axes of the root, [Wu2019] (51): axial `u`, transverse `v`, (t,) each."""

    times: Array
    u: Array
    v: Array

    def peak(self) -> tuple[float, float]:
        """Largest deflection and its time, from the parabola through the three samples about the extreme."""
        i = int(np.clip(np.argmin(self.v), 1, len(self.v) - 2))
        before, at, after = self.v[i - 1 : i + 2]
        curvature = before - 2 * at + after
        shift = 0.5 * (before - after) / curvature if curvature > 0 else 0.0
        step = self.times[i + 1] - self.times[i]
        return float(at - 0.25 * (before - after) * shift), float(self.times[i] + shift * step)

    def mean_extension(self, after: float) -> float:
        """Mean axial displacement from a time on."""
        return float(self.u[self.times >= after].mean())


def apart(one: TipMotion, other: TipMotion) -> Array:
    """Distance (t,) between two tips at every time that both runs cover."""
    n = min(len(one.times), len(other.times))
    return np.hypot(one.u[:n] - other.u[:n], one.v[:n] - other.v[:n])
