"""Motion of the ends of joints and force elements over a run, as defined in their equations."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from supple.equations.build_model import initial_points
from supple.errors import ModelError, did_you_mean
from supple.integrate import Solution
from supple.machine import GROUND, At, ForceElement, Joint, System
from supple.machine.pose import Pose
from supple.quantities.place import body_named

__all__ = ["both_ends", "check_ends", "joint_named"]


def joint_named(system: System, name: str, sensor: str) -> Joint:
    """A joint of the machine; ModelError, with the most similar name, if there is none."""
    for joint in system.joints:
        if joint.name == name:
            return joint
    known = [joint.name for joint in system.joints]
    raise ModelError(f"sensor '{sensor}': there is no joint '{name}'{did_you_mean(name, known)}")


def check_ends(system: System, sensor: str, element: Joint | ForceElement) -> None:
    """ModelError if a joint or force element refers to a body or interface that does not exist."""
    for end in (element.first, element.second):
        if end != GROUND:
            body_named(system, end.body, sensor).interface(end.interface)


def both_ends(
    system: System, solution: Solution, element: Joint | ForceElement, sensor: str
) -> tuple[Pose, Pose]:
    """Pose and velocities (t, ...) of both ends of a joint or force element, with the axes of each end."""

    def poses(end: At, ground_point: np.ndarray) -> Pose:
        axes, n_times = element.initial_axes, len(solution.times)
        if end == GROUND:
            still = np.zeros((n_times, 3))
            parts = still + ground_point, np.tile(axes, (n_times, 1, 1)), still, still
        else:
            placed = system.placed(end.body, f"sensor '{sensor}'")
            moving = placed.body.interface_motion(solution.bodies[end.body], end.interface)
            turned = moving.rotation @ (placed.assembly.rotation.T @ axes)
            parts = moving.position, turned, moving.velocity, moving.angular_velocity
        return Pose(*(jnp.asarray(part) for part in parts))

    at_rest = initial_points(system, element)
    return poses(element.first, at_rest[0]), poses(element.second, at_rest[1])
