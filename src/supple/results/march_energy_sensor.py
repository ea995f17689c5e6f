"""The energies of an explicit run as a quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import ENERGIES, Energies
from supple.quantities import Channel, QuantityKind

__all__ = ["MarchEnergySensor"]


@dataclass(frozen=True)
class MarchEnergySensor:
    """Energies of an explicit run: kinetic, internal, plastic, ...; see `Energies`."""

    name: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """One channel for each of `Energies`."""
        return [Channel(each, QuantityKind.ENERGY, "") for each in Energies._fields]

    def values(self, _system: System, solution: Solution) -> NDArray[np.float64]:
        """The energies, (t, 8)."""
        return np.asarray(solution.series[ENERGIES])
