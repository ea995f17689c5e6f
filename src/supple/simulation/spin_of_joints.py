"""Whether the joints of a machine permit a steady rotation."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from supple.body import place_in_frame
from supple.equations.build_model import initial_points, system_length
from supple.equations.steady_motion import SteadyRotation
from supple.errors import ModelError, SuppleWarning
from supple.machine import GROUND, At, Joint, System
from supple.machine.pose import Pose

ANGLE = 0.7
"""Rotation after which the joints are evaluated, rad; unlikely as an angle of symmetry."""
OPEN = 0.05
"""Residual of a joint, relative to the size of the machine or in rad, above which it prevents the rotation; a
supporting structure may bend by less."""


def check_joints_permit(system: System, turning: SteadyRotation, time: float) -> None:
    """Raise ModelError for a joint between rotating and fixed bodies, or the ground, that prevents the spin.

    A driven joint may rotate at any rate. Where all bodies rotate, joints to the ground count as joints to a
    rotating platform; a SuppleWarning if another joint is a bearing about the axis, so that the bodies on the
    ground probably stand still. Joints of intrinsic bodies are checked with the supports of their roots.
    """
    rates = np.linalg.norm(turning.angular_velocities, axis=1)
    if not rates.any():
        return
    spins = turning.by_body([placed.body.name for placed in system.bodies])
    others = {
        each.body.name for each in system.bodies if each.body.kind == "intrinsic" or not each.body.has_frame
    }
    joints = [each for each in system.joints if not {each.first.body, each.second.body} & others]
    if rates.all():
        _warn_of_bearings(system, joints, turning.point, turning.angular_velocities[0], time)
        return
    for joint in joints:
        first, second = (spins[end.body] for end in (joint.first, joint.second))
        if np.array_equal(first, second):
            continue
        left = _residual(system, joint, (first, second), turning.point, time)
        if left.max() > OPEN:
            still = joint.first if not first.any() else joint.second
            raise ModelError(
                f"joint '{joint.name}' prevents the spin: it connects '{joint.first}' and '{joint.second}', "
                f"of which '{still}' does not rotate, and fixes {joint.rows[int(np.argmax(left))]}. Give a "
                "joint about the axis of the spin (Revolute, PrescribedRotation), name the rotating bodies, "
                "Spin(bodies=..), or give a point on the axis, Spin(point=..)"
            )


def _warn_of_bearings(
    system: System, joints: Sequence[Joint], point: np.ndarray, spin: np.ndarray, time: float
) -> None:
    """Issue SuppleWarning if a joint to the ground prevents the spin and one between bodies permits it."""

    def permits(joint: Joint) -> bool:
        return bool(_residual(system, joint, (spin, 0 * spin), point, time).max() <= OPEN)

    on_ground = [each for each in joints if GROUND in (each.first, each.second) and not permits(each)]
    between = [each for each in joints if GROUND not in (each.first, each.second)]
    bearing = next((each for each in between if permits(each)), None) if on_ground else None
    if bearing is not None:
        warnings.warn(
            f"all bodies rotate, and joint '{on_ground[0].name}' to the ground with them, as on a rotating "
            f"platform; but joint '{bearing.name}' is a bearing about the axis of the spin. If only the "
            "bodies beyond it rotate, name them: bodies = [..] in [spin], Spin(bodies=..)",
            SuppleWarning,
            stacklevel=2,
        )


def _residual(
    system: System, joint: Joint, spins: tuple[np.ndarray, np.ndarray], point: np.ndarray, time: float
) -> np.ndarray:
    """Residual of a joint, relative to the size of the machine or in rad, with its ends rotated by `ANGLE`.

    spins : angular velocities of the first and the second end; the faster one rotates by ANGLE
    """
    length = system_length(system)
    per_rate = ANGLE / max(float(np.linalg.norm(each)) for each in spins)
    drives: list[Any] = [None]
    if joint.law is not None:
        angle = per_rate * float(np.linalg.norm(spins[0] - spins[1]))
        drives = [float(joint.law(time)) + sense * angle for sense in (-1, 0, 1)]
    ends = [
        _turned(_pose(system, joint, end), per_rate * w, point)
        for end, w in zip((joint.first, joint.second), spins, strict=True)
    ]
    lengths = np.array([length if row.startswith("position") else 1.0 for row in joint.rows])
    open_by = (np.abs(np.asarray(type(joint).constraint(*ends, drive))) / lengths for drive in drives)
    return min(open_by, key=max)


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
