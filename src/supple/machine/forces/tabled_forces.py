"""Springs and dampers defined by tables of force over position and velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from supple.machine.forces.axial_element import AxialElement
from supple.machine.forces.characteristic import Surface, surface_at
from supple.machine.forces.relative_motion import axial_motion, force_pair, moment_pair
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["TabledForce", "TabledTorque"]


@dataclass(frozen=True, kw_only=True)
class TabledTorque(AxialElement):
    """Torque on the second end about an axis of the first, a table over angle (rows) and rate (columns).

    The angle is in (-pi, pi]: rows beyond are not reached.
    """

    torque: Surface

    @property
    def parameters(self) -> tuple[Any, ...]:
        """Arrays of the table."""
        return self.torque.parameters

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite moments about the first end's axis."""
        motion = axial_motion(first, second)
        return moment_pair(first, surface_at(motion.angle, motion.rate, parameters))


@dataclass(frozen=True, kw_only=True)
class TabledForce(AxialElement):
    """Force on the second end along an axis of the first, a table over slide (rows) and speed (columns)."""

    force: Surface

    @property
    def parameters(self) -> tuple[Any, ...]:
        """Arrays of the table."""
        return self.force.parameters

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces along the first end's axis."""
        motion = axial_motion(first, second)
        force = surface_at(motion.slide, motion.speed, parameters) * first.axes[:, 2]
        return force_pair(first, second, force, jnp.zeros(3))
