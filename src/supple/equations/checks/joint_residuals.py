"""Residuals of the constraint equations g = 0 of a system over a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np

from supple.body import RigidBody
from supple.equations.build_model import build_model, seen_coordinates
from supple.equations.configuration import Configuration
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.integrate import FloatingMotion, Motion, Solution
from supple.machine import GROUND, At, Placed, System
from supple.programs.program_cache import CachedProgram

__all__ = ["joint_residuals"]


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
