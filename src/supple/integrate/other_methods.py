"""Methods of a run besides the Newmark family: kinematics, explicit rules, rules of first order."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arguments import check_fields

__all__ = ["ExplicitRule", "FirstOrderRule", "Kinematic", "ResidualRungeKutta4", "RungeKutta4"]


class ExplicitRule:
    """Base of `supple.methods.explicit.Explicit`, the method of modal parts and nonlinear finite elements."""


@dataclass(frozen=True)
class Kinematic:
    """Kinematic analysis instead of time integration, for machines with zero degrees of freedom.

        g(q, t) = 0,      G v = -g_t,      G vdot = -d2g/dt2 at constant v

    where g are the constraint equations of the joints and G = dg/dq. The joint forces follow from the motion
    (inverse dynamics). Each instant is solved iteratively until the joints are closed. If several
    configurations satisfy the joints, the one nearest to the previous instant is found; the step of the run
    limits the interval between two instants. Bodies do not deform.

    Source: [Nikravesh1988] chapter 3; for the forces chapter 8.
    """


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
