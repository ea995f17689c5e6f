"""Numbers of a whole run over time, kept in result files beside the motions of its parts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from supple.integrate.motion import register_motion

__all__ = ["SeriesMotion"]


@register_motion
@dataclass(frozen=True)
class SeriesMotion:
    """Values (t, c): energies, steps, obstacles."""

    kind: ClassVar[str] = "series"

    values: np.ndarray

    def at(self, rows: slice | np.ndarray) -> SeriesMotion:
        """The values at some of the output times, by their numbers."""
        return SeriesMotion(self.values[rows])

    def arrays(self) -> dict[str, np.ndarray]:
        """The values."""
        return {"values": self.values}
