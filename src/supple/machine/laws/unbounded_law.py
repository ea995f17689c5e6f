"""Laws that are defined at all times."""

from __future__ import annotations

import numpy as np

__all__ = ["SmoothLaw", "UnboundedLaw"]


class UnboundedLaw:
    """Base of laws that are defined from minus to plus infinity."""

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        return float("-inf")

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        return float("inf")


class SmoothLaw(UnboundedLaw):
    """Base of laws without kinks, and without a time scale unless they define one."""

    def instants(self, begin: float, end: float) -> np.ndarray:  # noqa: ARG002 - no kinks
        """An empty array: the law has no kinks."""
        return np.zeros(0)

    def shortest_scale(self, begin: float, end: float) -> float:  # noqa: ARG002
        """Infinity: the law has no time scale."""
        return float("inf")
