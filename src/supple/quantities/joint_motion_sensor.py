"""How far a joint has turned and slid about its axis, and how fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.errors import ModelError, did_you_mean
from supple.integrate import Solution
from supple.machine import Joint, System
from supple.quantities.end_motion import both_ends, check_ends
from supple.quantities.reading import Channel, Quantity

__all__ = ["JointMotionSensor"]

Array = NDArray[np.float64]


def joint_named(system: System, name: str, sensor: str) -> Joint:
    """A joint of the machine; ModelError names the nearest where there is none."""
    for joint in system.joints:
        if joint.name == name:
            return joint
    known = [joint.name for joint in system.joints]
    raise ModelError(f"sensor '{sensor}': there is no joint '{name}'{did_you_mean(name, known)}")


@dataclass(frozen=True)
class JointMotionSensor:
    """Angle and slide of the second end of a joint against the first, about and along the joint's z axis.

        tan(angle) = (y_1 . x_2 - x_1 . y_2) / (x_1 . x_2 + y_1 . y_2),    slide = z_1 . (r_2 - r_1)

    Both are zero where the joint is undeformed when the machine is put together. The angle goes on beyond
    pi: from one output time to the next it is taken to change by less than half a turn more or less than the
    mean of its rates says.

    joint : its name
    """

    name: str
    joint: str

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """angle, rate, slide, speed."""
        joint = joint_named(system, self.joint, self.name)
        check_ends(system, self.name, joint)
        axis = f"z of {joint.name}"
        return (
            Channel("angle", Quantity.ANGLE, axis),
            Channel("rate", Quantity.ANGULAR_VELOCITY, axis),
            Channel("slide", Quantity.LENGTH, axis),
            Channel("speed", Quantity.VELOCITY, axis),
        )

    def values(self, system: System, solution: Solution) -> Array:
        """(t, 4)."""
        joint = joint_named(system, self.joint, self.name)
        first, second = both_ends(system, solution, joint, self.name)
        one, other = np.asarray(first.axes), np.asarray(second.axes)
        turn = np.einsum("tij,tik->tjk", one, other)
        axis = one[..., 2]
        apart = np.asarray(second.point) - np.asarray(first.point)
        turning = np.asarray(second.angular_velocity) - np.asarray(first.angular_velocity)
        # Seen in axes that turn with the first end.
        moving = np.asarray(second.velocity) - np.asarray(first.velocity)
        moving = moving - np.cross(np.asarray(first.angular_velocity), apart)
        angle = np.arctan2(turn[:, 1, 0] - turn[:, 0, 1], turn[:, 0, 0] + turn[:, 1, 1])
        rate = (axis * turning).sum(axis=1)
        return np.column_stack(
            [
                _counted(np.asarray(solution.times), angle, rate),
                rate,
                (axis * apart).sum(axis=1),
                (axis * moving).sum(axis=1),
            ]
        )


def _counted(times: Array, angle: Array, rate: Array) -> Array:
    """Angles with the whole turns that their rates say."""
    if len(times) == 1:
        return angle
    expected = np.diff(times) * (rate[1:] + rate[:-1]) / 2
    change = np.diff(angle)
    change += 2 * np.pi * np.round((expected - change) / (2 * np.pi))
    return np.concatenate([angle[:1], angle[0] + np.cumsum(change)])
