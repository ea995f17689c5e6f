"""Where the rounds of a self-correction are kept as they are computed, for one that was cut off to go on."""

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
    """What is known of the motion outside a body's basis on a run; see `Round`."""

    indicator: float
    singular_values: np.ndarray
    error: float
    doubtful: bool = False
    """Whether the error needs a second run to confirm it (`BodyError.is_doubtful`)"""


@dataclass(frozen=True, eq=False)
class RoundBases:
    """What a run starts from.

    bases : ReductionBasis, by body
    missed : MissedMotion, by body      of the run before, from which the bases were enriched; empty at first
    seconds : float                     wall time of the round before
    besides : float, by quantity        of the run before in quantities of interest (`Problem.besides`)
    """

    bases: Mapping[str, ReductionBasis]
    missed: Mapping[str, MissedMotion] = field(default_factory=dict)
    seconds: float = 0.0
    besides: Mapping[str, float] = field(default_factory=dict)


class RoundArchive(Protocol):
    """Keeps the bases and the motion of every run, numbered from 0; `results.CorrectionFolder` is one."""

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:
        """Those kept for a run by a self-correction that was cut off; None where it did not get so far.

        fulls : the bodies, by name, with their frames
        """
        ...

    def keep_bases(self, number: int, bases: RoundBases) -> None:
        """Called before the run starts."""
        ...

    def simulate(self, number: int, system: System, run: Run, *, progress: Progress) -> Solution:
        """The motion from its start, as far as it goes: `Solution.stopped` is the reason of an early end."""
        ...


class InMemoryArchive:
    """Keeps nothing: all there is of the rounds is in memory."""

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:  # noqa: ARG002
        """None."""
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
        """Just that."""
        return watched_run(system, run, progress=progress, check=False)
