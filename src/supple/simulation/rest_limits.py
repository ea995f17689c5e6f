"""Check that an equilibrium is within the limits of the kinematics, as a run is."""

from __future__ import annotations

from collections.abc import Container

from supple.equations.checks.validity import is_rotor, watch
from supple.integrate import FramedMotion, Solution, Validity
from supple.machine import System

__all__ = ["warn_of_rest_limits"]


def warn_of_rest_limits(system: System, solution: Solution, stated: Container[str]) -> None:
    """ValidityWarning of every limit of `watch` that the bodies exceed at rest or in steady rotation.

    A linear body that is a rotor may have any spin: centrifugal force has no resultant in it.

    system, solution : in equilibrium, with the velocities of its steady rotation
    stated : bodies with an estimate of the basis error, which contains stiffness missing in a basis
    """
    monitor = watch(system, Validity())
    peaks = monitor.peaks(solution)
    for body in (placed.body for placed in system.bodies if placed.body.name in peaks):
        motion = solution.motion(body.name, FramedMotion)
        if is_rotor(body, motion, 0) if body.is_linear else body.name in stated:
            peaks[body.name] = peaks[body.name]._replace(spin=0.0)
    monitor.report(peaks)
