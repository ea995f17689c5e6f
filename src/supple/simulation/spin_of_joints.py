"""Whether the joints of a machine permit a steady rotation."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from supple.body import place_in_frame
from supple.equations.build_model import initial_points, system_length
from supple.equations.steady_motion import SteadyRotation
from supple.errors import ModelError
from supple.machine import GROUND, At, Joint, System
from supple.machine.pose import Pose

__all__ = ["check_joints_permit"]

ANGLE = 0.7
"""Rotation after which the joints are evaluated, rad; unlikely as an angle of symmetry."""
OPEN = 0.05
"""Residual of a joint, relative to the size of the machine or in rad, above which it prevents the rotation; a
supporting structure may bend by less."""


def check_joints_permit(system: System, turning: SteadyRotation, time: float) -> None:
    """Raise ModelError for a joint between rotating and fixed bodies, or the ground, that prevents the spin.

    A driven joint may rotate at any rate. Where all bodies rotate, joints to the ground count as joints to a
    rotating platform. Joints of intrinsic bodies are checked with the supports of their roots.
    """
    rates = np.linalg.norm(turning.angular_velocities, axis=1)
    fastest = float(rates.max(initial=0.0))
    if rates.all() or not rates.any():
        return
    length = system_length(system)
    spins = turning.by_body([placed.body.name for placed in system.bodies])
    others = {
        each.body.name for each in system.bodies if each.body.kind == "intrinsic" or not each.body.has_frame
    }
    for joint in system.joints:
        first, second = (spins[end.body] for end in (joint.first, joint.second))
        if np.array_equal(first, second) or {joint.first.body, joint.second.body} & others:
            continue
        value = None if joint.law is None else float(joint.law(time))
        drives: list[Any] = [None] if value is None else [value + sense * ANGLE for sense in (-1, 0, 1)]
        ends = [
            _turned(_pose(system, joint, end), ANGLE / fastest * w, turning.point)
            for end, w in ((joint.first, first), (joint.second, second))
        ]
        lengths = np.array([length if row.startswith("position") else 1.0 for row in joint.rows])
        left = min(
            (np.abs(np.asarray(type(joint).constraint(*ends, drive))) / lengths for drive in drives), key=max
        )
        if left.max() > OPEN:
            still = joint.first if not first.any() else joint.second
            raise ModelError(
                f"joint '{joint.name}' prevents the spin: it connects '{joint.first}' and '{joint.second}', "
                f"of which '{still}' does not rotate, and fixes {joint.rows[int(np.argmax(left))]}. Give a "
                "joint about the axis of the spin (Revolute, PrescribedRotation), name the rotating bodies, "
                "Spin(bodies=..), or give a point on the axis, Spin(point=..)"
            )


def _pose(system: System, joint: Joint, end: At) -> Pose:
    """An end of a joint as placed."""
    none = jnp.zeros(3)
    if end == GROUND:
        first, second = initial_points(system, joint)
        return Pose(
            jnp.asarray(first if joint.first == GROUND else second),
            jnp.asarray(joint.initial_axes),
            none,
            none,
        )
    placed = system.placed(end.body)
    place, turn = place_in_frame(placed.body.interface(end.interface), placed.coordinates[None])
    axes = placed.rotation @ turn[0] @ placed.assembly.rotation.T @ joint.initial_axes
    return Pose(jnp.asarray(placed.position + placed.rotation @ place[0]), jnp.asarray(axes), none, none)


def _turned(pose: Pose, turn: np.ndarray, point: np.ndarray) -> Pose:
    rotation = Rotation.from_rotvec(turn).as_matrix()
    return pose._replace(point=point + rotation @ (pose.point - point), axes=rotation @ pose.axes)
