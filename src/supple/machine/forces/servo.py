"""Servos: a spring and damper, of limited force, between an angle or a slide and its law of time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative
from supple.errors import ModelError
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, force_pair, moment_pair, wrapped
from supple.machine.laws.time_law import OverTime, as_time_law, check_law_shape
from supple.machine.laws.with_rate import WithRate
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["AngleServo", "SlideServo"]


@dataclass(frozen=True, kw_only=True)
class Servo(AxialElement):
    """A force or moment towards the set-point in the field `law_field`, limited in magnitude."""

    stiffness: NotNegative
    damping: NotNegative = 0.0
    limit: float = np.inf

    value_shape: ClassVar[tuple[int, ...]] = (2,)
    parameter_fields: ClassVar[tuple[str, ...]] = ("stiffness", "damping", "limit")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_law_shape(self.label, self.law.of, ())
        if not self.limit > 0:
            raise ModelError(f"{self.label}: the limit must be positive, or infinite, got {self.limit}")

    @property
    def law(self) -> WithRate:
        """The set-point and its rate."""
        return WithRate(as_time_law(getattr(self, self.law_field)))

    def held(self, time: float) -> Self:
        """The servo with the set-point of this time as a constant."""
        return replace(self, **{self.law_field: float(self.law(time)[0])})


@dataclass(frozen=True, kw_only=True)
class AngleServo(Servo):
    """Moment `k (phi_0 - phi) + c (dphi_0/dt - dphi/dt)` about a hinge, limited in magnitude.

    The difference `phi_0 - phi` is wrapped to (-pi, pi]: the number of revolutions is not limited, but the
    magnitude of the difference must stay below pi. In statics and modes the set-point is held constant,
    `dphi_0/dt = 0`, except between a body that rotates with a `Spin` and one that does not.

    angle : phi_0(t), rad, a number or a law of time        limit : largest moment, default infinite
    stiffness : k, moment per rad
    damping : c, moment per angular velocity
    """

    angle: OverTime

    law_field: ClassVar[str] = "angle"
    blocked_by: ClassVar[tuple[str, ...]] = ("rotation", "tilt about")

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite moments about the first end's axis."""
        motion = axial_motion(first, second)
        return moment_pair(
            first, _effort(wrapped(value[0] - motion.angle), value[1] - motion.rate, parameters)
        )


@dataclass(frozen=True, kw_only=True)
class SlideServo(Servo):
    """Force `k (x_0 - x) + c (dx_0/dt - dx/dt)` along an axis of the first end, limited in magnitude.

    In statics and modes the set-point is held constant.

    slide : x_0(t), a number or a law of time, for `x = z_1 . (r_2 - r_1)`
    limit : largest force, default infinite
    stiffness : k, force per length
    damping : c, force per velocity
    """

    slide: OverTime

    law_field: ClassVar[str] = "slide"
    blocked_by: ClassVar[tuple[str, ...]] = ("position",)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite forces along the first end's axis."""
        motion = axial_motion(first, second)
        effort = _effort(value[0] - motion.slide, value[1] - motion.speed, parameters)
        return force_pair(first, second, effort * first.axes[:, 2], jnp.zeros(3))


def _effort(lag: jax.Array, lag_rate: jax.Array, parameters: Parameters) -> jax.Array:
    stiffness, damping, limit = parameters
    return jnp.clip(stiffness * lag + damping * lag_rate, -limit, limit)
