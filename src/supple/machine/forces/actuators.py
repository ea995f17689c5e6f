"""Torque about an axis, and force along it, between two ends: motors and cylinders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp

from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import force_pair, moment_pair
from supple.machine.laws.time_law import OverTime
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["ForceBetween", "TorqueBetween"]


@dataclass(frozen=True, kw_only=True)
class TorqueBetween(AxialElement):
    """A torque on the second end about an axis of the first, and its opposite on the first."""

    torque: OverTime = 0.0
    """a number or a law of time; the output of a controller adds to it"""

    law_field: ClassVar[str] = "torque"

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """`M_2 = m(t) z_1 = - M_1`."""
        return moment_pair(first, value)


@dataclass(frozen=True, kw_only=True)
class ForceBetween(AxialElement):
    """A force on the second end along an axis of the first, and the balancing wrench on the first."""

    force: OverTime = 0.0
    """a number or a law of time; the output of a controller adds to it"""

    law_field: ClassVar[str] = "force"

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """`F_2 = f(t) z_1 = - F_1`, both on one line of action through the second point."""
        return force_pair(first, second, value * first.axes[:, 2], jnp.zeros(3))
