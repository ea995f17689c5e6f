"""Rotation of a joint about its axis, displacement along the axis, and their rates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields
from supple.integrate import Solution
from supple.machine import System
from supple.machine.forces.relative_motion import axial_motion
from supple.quantities.end_motion import both_ends, check_ends, joint_named
from supple.quantities.reading import Channel, QuantityKind

__all__ = ["JointMotionSensor"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointMotionSensor:
    """Angle, its rate, slide and its speed, (t, 4), of the second end of a joint relative to the first.

        tan(angle) = (y_1 . x_2 - x_1 . y_2) / (x_1 . x_2 + y_1 . y_2),    slide = z_1 . (r_2 - r_1)

    z is the axis of the joint. Angle and slide are zero in the undeformed assembled machine. Revolutions are
    counted by the integral of the rate from one output time to the next (trapezoidal rule). Its error must be
    less than half a revolution.

    joint : name of the joint
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
            Channel("angle", QuantityKind.ANGLE, axis),
            Channel("rate", QuantityKind.ANGULAR_VELOCITY, axis),
            Channel("slide", QuantityKind.LENGTH, axis),
            Channel("speed", QuantityKind.VELOCITY, axis),
        )

    def values(self, system: System, solution: Solution) -> Array:
        """(t, 4)."""
        joint = joint_named(system, self.joint, self.name)
        ends = both_ends(system, solution, joint, self.name)
        angle, rate, slide, speed = (np.asarray(part) for part in _axial_motions(*ends))
        return np.column_stack([_counted(np.asarray(solution.times), angle, rate), rate, slide, speed])


_axial_motions = jax.jit(jax.vmap(axial_motion))


def _counted(times: Array, angle: Array, rate: Array) -> Array:
    """Angles with whole revolutions, counted from the rates."""
    if len(times) == 1:
        return angle
    expected = np.diff(times) * (rate[1:] + rate[:-1]) / 2
    change = np.diff(angle)
    change += 2 * np.pi * np.round((expected - change) / (2 * np.pi))
    return np.concatenate([angle[:1], angle[0] + np.cumsum(change)])
