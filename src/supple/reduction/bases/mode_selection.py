"""Rules that select the fixed-interface modes of a Craig-Bampton basis."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from supple.body import FlexibleBody
from supple.errors import ModelError
from supple.reduction.components.fixed_interface_component import (
    FixedInterfaceComponent,
    fixed_interface_component,
    fixed_interface_modes,
)

__all__ = ["ChosenModes", "LowestFrequency", "ModeSelection"]


class ChosenModes(NamedTuple):
    """Fixed-interface modes in ascending order of frequency."""

    values: np.ndarray
    """(k,) rad^2/s^2"""
    vectors: np.ndarray
    """(n, k)"""
    numbers: np.ndarray
    """(k,) int: numbers of the modes among all fixed-interface modes by frequency, the lowest is 1"""


class ModeSelection(Protocol):
    """A rule: LowestFrequency(), EffectiveInterfaceMass(candidates) or CouplingMoment(candidates)."""

    def choose(self, body: FlexibleBody, n_modes: int) -> ChosenModes:
        """The n_modes fixed-interface modes that the rule selects."""
        ...


@dataclass(frozen=True)
class LowestFrequency:
    """The modes of lowest frequency, whatever their participation at the interfaces."""

    def choose(self, body: FlexibleBody, n_modes: int) -> ChosenModes:
        """The n_modes lowest modes; ModelError if the body has fewer."""
        modes = fixed_interface_modes(body, n_modes)
        return ChosenModes(modes.values, modes.vectors, np.arange(1, n_modes + 1))


@dataclass(frozen=True)
class RankedModes(ABC):
    """Base of rules that assign each mode a score, and keep the modes of largest score.

    candidates : number of lowest modes that are ranked
    """

    candidates: int

    @abstractmethod
    def scores(self, body: FlexibleBody, component: FixedInterfaceComponent) -> np.ndarray:
        """(m,) scores, one for each mode of the component."""

    def choose(self, body: FlexibleBody, n_modes: int) -> ChosenModes:
        """The n_modes modes of largest score.

        Raises ModelError if n_modes exceeds the candidates, or these the number of modes of the body.
        """
        if n_modes > self.candidates:
            raise ModelError(
                f"{n_modes} modes cannot be chosen among {self.candidates} candidates; give more candidates"
            )
        modes = fixed_interface_modes(body, self.candidates)
        scores = self.scores(body, fixed_interface_component(body, modes))
        best = np.sort(best_first(scores)[:n_modes])
        return ChosenModes(modes.values[best], modes.vectors[:, best], best + 1)


def best_first(scores: np.ndarray) -> np.ndarray:
    """Mode numbers (from 0) by descending score; among equal scores the lower frequency comes first."""
    return np.argsort(-scores, kind="stable")
