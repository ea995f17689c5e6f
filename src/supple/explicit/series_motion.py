"""Numbers of a whole run over time, kept in result files beside the motions of its parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, cast

import numpy as np

from supple.integrate import Solution
from supple.integrate.motion import StackedMotion, register_motion

__all__ = ["SeriesMotion", "series_of"]


@register_motion
@dataclass(frozen=True)
class SeriesMotion(StackedMotion):
    """Values (t, c): energies, steps, obstacles."""

    kind: ClassVar[str] = "series"

    values: np.ndarray


def series_of(solution: Solution, name: str) -> np.ndarray:
    """The values (t, c) that a run keeps under a name."""
    return cast(SeriesMotion, solution.bodies[name]).values
