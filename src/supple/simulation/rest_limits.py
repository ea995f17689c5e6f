"""Check that an equilibrium is within the limits of the kinematics, as a run is."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from supple.equations.checks.validity import watch
from supple.integrate import Solution, Validity
from supple.machine import Placed, System

__all__ = ["warn_of_rest_limits"]

ROUND = 0.1
"""Difference of a body's two spreads across the spin axis, relative to all its spread, below which it is a
rotor: centrifugal tension across the axis does not stiffen its bending."""


def warn_of_rest_limits(system: System, solution: Solution, stated: Container[str]) -> None:
    """ValidityWarning of every limit of `watch` that the bodies exceed at rest or in steady rotation.

    A linear body that is a rotor may have any spin: centrifugal force has no resultant in it.

    system, solution : in equilibrium, with the velocities of its steady rotation
    stated : bodies with an estimate of the basis error, which contains stiffness missing in a basis
    """
    monitor = watch(system, Validity())
    peaks = monitor.peaks(solution)
    for placed in system.bodies:
        body = placed.body
        if body.name in peaks and (_is_rotor(placed) if body.is_linear else body.name in stated):
            peaks[body.name] = peaks[body.name]._replace(spin=0.0)
    monitor.report(peaks)


def _is_rotor(placed: Placed) -> bool:
    """Whether the nodes are spread about the axis of the body's rotation as in a shaft or a disc."""
    if placed.angular_velocity is None or placed.velocity is None:
        return False
    turn = placed.rotation @ placed.angular_velocity
    rate = float(np.linalg.norm(turn))
    if not rate:
        return False
    point = placed.position + np.cross(turn, placed.velocity) / rate**2
    arms = placed.position + placed.body.nodes @ placed.rotation.T - point
    across = arms - np.outer(arms @ turn, turn) / rate**2
    whole = float(np.sum((arms - arms.mean(axis=0)) ** 2)) + float(np.sum(across**2))
    spread = np.linalg.eigvalsh(across.T @ across)  # ascending; zero along the axis
    centre = len(arms) * float(np.sum(across.mean(axis=0) ** 2))
    return bool(spread[2] - spread[1] <= ROUND * whole and centre <= ROUND * whole)
