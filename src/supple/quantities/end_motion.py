"""The ends of joints and forces over a whole run, as their equations see them."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np

from supple.equations.build_model import initial_points
from supple.errors import ModelError, did_you_mean
from supple.integrate import Solution
from supple.machine import GROUND, At, Joint, System
from supple.machine.forces import ForceElement
from supple.machine.pose import Pose
from supple.quantities.place import body_named

__all__ = ["both_ends", "check_ends", "end_poses", "joint_named"]


def joint_named(system: System, name: str, sensor: str) -> Joint:
    """A joint of the machine; ModelError names the nearest where there is none."""
    for joint in system.joints:
        if joint.name == name:
            return joint
    known = [joint.name for joint in system.joints]
    raise ModelError(f"sensor '{sensor}': there is no joint '{name}'{did_you_mean(name, known)}")


def check_ends(system: System, sensor: str, element: Joint | ForceElement) -> None:
    """ModelError for a body or interface that is not there, of a joint or force."""
    for end in (element.first, element.second):
        if end != GROUND:
            body_named(system, end.body, sensor).interface(end.interface)


def both_ends(
    system: System, solution: Solution, element: Joint | ForceElement, sensor: str
) -> tuple[Pose, Pose]:
    """Poses (t, ...) of both ends of a joint or force."""
    axes = element.initial_axes
    ends = (element.first, element.second)
    first, second = (
        end_poses(system, solution, end, axes, at_rest, sensor)
        for end, at_rest in zip(ends, initial_points(system, element), strict=True)
    )
    return first, second


def end_poses(
    system: System, solution: Solution, end: At, axes: np.ndarray, ground_point: np.ndarray, sensor: str
) -> Pose:
    """Place and motion (t, ...) of one end.

    axes : (3, 3) of the joint or force when the machine was put together, global
    ground_point : (3,) of an end on the ground
    """
    n_times = len(solution.times)
    if end == GROUND:
        still = np.zeros((n_times, 3))
        return Pose(
            *(jnp.asarray(x) for x in (still + ground_point, np.tile(axes, (n_times, 1, 1)), still, still))
        )
    placed = system.placed(end.body, f"sensor '{sensor}'")
    moving = placed.body.interface_motion(solution.bodies[end.body], end.interface)
    turned = moving.rotation @ (placed.assembly.rotation.T @ axes)
    return Pose(
        *(jnp.asarray(x) for x in (moving.position, turned, moving.velocity, moving.angular_velocity))
    )
