"""Archives of the rounds of a self-correction, from which an interrupted self-correction is continued."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from supple.body.full_body import FullBody
from supple.integrate import Progress, Run, Solution
from supple.machine.system import System
from supple.reduction import ReductionBasis
from supple.simulation.watched_run import watched_run

__all__ = ["MissedMotion", "RoundArchive", "RoundBases"]


class MissedMotion(NamedTuple):
    """Motion outside a body's basis on a run; fields as in `Round`."""

    indicator: float
    singular_values: np.ndarray
    error: float
    doubtful: bool = False
    """Whether the error needs a second run to confirm it (`BodyError.is_doubtful`)"""


@dataclass(frozen=True, eq=False)
class RoundBases:
    """Bases with which a run starts.

    bases : ReductionBasis, by body
    missed : MissedMotion, by body      in the previous run, which enriched the bases; empty at first
    seconds : float                     wall time of the previous round
    besides : float, by quantity        errors of the previous run in further quantities (`Problem.besides`)
    """

    bases: Mapping[str, ReductionBasis]
    missed: Mapping[str, MissedMotion] = field(default_factory=dict)
    seconds: float = 0.0
    besides: Mapping[str, float] = field(default_factory=dict)


class RoundArchive(Protocol):
    """Stores the bases and the motion of every run, numbered from 0; example: `CorrectionFolder`."""

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:
        """The bases stored for a run by an interrupted self-correction; None where there are none.

        fulls : the bodies, by name, with their frames
        """
        ...

    def keep_bases(self, number: int, bases: RoundBases) -> None:
        """Store the bases of a run; called before the run starts."""
        ...

    def simulate(self, number: int, system: System, run: Run, *, progress: Progress) -> Solution:
        """Simulate a run, or continue its stored part; `Solution.stopped` is the reason of an early end."""
        ...


class InMemoryArchive:
    """An archive without storage: each run is simulated, no bases are read."""

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:  # noqa: ARG002
        """No stored bases: None."""
        return None

    def keep_bases(self, number: int, bases: RoundBases) -> None:
        """Does nothing."""

    def simulate(
        self,
        number: int,  # noqa: ARG002
        system: System,
        run: Run,
        *,
        progress: Progress,
    ) -> Solution:
        """Simulate the run."""
        return watched_run(system, run, progress=progress, check=False)
