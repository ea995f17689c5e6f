"""Residuals of the constraint equations g = 0 of a system over a run, and the check of redundant ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np

from supple.body import RigidBody
from supple.equations.build_model import build_model, row_scales, seen_coordinates
from supple.equations.configuration import Configuration
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.errors import AccuracyError
from supple.integrate import FloatingMotion, Motion, Solution
from supple.machine import GROUND, At, Placed, System
from supple.programs.program_cache import CachedProgram

__all__ = ["joint_residuals"]

OPEN = 1e-4
"""Residual of an omitted equation, relative to the system's size or in rad, above which the equation counts
as violated; the residuals of redundant equations are far smaller."""


def _residuals_over_time(model: Model, times: jax.Array, configurations: Configuration) -> jax.Array:
    return jax.vmap(lambda time, at: constraints(model, time, at))(times, configurations)


_residuals = CachedProgram(_residuals_over_time)


def joint_residuals(system: System, solution: Solution) -> np.ndarray:
    """Residuals g (t, m) of all joints at the output times, in the unit of length or rad."""
    system, bodies = _with_stations(system, solution.bodies)
    motions = [bodies[placed.body.name] for placed in system.bodies]
    configurations = Configuration(
        origins=np.stack([motion.position for motion in motions], axis=1),
        rotations=np.stack([motion.rotation for motion in motions], axis=1),
        coordinates=np.concatenate(
            [
                seen_coordinates(placed.body, motion.coordinates)
                for placed, motion in zip(system.bodies, motions, strict=True)
            ],
            axis=1,
        ),
    )
    return np.asarray(_residuals(build_model(system), solution.times, configurations))


def check_redundant_joints(system: System, leg: Solution) -> None:
    """Raise AccuracyError for a joint that is violated because its equations were left out.

    Such an equation depends on others at the start of the run, but not at a later time.

    leg : a part of the run
    """
    n_equations = system.n_constraints
    kept = leg.engine_state.get("active")
    if kept is None or len(kept) == n_equations:
        return
    residuals = np.abs(joint_residuals(system, leg)) / row_scales(system)
    residuals[:, kept.astype(int)] = 0.0
    row, worst = np.unravel_index(np.argmax(residuals), residuals.shape)
    if residuals[row, worst] > OPEN:
        labels = [f"'{joint.name}' ({what})" for joint in system.joints for what in joint.rows]
        raise AccuracyError(
            f"{labels[worst]} was left out at the start as redundant, and is off by "
            f"{residuals[row, worst]:.3g} of the machine's size, or rad, at t = {leg.times[row]:.6g}: the "
            "machine has left the position in which its joints are redundant. Start beside that position"
        )


class _Pose(NamedTuple):
    """Pose of a station over time."""

    position: np.ndarray
    rotation: np.ndarray
    coordinates: np.ndarray


def _with_stations(
    system: System, bodies: Mapping[str, Motion]
) -> tuple[System, dict[str, FloatingMotion | _Pose]]:
    """The system without loads, and the motions of its bodies by name.

    Each joint end on a body without a floating frame is replaced by a rigid body with the motion of this end.
    """
    floating = {name: motion for name, motion in bodies.items() if isinstance(motion, FloatingMotion)}
    motions: dict[str, FloatingMotion | _Pose] = dict(floating)
    placed = [each for each in system.bodies if each.body.name in floating]

    def seen(end: At) -> At:
        label = f"{end.body}, {end.interface}"
        if end == GROUND or end.body in floating:
            return end
        if label not in motions:
            owner = system.bodies[system.body_index(end.body)]
            found = owner.body.interface_motion(bodies[end.body], end.interface)
            motions[label] = _Pose(found.position, found.rotation, np.zeros((len(found.position), 0)))
            point = RigidBody(label, 1.0, np.zeros(3), np.eye(3), {"station": np.zeros(3)})
            placed.append(Placed(point, system.initial_point(end), owner.assembly.rotation))
        return At(label, "station")

    joints = [replace(each, first=seen(each.first), second=seen(each.second)) for each in system.joints]
    return System(placed, joints), motions
