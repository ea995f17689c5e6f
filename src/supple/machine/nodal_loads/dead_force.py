"""Nodal forces fixed in space, given in time: one force or one per node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from supple.errors import ModelError
from supple.machine.ends import GROUND, as_end
from supple.machine.laws.time_law import TimeLaw, as_time_law

__all__ = ["DeadForce"]


@dataclass(frozen=True, kw_only=True)
class DeadForce:
    """Forces in global components at an interface or at nodes of a body."""

    body: str = ""
    """Its name; left out where `at` names it too."""
    at: str | Sequence[int] | np.ndarray
    """An interface's name, or node indices (k,), of the body; or "BODY.INTERFACE"."""
    force: Any
    """(3,) for an interface or for every node alike, or (k, 3): constant, law or function of time."""

    def __post_init__(self) -> None:
        if self.body:
            return
        if not isinstance(self.at, str):
            raise ModelError("DeadForce on nodes: name the body that they belong to")
        end = as_end(self.at)
        if end == GROUND:
            raise ModelError("DeadForce acts on the ground: name a body's interface")
        object.__setattr__(self, "body", end.body)
        object.__setattr__(self, "at", end.interface)

    @property
    def law(self) -> TimeLaw:
        """The forces over time."""
        return as_time_law(self.force)

    @property
    def label(self) -> str:
        """Name for messages."""
        where = f"'{self.at}'" if isinstance(self.at, str) else f"{len(self.at)} nodes"
        return f"DeadForce on {where} of '{self.body}'"
