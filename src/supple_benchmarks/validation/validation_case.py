"""A case of the validation: what is computed, and the numbers that come out beside their references."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

__all__ = ["Comparison", "ValidationCase"]


@dataclass(frozen=True)
class Comparison:
    """One number beside its reference: error = |value - reference| / scale, at most `allowed`.

    `scale` is |reference| unless given; a reference of zero needs one, in the unit of the value. `source`
    names where the reference is from: a closed form, a paper and its table, another code and its version.
    """

    quantity: str
    value: float
    reference: float
    source: str
    allowed: float
    scale: float | None = None

    @property
    def error(self) -> float:
        """|value - reference| / scale."""
        return abs(self.value - self.reference) / (abs(self.reference) if self.scale is None else self.scale)

    @property
    def holds(self) -> bool:
        """Whether the error is at most what is allowed; never of a value that is not a number."""
        return self.error <= self.allowed


@dataclass(frozen=True)
class ValidationCase:
    """A named problem and the function that computes it; `quick` cases are part of the quick form."""

    name: str
    compare: Callable[[], Sequence[Comparison]]
    quick: bool = True
