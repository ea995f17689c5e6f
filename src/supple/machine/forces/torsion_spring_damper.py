"""Spring and damper about the axis of a hinge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax

from supple.arguments import NotNegative
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, moment_pair
from supple.machine.laws.time_law import OverTime
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["TorsionSpringDamper"]


@dataclass(frozen=True, kw_only=True)
class TorsionSpringDamper(AxialElement):
    """Torsion spring and damper with the moment `- k (phi - phi_0(t)) - c dphi/dt` on the second end.

    phi, in (-pi, pi], is the angle of the second end relative to the first about an axis of the first end. It
    is zero at assembly. The first end has the opposite moment.

    stiffness : k, moment per rad
    damping : c, moment per angular velocity
    """

    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    rest_angle: OverTime = 0.0
    """phi_0, angle phi without moment, rad: a number or a law of time."""

    law_field: ClassVar[str] = "rest_angle"
    parameter_fields: ClassVar[tuple[str, ...]] = ("stiffness", "damping")

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite moments about the first end's axis."""
        stiffness, damping = parameters
        motion = axial_motion(first, second)
        moment = stiffness * (motion.angle - value) + damping * motion.rate
        return moment_pair(first, -moment)

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:
        """`k (phi - phi_0)^2 / 2`."""
        return parameters[0] * (axial_motion(first, second).angle - value) ** 2 / 2
