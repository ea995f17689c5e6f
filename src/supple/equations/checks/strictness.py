"""Warnings of checks, which are errors in a strict run."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from supple.errors import SuppleWarning, ValidityError, ValidityWarning
from supple.integrate import Solution, Validity

T = TypeVar("T")


def warn_or_raise(message: str, category: type[SuppleWarning], validity: Validity) -> None:
    """Warn; in a strict run raise ValidityError instead."""
    if validity.strict:
        raise ValidityError(message)
    warnings.warn(message, category, stacklevel=4)


@dataclass(frozen=True, eq=False)
class Watch(ABC, Generic[T]):
    """Extremes of a run by name, observed leg by leg, and the action at those beyond their limits."""

    validity: Validity

    @abstractmethod
    def updated(self, so_far: Mapping[str, T], leg: Solution) -> dict[str, T]:
        """The extremes including those of a leg."""

    @abstractmethod
    def excesses(self, found: Mapping[str, T]) -> list[str]:
        """A message for every exceeded limit."""

    def observe(self, so_far: Mapping[str, T], leg: Solution) -> dict[str, T]:
        """The extremes including those of a leg; in a strict run ValidityError at an exceeded limit."""
        found = self.updated(so_far, leg)
        if self.validity.strict:
            for message in self.excesses(found):
                raise ValidityError(message)
        return found

    def report(self, found: Mapping[str, T]) -> None:
        """Warn of every exceeded limit."""
        for message in self.excesses(found):
            warnings.warn(message, ValidityWarning, stacklevel=3)
