"""Screw, and rack and pinion: a slide and an angle coupled by an elastic mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive
from supple.errors import ModelError
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, force_pair, wrapped
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["RackAndPinion", "Screw"]


@dataclass(frozen=True, kw_only=True)
class Screw(AxialElement):
    """The second end advances along the axis by the pitch in every revolution about the axis.

        s = x - x_0 - pitch phi / (2 pi),    force -(k s + c ds/dt),    moment pitch/(2 pi) (k s + c ds/dt)

    with slide x and angle phi of the second end along and about the first end's axis. `s` is wrapped to plus
    or minus half the pitch, so the number of revolutions is not limited. A cylindrical joint must keep the
    second end on the axis.

    pitch : advance in one revolution, a length; positive for a right-hand thread
    stiffness : k along the axis, force per length
    damping : c along the axis, force per velocity
    Raises ModelError for a pitch that is zero or not finite.
    """

    pitch: float
    stiffness: Positive
    damping: NotNegative = 0.0
    offset: float | None = None
    """x_0; default the slide at assembly"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (np.isfinite(self.pitch) and self.pitch):
            raise ModelError(f"{self.label}: the pitch must be finite and not zero, got {self.pitch}")

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(pitch / (2 pi), k, c, x_0)`."""
        return (self.pitch / (2 * np.pi), self.stiffness, self.damping, self.offset or 0.0)

    def assembled(self, first: np.ndarray, second: np.ndarray) -> Screw:
        """The screw with the slide at assembly as `x_0`, if `offset` is None."""
        slide = float(self.initial_axes[:, 2] @ (second - first))
        return self if self.offset is not None else replace(self, offset=slide)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Force along and moment about the axis."""
        advance, stiffness, damping, offset = parameters
        motion = axial_motion(first, second)
        slip = advance * wrapped((motion.slide - offset) / advance - motion.angle)
        effort = stiffness * slip + damping * (motion.speed - advance * motion.rate)
        axis = first.axes[:, 2]
        return force_pair(first, second, -effort * axis, advance * effort * axis)

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """`k s^2 / 2`."""
        advance, stiffness, _, offset = parameters
        motion = axial_motion(first, second)
        slip = advance * wrapped((motion.slide - offset) / advance - motion.angle)
        return stiffness * slip**2 / 2


@dataclass(frozen=True, kw_only=True)
class RackAndPinion(AxialElement):
    """The second end, a pinion, rolls along the first, a rack.

        s = x - x_0 + radius phi,    force -(k s + c ds/dt) on the pinion, along the rack, at the pitch point

    with the displacement x of the pinion's centre along the rack and the angle phi of the pinion about the
    axis, both relative to the rack. `s` is wrapped to the path of half a revolution of the pinion, so the
    number of revolutions is not limited.

    axis : axis of the pinion at the start, global axes; fixed to the rack
    direction : direction of the rack at the start, global axes; made perpendicular to the axis; fixed to the
        rack
    radius : radius of the pitch circle, a length; contact is on the side of `- axis x direction`, or on the
        opposite side for a negative radius
    stiffness : k of the tooth mesh along the rack, force per length
    damping : c of the tooth mesh along the rack, force per velocity
    Raises ModelError for a radius that is zero or not finite, or a direction parallel to the axis.
    """

    direction: tuple[float, float, float]
    radius: float
    stiffness: Positive
    damping: NotNegative = 0.0
    offset: float | None = None
    """x_0; default the displacement at assembly"""

    hint_field: ClassVar[str] = "direction"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (np.isfinite(self.radius) and self.radius):
            raise ModelError(f"{self.label}: the radius must be finite and not zero, got {self.radius}")

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(radius, k, c, x_0)`."""
        return (self.radius, self.stiffness, self.damping, self.offset or 0.0)

    def assembled(self, first: np.ndarray, second: np.ndarray) -> RackAndPinion:
        """The element with the displacement x at assembly as `x_0`, if `offset` is None."""
        way = float(self.initial_axes[:, 0] @ (second - first))
        return self if self.offset is not None else replace(self, offset=way)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Force along the rack, at the pitch point."""
        radius, stiffness, damping, _ = parameters
        along, across, _ = first.axes.T
        between = second.point - first.point
        moving = second.velocity - first.velocity - jnp.cross(first.angular_velocity, between)
        rate = along @ moving + radius * axial_motion(first, second).rate
        force = -(stiffness * _rolled(first, second, parameters) + damping * rate) * along
        return force_pair(first, second, force, jnp.cross(-radius * across, force))

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """`k s^2 / 2`."""
        return parameters[1] * _rolled(first, second, parameters) ** 2 / 2


def _rolled(first: Pose, second: Pose, parameters: Parameters) -> jax.Array:
    """Deflection `s` of the mesh of a pinion and a rack."""
    radius, _, _, offset = parameters
    way = first.axes[:, 0] @ (second.point - first.point) - offset
    return radius * wrapped(way / radius + axial_motion(first, second).angle)
