"""Gear: elastic mesh of two wheels on parallel axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive
from supple.errors import ModelError
from supple.machine.forces.force_element import AnchoredElement, AxialElement
from supple.machine.forces.relative_motion import wrapped
from supple.machine.pose import Parameters, Pose, Wrench, Wrenches

__all__ = ["Gear"]

_TEETH = 2


@dataclass(frozen=True, kw_only=True)
class Gear(AnchoredElement, AxialElement):
    """Spur gear: a force `k s + c ds/dt` across the line of centres, at the pitch point.

        s = l (z_1 phi_1 + z_2 phi_2) / (z_1 + z_2),      l = |r_2 - r_1|

    with the angles phi_1 and phi_2 of both wheels about the axis, relative to the line of centres. The line
    may rotate about the axis, as for planet gears; no carrier body is needed. `s` is wrapped to plus or minus
    half a tooth pitch, so the number of revolutions is not limited. Beyond half a tooth pitch the wheels skip
    a tooth.

    The joints must keep the axes of both wheels parallel.

    teeth : numbers of teeth of both wheels, z_1 and z_2; negative for a ring with inner teeth
    stiffness : k of the tooth mesh, force per length
    damping : c of the tooth mesh, force per velocity
    anchor : global position of the centre of a wheel that is fixed to the ground
    Raises ModelError for numbers of teeth that are not whole, are zero, or have the sum zero.
    """

    teeth: tuple[int, int]
    stiffness: Positive
    damping: NotNegative = 0.0
    line: tuple[float, float, float] | None = None
    """Vector from the first centre to the second at assembly; default from the positions of the ends"""

    hint_field: ClassVar[str] = "line"
    acts_along_line: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        whole = len(self.teeth) == _TEETH and all(z == int(z) and z for z in self.teeth)
        if not whole or sum(self.teeth) == 0:
            raise ModelError(
                f"{self.label}: teeth must be two whole numbers, negative for inner teeth, not opposite and "
                f"equal; got {self.teeth}"
            )

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(z_1, z_2, k, c)`."""
        return (*map(float, self.teeth), self.stiffness, self.damping)

    def assembled(self, first: np.ndarray, second: np.ndarray) -> Gear:
        """The gear with its line of centres at assembly, if none is given."""
        return self if self.line is not None else replace(self, line=tuple((second - first).tolist()))

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces at the pitch point."""
        teeth_1, teeth_2, stiffness, damping = parameters
        length, line, across, slip = _mesh(first, second, parameters)
        radius = length * teeth_1 / (teeth_1 + teeth_2)
        on_first = radius * line
        on_second = on_first - (second.point - first.point)
        moving = first.velocity + jnp.cross(first.angular_velocity, on_first)
        moving = moving - second.velocity - jnp.cross(second.angular_velocity, on_second)
        force = (stiffness * slip + damping * (across @ moving)) * across
        return (
            Wrench(-force, -jnp.cross(on_first, force)),
            Wrench(force, jnp.cross(on_second, force)),
        )

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """`k s^2 / 2`."""
        return parameters[2] * _mesh(first, second, parameters)[3] ** 2 / 2


def _mesh(first: Pose, second: Pose, parameters: Parameters) -> tuple[jax.Array, ...]:
    """Distance of the centres, unit vectors along and across the line of centres, and `s`."""
    teeth_1, teeth_2, _, _ = parameters
    axis = first.axes[:, 2]
    between = second.point - first.point
    between = between - (axis @ between) * axis
    length = jnp.sqrt(between @ between)
    line = between / length
    across = jnp.cross(axis, line)

    def angle(pose: Pose) -> jax.Array:
        x, y = pose.axes[:, 0], pose.axes[:, 1]
        return jnp.arctan2(x @ across - y @ line, x @ line + y @ across)

    phase = wrapped(teeth_1 * angle(first) + teeth_2 * angle(second))
    return length, line, across, length * phase / (teeth_1 + teeth_2)
