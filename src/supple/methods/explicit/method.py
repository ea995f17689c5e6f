"""Options of an explicit run."""

from __future__ import annotations

from dataclasses import dataclass, field

from supple.arguments import check_fields
from supple.errors import ModelError
from supple.integrate import ExplicitRule, Run
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.published_scheme import PublishedScheme

__all__ = ["Explicit"]


@dataclass(frozen=True)
class Explicit(ExplicitRule):
    """Central differences; the frame of a modal part is given by four points at fixed distances.

    FixedStep sets the largest step of the elements, or of the frames if there are no elements.

    scheme : time integration of the four-point frames: ProjectedDifference() or PublishedScheme(..)
    safety : steps as fractions of the step limits; with FixedStep, only for frames of machines with elements
    largest_ratio : largest number of element steps in one step of the frames; 1: one step for all
    interface_loss : largest energy lost or gained between parts with different steps from one output time to
        the next, relative to the energy of the run; above it the interval is repeated with half the ratio
    """

    scheme: ProjectedDifference | PublishedScheme = field(default_factory=ProjectedDifference)
    safety: float = 0.9
    largest_ratio: int = 50
    interface_loss: float = 2e-4

    def __post_init__(self) -> None:
        check_fields(self)
        if not 0 < self.safety <= 1:
            raise ModelError(f"the safety of the step must lie in (0, 1], got {self.safety}")
        if self.largest_ratio < 1:
            raise ModelError(f"the largest ratio must be at least 1, got {self.largest_ratio}")
        if not self.interface_loss > 0:
            raise ModelError(f"the interface loss must be positive, got {self.interface_loss}")


def explicit_method(run: Run) -> Explicit:
    """The explicit method of a run, or the default where it gives none."""
    return run.method if isinstance(run.method, Explicit) else Explicit()
