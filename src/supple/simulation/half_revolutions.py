"""Check that angles stay in the range of force elements that do not count revolutions."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_log
from supple.equations.checks.strictness import warn_or_raise
from supple.errors import ValidityWarning
from supple.integrate import Run, Solution
from supple.machine import AngleServo, Bushing, ForceElement, System, TabledTorque, TorsionSpringDamper
from supple.machine.forces.relative_motion import wrapped
from supple.machine.pose import Pose
from supple.quantities.end_motion import axial_motions, both_ends

_COUNTING = (
    "For larger angles use a Controller, whose JointReading counts revolutions, with a TorqueBetween, or an "
    "AngleServo for a rest angle that the motion follows"
)


def report_half_revolutions(system: System, run: Run, solution: Solution) -> None:
    """Warn (ValidityWarning) of force elements whose moment jumps where an angle passes half a revolution.

    Raises ValidityError instead in a strict run. Intervals between output times in which an angle changes by
    half a revolution or more are not checked, unless all intervals are so long and the angle changes by more
    than a revolution.
    """
    intervals = np.diff(solution.times)
    for load in system.loads:  # the set-point of a servo that a controller drives is unknown
        if not isinstance(load, ForceElement) or not (consequence := _consequence(load)):
            continue
        ends = both_ends(system, solution, load, load.label)
        angles, rates = map(np.asarray, _angles(load, *ends, solution.times))
        fastest = np.linalg.norm(rates, axis=1)
        expected = angles[:-1] + intervals[:, None] * (rates[1:] + rates[:-1]) / 2
        resolved = intervals * np.maximum(fastest[1:], fastest[:-1]) < np.pi
        jumps = resolved & (np.linalg.norm(angles[1:] - expected, axis=1) > np.pi)
        if not resolved.any():
            jumps[:] = np.linalg.norm((expected - angles[:-1]).sum(axis=0)) > 2 * np.pi
        if jumps.any():
            time = float(solution.times[1:][jumps][0])
            warn_or_raise(f"{load.label}: by t = {time:.6g} {consequence}", ValidityWarning, run.validity)


def _consequence(load: ForceElement) -> str:
    """What a passed half revolution means, and the remedy; empty for loads without such a limit."""
    match load:
        case TorsionSpringDamper() if load.stiffness:
            return f"its angle passes half a revolution, where its moment jumps. {_COUNTING}"
        case TabledTorque() if not load.is_periodic and np.ptp(np.asarray(load.torque.z), axis=0).any():
            return f"its angle passes half a revolution, where its row jumps. {_COUNTING}"
        case AngleServo() if load.stiffness:
            return (
                "the difference from its set-point passes half a revolution, where its moment changes sign. "
                "Give a slower law, or a larger limit or stiffness"
            )
        case Bushing() if any(np.asarray(each)[3:, 3:].any() for each in (load.stiffness, load.damping)):
            return (
                "its rotation passes half a revolution, where its moment jumps. For a bearing that turns "
                "give a Revolute joint or a JournalBearing"
            )
    return ""


def _angles(load: ForceElement, first: Pose, second: Pose, times: np.ndarray) -> tuple[jax.Array, jax.Array]:
    """Angles (t, k) that the element limits to half a revolution, and their rates."""
    if isinstance(load, Bushing):
        return _turns(first, second)
    motion = axial_motions(first, second)
    angle, rate = motion.angle[:, None], motion.rate[:, None]
    if isinstance(load, AngleServo):
        target = jax.vmap(load.law)(jnp.asarray(times))
        return wrapped(target[:, :1] - angle), target[:, 1:] - rate
    return angle, rate


@jax.jit
@jax.vmap
def _turns(first: Pose, second: Pose) -> tuple[jax.Array, jax.Array]:
    spin = first.axes.T @ (second.angular_velocity - first.angular_velocity)
    return rotation_log(first.axes.T @ second.axes), spin
