"""The ends of joints and forces over a whole run, as their equations see them."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.integrate import FloatingMotion, Solution
from supple.intrinsic import IntrinsicBody
from supple.machine import GROUND, At, Joint, System
from supple.machine.forces import ForceElement
from supple.machine.pose import Pose
from supple.multibody.equations.build_model import initial_points
from supple.multibody.equations.marker import Marker, pose

__all__ = ["body_named", "both_ends", "check_ends", "check_floating", "end_poses", "floating_motion"]

_NO_FRAME = (
    "sensor '{}': body '{}' has no floating frame, in which velocities and turns are known; read its "
    "positions"
)


def body_named(system: System, body: str, sensor: str) -> Any:
    """The form of a body; ModelError names the nearest where there is none."""
    return system.bodies[system.body_index(body, f"sensor '{sensor}'")].body


def floating_motion(solution: Solution, body: str, sensor: str) -> FloatingMotion:
    """Motion of a body in a floating frame; ModelError for another."""
    motion = solution.bodies[body]
    if not isinstance(motion, FloatingMotion):
        raise ModelError(_NO_FRAME.format(sensor, body))
    return motion


def check_floating(system: System, sensor: str, *bodies: str) -> None:
    """ModelError for a body that is not there, or will have no motion in a floating frame."""
    for body in bodies:
        if isinstance(body_named(system, body, sensor), IntrinsicBody):
            raise ModelError(_NO_FRAME.format(sensor, body))


def check_ends(system: System, sensor: str, element: Joint | ForceElement) -> None:
    """As `check_floating`, of the bodies that a joint or force is on."""
    check_floating(system, sensor, *(end.body for end in (element.first, element.second) if end != GROUND))


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
    placed = system.bodies[system.body_index(end.body, f"sensor '{sensor}'")]
    interface = placed.body.interface(end.interface)
    motion = floating_motion(solution, end.body, sensor)
    moved, rates = (q @ interface.motion.T for q in (motion.coordinates, motion.coordinate_rates))
    fixed: dict[str, Any] = {
        "cubic_turn": interface.cubic_turn,
        "offset": interface.position,
        "axes": placed.assembly.rotation.T @ axes,
    }
    moving: dict[str, Any] = {
        "origin": motion.position,
        "rotation": motion.rotation,
        "displacement": moved[:, :3],
        "rotation_vector": moved[:, 3:],
        "velocity": motion.velocity,
        "angular_velocity": motion.angular_velocity,
        "displacement_rate": rates[:, :3],
        "rotation_vector_rate": rates[:, 3:],
    }
    for name, value in fixed.items():
        moving[name] = np.broadcast_to(value, (n_times, *np.shape(value)))
    return _poses(Marker(**moving))


@jax.jit
def _poses(markers: Any) -> Pose:
    return jax.vmap(pose)(markers)
