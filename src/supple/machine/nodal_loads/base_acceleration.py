"""Acceleration of the base of a machine: a shaking table, an earthquake, a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["BaseAcceleration"]


@dataclass(frozen=True, kw_only=True)
class BaseAcceleration:
    """Accelerated base; the motion is relative to it.

    `- m a(t)` acts on every mass, like gravity. The ground of the joints, positions and displacements are
    relative to the base. The energies of `balances` include gravity, not this load.
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
