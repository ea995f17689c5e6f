"""Acceleration of the base of a machine: a shaking table, an earthquake, a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from supple.machine.laws.time_law import OverTime, TimeLaw, as_time_law

__all__ = ["BaseAcceleration"]


@dataclass(frozen=True, kw_only=True)
class BaseAcceleration:
    """Acceleration a(t) of the base, which is the ground of the machine.

    Like gravity, the load acts on every mass m, with the force `- m a(t)`. Results are relative to the base:
    positions, displacements, and the end "ground" of joints. The energies of `balances` include gravity, but
    not this load.
    """

    acceleration: OverTime
    """(3,) global components: a constant, a law or a function of time."""

    @property
    def law(self) -> TimeLaw:
        """The acceleration over time."""
        return as_time_law(self.acceleration)

    label: ClassVar[str] = "BaseAcceleration"
    """Name for messages."""
