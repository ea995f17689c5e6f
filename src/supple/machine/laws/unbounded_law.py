"""Laws that are defined at all times."""

from __future__ import annotations

__all__ = ["UnboundedLaw"]


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
