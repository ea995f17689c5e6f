"""Motion of a rigid obstacle of an explicit run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.integrate import Solution
from supple.machine import System
from supple.methods.explicit import OBSTACLES
from supple.quantities.contact_force import contact_names
from supple.quantities.reading import Channel, QuantityKind

__all__ = ["ObstacleSensor"]


@dataclass(frozen=True)
class ObstacleSensor:
    """Displacement since the start, and velocity, of the obstacle of a contact, (t, 6), global axes.

    contact : one of `contact_names`, of a contact with a rigid obstacle
    """

    name: str
    contact: str

    def channels(self, _system: System) -> Sequence[Channel]:
        """x, y, z, vx, vy, vz."""
        kinds = (("", QuantityKind.LENGTH), ("v", QuantityKind.VELOCITY))
        return [Channel(f"{letter}{axis}", kind, "global") for letter, kind in kinds for axis in "xyz"]

    def values(self, system: System, solution: Solution) -> NDArray[np.float64]:
        """(t, 6)."""
        number = contact_names(system).index(self.contact)
        return solution.series[OBSTACLES][:, 6 * number : 6 * number + 6]
