"""Energies of a machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.equations import balances
from supple.integrate import Solution
from supple.machine import System
from supple.quantities.reading import Channel, QuantityKind

__all__ = ["EnergySensor"]


@dataclass(frozen=True)
class EnergySensor:
    """Kinetic energy, strain energy of the bodies, potential energy of gravity, and their sum.

    Springs and what they store are not in it. The potential is zero at the global origin.
    """

    name: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """kinetic, strain, potential, total."""
        return [
            Channel(each, QuantityKind.ENERGY, "") for each in ("kinetic", "strain", "potential", "total")
        ]

    def values(self, system: System, solution: Solution) -> NDArray[np.float64]:
        """(t, 4)."""
        found = balances(system, solution)
        return np.column_stack([found.kinetic, found.strain, found.potential, found.total])
