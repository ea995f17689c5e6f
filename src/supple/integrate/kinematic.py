"""Motions that joints and their laws determine alone."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Kinematic"]


@dataclass(frozen=True)
class Kinematic:
    """In the place of an integrator: a machine whose joints leave nothing free is moved by them alone.

        g(q, t) = 0,      G v = -g_t,      G vdot = -d2g/dt2 at constant v

    and the joints' forces follow from the motion (inverse dynamics). Nothing is integrated: each instant is
    as exact as the joints are closed. The run's step is how far one instant may lie from the next, for of
    several configurations in which the joints fit the nearest is taken. Bodies keep their shape.

    Source: [Nikravesh1988] chapter 3; for the forces chapter 8.
    """
