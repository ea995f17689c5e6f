"""Option for motions that joints and their laws determine completely."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Kinematic"]


@dataclass(frozen=True)
class Kinematic:
    """Kinematic analysis instead of time integration, for machines with zero degrees of freedom.

        g(q, t) = 0,      G v = -g_t,      G vdot = -d2g/dt2 at constant v

    and the joint forces follow from the motion (inverse dynamics). Each instant is solved separately, until
    the joints are closed. The run's step is the largest interval between two instants: if several
    configurations satisfy the joints, the one nearest to the previous instant is found. Bodies keep their
    shape.

    Source: [Nikravesh1988] chapter 3; for the forces chapter 8.
    """
