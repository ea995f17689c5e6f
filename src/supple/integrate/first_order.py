"""Explicit rules for first-order equations, such as those of intrinsic bodies."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arguments import check_fields

__all__ = ["FirstOrderRule", "ResidualRungeKutta4", "RungeKutta4"]


@dataclass(frozen=True)
class RungeKutta4:
    """The classical explicit rule of fourth order; stable where step times highest frequency is < 2.83."""


@dataclass(frozen=True)
class ResidualRungeKutta4:
    """The same for the lowest modes, which bind the step; the higher ones follow them at rest.

    n_kept : int            modes that stay dynamic, the rigid ones included
    sweeps : int            of the search for the others, at each of the rule's four stages
    largest_contraction : float     of the search; the run ends where it converges more slowly
    """

    n_kept: int
    sweeps: int = 3
    largest_contraction: float = 0.5

    def __post_init__(self) -> None:
        check_fields(self)
        if self.n_kept < 1:
            raise ValueError(f"n_kept must be at least 1, got {self.n_kept}")
        if self.sweeps < 2:
            raise ValueError(f"sweeps must be at least 2, got {self.sweeps}: one says nothing of contraction")
        if not 0 < self.largest_contraction < 1:
            raise ValueError(f"largest_contraction must lie between 0 and 1, got {self.largest_contraction}")


FirstOrderRule = RungeKutta4 | ResidualRungeKutta4
"""A step rule that only equations of first order take."""
