"""How an explicit run steps."""

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
    """Central differences, of modal parts on four-point frames; the run's step is that of finite elements.

    scheme : of the four-point frames: ProjectedDifference() or PublishedScheme(..)
    safety : part of the step limit that is used, where the run has no FixedStep
    largest_ratio : steps of the elements in one step of the frames; 1: one step for all
    interface_loss : of the energy: what is lost, or won, between parts that march at different steps from
        one output time to the next; above it the ratio is halved, and the way repeated
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
            raise ModelError(f"the loss at the interface must be positive, got {self.interface_loss}")


def explicit_method(run: Run) -> Explicit:
    """That of a run, or the usual one where it names none."""
    return run.method if isinstance(run.method, Explicit) else Explicit()
