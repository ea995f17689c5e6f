"""Acceleration of the base of a machine: a shaking table, an earthquake, a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["BaseAcceleration"]


@dataclass(frozen=True, kw_only=True)
class BaseAcceleration:
    """Acceleration a(t) of the base, which is the ground of the machine.

    The force `- m a(t)` acts on every mass m, like gravity. Positions, displacements and the ground of joints
    are relative to the base. The energies of `balances` include gravity, but not this load.
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
