"""Target error, rounds and results of a self-correcting reduction."""

from __future__ import annotations

import warnings
from collections.abc import Container, Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.algebra import read_only
from supple.arguments import check_fields
from supple.errors import AccuracyError, BasisWarning, ModelError
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
    "warn_of_fixed_sizes",
]


@dataclass(frozen=True)
class SelfCorrection:
    """The target error of a self-correction, and its limits.

    absolute : float        largest allowed RMS error of the nodal positions over the run, unit of length; or
    relative : float        ratio of this error to the largest displacement of a node; displacements are
                            relative to the body's first interface, or to the floating frame of a body that
                            has no interface
    instants : int          number of stratified sample times at which static equilibrium gives the motion
                            outside the basis; the times of load peaks and kinks are added
    directions : int        columns added per round and body; fewer may save a few columns, but a missing
                            stiff direction causes locking and costs a further round
    largest_size : int      largest number of coordinates of the basis
    max_rounds : int        largest number of enrichments
    of : QuantityOfInterest     quantity whose error is limited; by default the positions of all nodes.
                            `absolute` is in the unit of this quantity, `relative` a fraction of its size

    Raises ModelError when both or none of absolute and relative are given, or a number is not positive.
    """

    absolute: float | None = None
    relative: float | None = None
    instants: int = 24
    directions: int = 4
    largest_size: int = 60
    max_rounds: int = 8
    of: QuantityOfInterest | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.absolute is None) == (self.relative is None):
            raise ModelError("self-correction: give the target error either as absolute or as relative")
        for name, value in vars(self).items():
            if name != "of" and value is not None and not (np.isfinite(value) and value > 0):
                raise ModelError(f"self-correction: {name} must be a positive number, not {value}")

    def allowed(self, size: float) -> float:
        """The target error, in the unit of the quantity of interest.

        size : reference size of the quantity; for a whole body, its largest displacement
        """
        return self.absolute or (self.relative or 0.0) * size

    def quantity(self, body: str) -> QuantityOfInterest:
        """The quantity of interest of a body."""
        return self.of or WholeBody(body)

    @property
    def wanted(self) -> str:
        """The target error as text."""
        if self.relative is None:
            return f"{self.absolute:g}" if self.of is None else f"{self.absolute:g} in {self.of.words}"
        return f"{self.relative:g} of " + ("the displacement" if self.of is None else self.of.words)


@dataclass(frozen=True)
class ReductionStart:
    """Settings with which the self-correction of one body starts, and the target error of this body.

    target : SelfCorrection
    basis, derivatives, quartic : as for `reduce`, with other defaults. By default the tensors are plain (not
        condensed), because the rounds add missing directions to the basis, and loads do not act on condensed
        motion
    """

    target: SelfCorrection = field(default_factory=lambda: SelfCorrection(relative=1e-3))
    basis: LinearBasisRecipe = field(default_factory=lambda: CraigBampton(n_modes=5))
    derivatives: DerivativeChoice = field(default_factory=lambda: CompressedDerivatives(5))
    quartic: QuarticChoice = field(default_factory=PlainQuartic)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, eq=False)
class Round:
    """One run of a self-correction and the estimated error of the basis of one body.

    body : ReducedBody
    solution : Solution             up to the time at which the run stopped
    estimated_error : float         error of the quantity of interest by the error equation; by default the
                                    largest RMS error of the nodal positions. Infinite if the run stopped
                                    early, if the error is too large for the equation, or if the indicator
                                    of the first round exceeds the allowed error
    indicator : float               size of the quasi-static motion outside the basis: its largest RMS over
                                    the nodes at a sample time; infinite if no equilibrium was found
    singular_values : (k,)          of the displacement fields outside the basis, in the M-norm, descending
    seconds : float                 wall time of reduction, run and error estimate, for all bodies
    allowed : float                 the target error, in the unit of the quantity of interest
    useless : bool                  no improvement over the previous round
    unconfirmed : bool              the estimated error is doubtful (the body locks, or the quasi-static
                                    motion outside the basis exceeds both the estimated and the allowed
                                    error), and no second run has confirmed it
    number : int | None             number of the run in the archive; None: equal to that of the round
    run : Run | None                the settings with which the run was made
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
    """A reduced body that meets its target error on a run, and the rounds of its self-correction.

    rounds : Round              the last one meets the target
    basis : ReductionBasis      of the last round
    next_basis : ReductionBasis     for a further round: `basis`, and the leading directions outside it
    """

    rounds: tuple[Round, ...]
    basis: ReductionBasis
    next_basis: ReductionBasis

    @property
    def body(self) -> ReducedBody:
        """The reduced body of the last round."""
        return self.rounds[-1].body

    @property
    def solution(self) -> Solution:
        """The run of the last round."""
        return self.rounds[-1].solution

    @property
    def estimated_error(self) -> float:
        """Estimated error of the last round, in the unit of the quantity of interest."""
        return self.rounds[-1].estimated_error


@dataclass(frozen=True, eq=False)
class CorrectedSystem:
    """A system whose reduced bodies all meet their target errors on one run.

    system : System                     with the reduced bodies
    bodies : SelfCorrected, by name     their rounds, with shared runs
    run : Run                           settings of the accepted run; None: unchanged from the given ones
    of_basis : ErrorPart, by quantity   reduction error of the further quantities of interest of a study
    """

    system: System
    bodies: Mapping[str, SelfCorrected]
    run: Run | None = None
    of_basis: Mapping[str, ErrorPart] = field(default_factory=dict)

    @property
    def solution(self) -> Solution:
        """The accepted run."""
        return next(iter(self.bodies.values())).solution


class SelfCorrectionError(AccuracyError):
    """The target error was not met; `rounds`: the assessed runs, empty for a correction at rest."""

    def __init__(self, message: str, rounds: tuple[Round, ...]) -> None:
        super().__init__(message)
        self.rounds = rounds


def warn_of_fixed_sizes(system: System, corrected: Container[str]) -> None:
    """BasisWarning if reduced bodies are not corrected: no estimated error contains their basis errors."""
    fixed = [
        f"'{name}'"
        for name, body in system.bodies_of(ReducedBody).items()
        if name not in corrected and body.full is not None and body.r < body.full.n_coordinates - 6
    ]
    if fixed:
        warnings.warn(
            f"self-correction: the basis of {' and '.join(fixed)} has a fixed size; its error changes the "
            "motion of all bodies, and no estimated error contains it. Correct this basis too (accuracy = "
            "{ relative = 1e-3 }; in Python a FullBody), or compare with a run with more modes",
            BasisWarning,
            stacklevel=4,
        )
