"""Explicit rules for first-order equations, such as those of intrinsic bodies."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arguments import check_fields

__all__ = ["FirstOrderRule", "ResidualRungeKutta4", "RungeKutta4"]


@dataclass(frozen=True)
class RungeKutta4:
    """The classical explicit rule of fourth order, stable for `h omega_max < 2.83`; less with damping.

    h is the step and omega_max the highest angular frequency.
    """


@dataclass(frozen=True)
class ResidualRungeKutta4:
    """`RungeKutta4` for the lowest modes, which limit the step; the higher modes follow quasi-statically.

    n_kept : int            number of dynamic modes, rigid ones included
    sweeps : int            iterations for the higher modes at each of the rule's four stages
    largest_contraction : float     limit of the ratio of the last correction of the higher modes to the
        correction before; the run ends if the ratio exceeds this limit
    """

    n_kept: int
    sweeps: int = 3
    largest_contraction: float = 0.5

    def __post_init__(self) -> None:
        check_fields(self)
        if self.n_kept < 1:
            raise ValueError(f"n_kept must be at least 1, got {self.n_kept}")
        if self.sweeps < 2:
            raise ValueError(f"sweeps must be at least 2, got {self.sweeps}: contraction needs two of them")
        if not 0 < self.largest_contraction < 1:
            raise ValueError(f"largest_contraction must lie between 0 and 1, got {self.largest_contraction}")


FirstOrderRule = RungeKutta4 | ResidualRungeKutta4
"""A step rule for first-order equations only."""
