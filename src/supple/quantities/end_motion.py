"""Motion of the ends of joints and force elements over a run, as in their equations, and of the joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray
from supple.equations.build_model import initial_points
from supple.errors import ModelError, did_you_mean
from supple.integrate import Solution
from supple.machine import GROUND, At, ForceElement, Joint, System
from supple.machine.forces.relative_motion import axial_motion
from supple.machine.pose import Pose
from supple.quantities.place import body_named
from supple.quantities.reading import Channel, QuantityKind

__all__ = ["JointMotionSensor"]


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


axial_motions = jax.jit(jax.vmap(axial_motion))
"""`axial_motion` at many times."""


@dataclass(frozen=True)
class OfJoint:
    """A sensor of a joint, given by its name."""

    name: str
    joint: str

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class JointMotionSensor(OfJoint):
    """Angle, its rate, slide and its speed, (t, 4), of the second end of a joint relative to the first.

        tan(angle) = (y_1 . x_2 - x_1 . y_2) / (x_1 . x_2 + y_1 . y_2),    slide = z_1 . (r_2 - r_1)

    z is the axis of the joint. Angle and slide are zero in the undeformed assembled machine. Revolutions are
    counted by the integral of the rate from one output time to the next (trapezoidal rule). Its error must be
    less than half a revolution.

    joint : name of the joint
    """

    def channels(self, system: System) -> Sequence[Channel]:
        """angle, rate, slide, speed."""
        joint = joint_named(system, self.joint, self.name)
        check_ends(system, self.name, joint)
        axis = f"z of {joint.name}"
        return (
            Channel("angle", QuantityKind.ANGLE, axis),
            Channel("rate", QuantityKind.ANGULAR_VELOCITY, axis),
            Channel("slide", QuantityKind.LENGTH, axis),
            Channel("speed", QuantityKind.VELOCITY, axis),
        )

    def values(self, system: System, solution: Solution) -> FloatArray:
        """(t, 4)."""
        joint = joint_named(system, self.joint, self.name)
        ends = both_ends(system, solution, joint, self.name)
        angle, rate, slide, speed = (np.asarray(part) for part in axial_motions(*ends))
        return np.column_stack([_counted(np.asarray(solution.times), angle, rate), rate, slide, speed])


def _counted(times: FloatArray, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Angles with whole revolutions, counted from the rates."""
    if len(times) == 1:
        return angle
    expected = np.diff(times) * (rate[1:] + rate[:-1]) / 2
    change = np.diff(angle)
    change += 2 * np.pi * np.round((expected - change) / (2 * np.pi))
    return np.concatenate([angle[:1], angle[0] + np.cumsum(change)])
