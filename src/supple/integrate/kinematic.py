"""Option for machines whose motion is completely determined by their joints and the laws of the joints."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Kinematic"]


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
