"""The error that a self-correcting reduction is to reach, its rounds, and what comes out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.algebra import read_only
from supple.arguments import check_fields
from supple.errors import AccuracyError, ModelError
from supple.integrate import ErrorPart, Run, Solution
from supple.machine.system import System
from supple.quantities.quantity_of_interest import QuantityOfInterest, WholeBody
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    DerivativeChoice,
    LinearBasisRecipe,
    PlainQuartic,
    QuarticChoice,
    ReducedBody,
    ReductionBasis,
)

__all__ = [
    "CorrectedSystem",
    "ReductionStart",
    "Round",
    "SelfCorrected",
    "SelfCorrection",
    "SelfCorrectionError",
]


@dataclass(frozen=True)
class SelfCorrection:
    """The error to reach, and how to get there.

    absolute : float        largest RMS error of the nodal positions over the run, unit of length; or
    relative : float        the same over the largest displacement of a node, seen from the body's first
                            interface (in its floating frame where it has none)
    instants : int          steps of a run at which its residual is balanced, at random in equal intervals;
                            besides those where loads peak or kink
    directions : int        columns added a round; fewer save a column here and there, but one stiff
                            direction left out locks the others, and costs a round
    largest_size : int      of the basis
    max_rounds : int        enrichments before giving up
    of : QuantityOfInterest     what the error is of; by default the positions of all nodes of the body
    Raises ModelError when both or none of absolute and relative are given, or a number is not positive.
    """

    absolute: float | None = None
    relative: float | None = None
    instants: int = 50
    directions: int = 4
    largest_size: int = 60
    max_rounds: int = 8
    of: QuantityOfInterest | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.absolute is None) == (self.relative is None):
            raise ModelError("self-correction: give the error to reach either as absolute or as relative")
        for name, value in vars(self).items():
            if name != "of" and value is not None and not (np.isfinite(value) and value > 0):
                raise ModelError(f"self-correction: {name} must be a positive number, not {value}")

    def allowed(self, size: float) -> float:
        """The error to reach in a quantity of a size: of the whole body, its largest displacement."""
        return self.absolute or (self.relative or 0.0) * size

    def quantity(self, body: str) -> QuantityOfInterest:
        """The quantity of interest of a body."""
        return self.of or WholeBody(body)

    @property
    def wanted(self) -> str:
        """The error to reach, in words."""
        if self.relative is None:
            return f"{self.absolute:g}" if self.of is None else f"{self.absolute:g} in {self.of.words}"
        return f"{self.relative:g} of " + ("the displacement" if self.of is None else self.of.words)


@dataclass(frozen=True)
class ReductionStart:
    """Where the reduction of a body starts, and the error at which it may stop.

    target : SelfCorrection
    basis, derivatives, quartic : as for `reduce`; plain tensors, as the rounds add the directions that bodies
        lack, and those of the run are then all that may move: loads act on every motion that takes part
    """

    target: SelfCorrection = field(default_factory=lambda: SelfCorrection(relative=1e-3))
    basis: LinearBasisRecipe = field(default_factory=lambda: CraigBampton(n_modes=5))
    derivatives: DerivativeChoice = field(default_factory=lambda: CompressedDerivatives(5))
    quartic: QuarticChoice = field(default_factory=PlainQuartic)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, eq=False)
class Round:
    """One run and the error found of the basis of one body.

    body : ReducedBody
    solution : Solution             up to where the run broke off, if it did
    estimated_error : float         largest RMS error of the nodal positions over the run, by the error
                                    equation; infinite where the run broke off, or where the error is too
                                    large for it
    indicator : float               largest RMS of the motion outside the basis, at the sample times
    singular_values : (k,)          of that motion outside the basis, in the M-norm, descending; none of a
                                    body that is enriched no more
    seconds : float                 wall time of the reduction, the run and its correction, of all bodies
    allowed : float                 the error to reach, unit of length
    useless : bool                  no better than the round before
    unconfirmed : bool              the body locks, or lacks more motion at rest than the error estimated,
                                    and no second run has confirmed that error
    number : int | None             of its run, as it is archived; that of the round where it is left out
    run : Run | None                how it was stepped
    """

    body: ReducedBody
    solution: Solution
    estimated_error: float
    indicator: float
    singular_values: np.ndarray
    seconds: float
    allowed: float = np.nan
    useless: bool = False
    unconfirmed: bool = False
    number: int | None = None
    run: Run | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "singular_values", read_only(self.singular_values))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.body.r


@dataclass(frozen=True, eq=False)
class SelfCorrected:
    """A reduced body that meets a tolerance on a run, and the rounds that led to it.

    rounds : Round              the last one meets the tolerance
    basis : ReductionBasis      of the last round
    """

    rounds: tuple[Round, ...]
    basis: ReductionBasis

    @property
    def body(self) -> ReducedBody:
        """The smallest body that meets the tolerance."""
        return self.rounds[-1].body

    @property
    def solution(self) -> Solution:
        """Its run."""
        return self.rounds[-1].solution

    @property
    def estimated_error(self) -> float:
        """Error of that run, unit of length."""
        return self.rounds[-1].estimated_error


@dataclass(frozen=True, eq=False)
class CorrectedSystem:
    """A system whose reduced bodies all meet their tolerances on one run.

    system : System                     with the reduced bodies
    bodies : SelfCorrected, by name     their rounds, which are the same runs
    run : Run                           as it was stepped; None where that is the run that was asked for
    of_basis : ErrorPart, by quantity   what the bases cost in the quantities of a study besides the targets
    """

    system: System
    bodies: Mapping[str, SelfCorrected]
    run: Run | None = None
    of_basis: Mapping[str, ErrorPart] = field(default_factory=dict)

    @property
    def solution(self) -> Solution:
        """The run."""
        return next(iter(self.bodies.values())).solution


class SelfCorrectionError(AccuracyError):
    """The tolerance was not met; `rounds` keeps every run that was made and measured."""

    def __init__(self, message: str, rounds: tuple[Round, ...]) -> None:
        super().__init__(message)
        self.rounds = rounds
