"""One case of the trust benchmark: a machine of full bodies, its run, and the allowed error."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from supple.error import SelfCorrection
from supple.integrate import FixedStep, Run
from supple.machine import System
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    DerivativeChoice,
    LinearBasisRecipe,
)

__all__ = ["TrustCase", "file_name"]


def file_name(name: str) -> str:
    """Name of the files of the record and the full runs of a case."""
    return re.sub(r"\W+", "-", name)


@dataclass(frozen=True, eq=False)
class TrustCase:
    """A machine reduced by self-correction.

    name : str              name in the report
    system : function       creates the machine, with all bodies to be reduced in full
    duration, n_outputs     of the run; the step is the output step
    accuracy : float        allowed error, relative to the size of the motion
    basis, derivatives      starting basis
    """

    name: str
    system: Callable[[], System]
    duration: float
    n_outputs: int
    accuracy: float = 1e-3
    basis: LinearBasisRecipe = field(default_factory=lambda: CraigBampton(n_modes=5))
    derivatives: DerivativeChoice = field(default_factory=lambda: CompressedDerivatives(5))

    @property
    def run(self) -> Run:
        """The run as requested; `self_correct` shortens its step if the step is too long."""
        output_step = self.duration / self.n_outputs
        return Run(self.duration, output_step, step=FixedStep(output_step))

    @property
    def target(self) -> SelfCorrection:
        """The allowed error, for the sum of all parts of the error."""
        return SelfCorrection(relative=self.accuracy, max_rounds=10)
