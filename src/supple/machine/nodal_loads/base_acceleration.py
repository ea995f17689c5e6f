"""Acceleration of the base that a machine stands on: a shaking table, an earthquake, a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["BaseAcceleration"]


@dataclass(frozen=True, kw_only=True)
class BaseAcceleration:
    """The base accelerates; the motion is that seen from it.

    On every mass acts `- m a(t)`, as gravity does: the ground of the joints, positions and displacements are
    the base's. The energies of `balances` count gravity alone.
    """

    acceleration: Any
    """(3,) global: constant, law or function of time."""

    @property
    def law(self) -> TimeLaw:
        """The acceleration over time."""
        return as_time_law(self.acceleration)

    @property
    def label(self) -> str:
        """Name for messages."""
        return "BaseAcceleration"
