"""Spring and damper about the axis of a hinge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from supple.arguments import NotNegative
from supple.machine.forces.force_element import ForceElement
from supple.machine.forces.relative_motion import axial_motion, moment_pair
from supple.machine.joints.joint import axes_along
from supple.machine.laws.time_law import TimeLaw, as_time_law
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["TorsionSpringDamper"]


@dataclass(frozen=True, kw_only=True)
class TorsionSpringDamper(ForceElement):
    """Torsion spring and damper with the moment `- k (phi - phi_0(t)) - c dphi/dt` on the second end.

    phi, in (-pi, pi], is the angle of the second end relative to the first about an axis of the first end. It
    is zero at assembly. The first end has the opposite moment.

    axis : (3,) direction of the axis at assembly, in global components
    stiffness : k, moment per rad
    damping : c, moment per angular velocity
    """

    axis: tuple[float, float, float]
    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    rest_angle: Any = 0.0
    """phi_0, angle phi without moment, rad: a number or a law of time."""

    def __post_init__(self) -> None:
        super().__post_init__()
        axes_along(self.axis)

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis."""
        return axes_along(self.axis)

    @property
    def law(self) -> TimeLaw:
        """The rest angle over time."""
        return as_time_law(self.rest_angle)

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(k, c)`."""
        return (self.stiffness, self.damping)

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
