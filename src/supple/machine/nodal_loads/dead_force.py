"""Nodal forces fixed in space, given in time: one force or one per node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["DeadForce"]


@dataclass(frozen=True, kw_only=True)
class DeadForce:
    """Forces in global components at an interface or at nodes of a body."""

    body: str
    at: str | Sequence[int] | np.ndarray
    """An interface's name, or node indices (k,)."""
    force: Any
    """(3,) for an interface or for every node alike, or (k, 3): constant, law or function of time."""

    @property
    def law(self) -> TimeLaw:
        """The forces over time."""
        return as_time_law(self.force)

    @property
    def label(self) -> str:
        """Name for messages."""
        where = f"'{self.at}'" if isinstance(self.at, str) else f"{len(self.at)} nodes"
        return f"DeadForce on {where} of '{self.body}'"
