"""Control of the step size, and of the convergence of iterations."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from supple.arguments import check_fields

__all__ = ["AdaptiveStep", "FixedStep", "StepControl", "Tolerances"]


def check_positive(**values: float) -> None:
    """ValueError unless the values are positive and finite."""
    for name, value in values.items():
        if not (isfinite(value) and value > 0):
            raise ValueError(f"{name} must be a positive, finite number, got {value}")


def _check_smallest(smallest: float, first: float) -> None:
    if smallest > first:
        raise ValueError(
            f"the smallest step ({smallest:g}) exceeds the first ({first:g}): lower `smallest` as well"
        )


# Ratio of the smallest step, by default, to the first step. A ratio does not depend on the unit of time.
SMALLEST = 1e-6


@dataclass(frozen=True)
class FixedStep:
    """Steps of one size, in the unit of time; a step that does not converge is halved, with a warning.

    If the interval between output times is not a multiple of the size, the size is reduced until it is.
    """

    size: float
    smallest: float | None = None
    """Smallest step; the run ends if a step would have to be smaller. Default: a millionth of the size."""

    def __post_init__(self) -> None:
        check_fields(self)
        check_positive(size=self.size, smallest=self.least)
        _check_smallest(self.least, self.size)

    @property
    def first(self) -> float:
        """The first step."""
        return self.size

    @property
    def largest(self) -> float:
        """The largest step."""
        return self.size

    @property
    def least(self) -> float:
        """The step below which the run ends."""
        return SMALLEST * self.size if self.smallest is None else self.smallest

    @property
    def tolerance(self) -> float:
        """Infinite: a fixed step has no limit of its local error."""
        return float("inf")


@dataclass(frozen=True)
class AdaptiveStep:
    """Steps chosen so that the local error stays below `tolerance`.

    first, largest : first and largest step, in the unit of time
    tolerance : largest local error: the error that one step causes. It is the largest of the errors of
        translations and coordinates of full bodies, divided by the size of the system; of reduced
        coordinates, divided by this size and the square root of the mass of the body; of rotations, in rad
    """

    first: float = 1e-6
    largest: float = 1e-2
    tolerance: float = 1e-6
    smallest: float | None = None
    """Smallest step; the run ends if a step would have to be smaller. Default: a millionth of the first."""

    def __post_init__(self) -> None:
        check_fields(self)
        check_positive(first=self.first, largest=self.largest, tolerance=self.tolerance, smallest=self.least)
        if self.first > self.largest:
            raise ValueError(f"the first step ({self.first}) exceeds the largest ({self.largest})")
        _check_smallest(self.least, self.first)

    @property
    def least(self) -> float:
        """The step below which the run ends."""
        return SMALLEST * self.first if self.smallest is None else self.smallest


StepControl = FixedStep | AdaptiveStep
"""Control of the step size."""


@dataclass(frozen=True)
class Tolerances:
    """Convergence criteria of Newton's iteration.

    residual : largest relative residual. Residuals of forces, moments and generalised forces are divided by
        the largest term of their balance: inertia, internal, applied or joint force. Residuals of constraint
        equations are divided by `StepFactors.by_position`, so that they are accelerations. A residual at
        rounding error, whose correction is below 1e-13 of the size of the system, counts as converged: a very
        small tolerance costs iterations, but the run does not fail
    max_iterations : largest number of iterations per step
    """

    residual: float = 1e-6
    max_iterations: int = 12

    def __post_init__(self) -> None:
        check_fields(self)
        check_positive(residual=self.residual)
        if self.max_iterations < 1:
            raise ValueError(f"max_iterations must be at least 1, got {self.max_iterations}")
