"""Springs and dampers defined by tables of force over position and velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from supple.machine.forces.characteristic import Surface, surface_at
from supple.machine.forces.force_element import AnchoredElement, AxialElement
from supple.machine.forces.relative_motion import (
    axial_motion,
    force_pair,
    line_motion,
    moment_pair,
    tension_pair,
    wrapped,
)
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["TabledForce", "TabledTension", "TabledTorque"]

_ONE_REVOLUTION = 1e-2
"""rad, largest rounding of the angles of a table of one revolution."""


@dataclass(frozen=True, kw_only=True)
class TabledTorque(AxialElement):
    """Torque on the second end about an axis of the first, a table over angle (rows) and rate (columns).

    The angle is in (-pi, pi]; rows outside this range have no effect. A table whose rows span one
    revolution, such as 0 to 2 pi, is periodic: the angle is counted from the first row to the last.
    """

    torque: Surface

    @property
    def is_periodic(self) -> bool:
        """Whether the rows span one revolution, up to rounding of the angles."""
        return abs(self.torque.x[-1] - self.torque.x[0] - 2 * np.pi) < _ONE_REVOLUTION

    @property
    def parameters(self) -> tuple[ArrayLike, ...]:
        """Arrays of the table, and the middle of the angle's range."""
        middle = (self.torque.x[0] + self.torque.x[-1]) / 2 if self.is_periodic else 0.0
        return (*self.torque.parameters, middle)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite moments about the first end's axis."""
        motion = axial_motion(first, second)
        *table, middle = parameters
        angle = middle + wrapped(motion.angle - middle)
        return moment_pair(first, surface_at(angle, motion.rate, table))


@dataclass(frozen=True, kw_only=True)
class TabledForce(AxialElement):
    """Force on the second end along an axis of the first, a table over slide (rows) and speed (columns)."""

    force: Surface

    @property
    def parameters(self) -> tuple[ArrayLike, ...]:
        """Arrays of the table."""
        return self.force.parameters

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces along the first end's axis."""
        motion = axial_motion(first, second)
        force = surface_at(motion.slide, motion.speed, parameters) * first.axes[:, 2]
        return force_pair(first, second, force, jnp.zeros(3))


@dataclass(frozen=True, kw_only=True)
class TabledTension(AnchoredElement):
    """Tension along the line between two points, a table over their distance (rows) and its rate (columns).

    A positive tension pulls the ends together. A shock absorber pulls in rebound, at positive rates, and
    pushes in bump. The two ends must not coincide.
    """

    tension: Surface

    acts_along_line: ClassVar[bool] = True

    @property
    def parameters(self) -> tuple[ArrayLike, ...]:
        """Arrays of the table."""
        return self.tension.parameters

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces along the line."""
        motion = line_motion(first, second)
        return tension_pair(motion, surface_at(motion.length, motion.rate, parameters))
