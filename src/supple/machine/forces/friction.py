"""Friction, regularised at zero velocity: Coulomb's law, and elements for hinges and slides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative, Positive, check_fields
from supple.errors import ModelError
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, force_pair, moment_pair
from supple.machine.laws.constant import Constant
from supple.machine.laws.time_law import OverTime
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["Coulomb", "PrismaticFriction", "RevoluteFriction"]


@dataclass(frozen=True, kw_only=True)
class Coulomb:
    """Friction `mu N v / sqrt(|v|^2 + w^2)` against the sliding velocity v of a contact with normal force N.

    For |v| below the width w the friction acts as a damper: contacts creep instead of sticking. Under a
    tangential force `T < mu N` the creep velocity is `v = w s / sqrt(1 - s^2)`, `s = T/(mu N)`.

    coefficient : mu, not negative
    width : w, a velocity, positive
    Raises ModelError for any other coefficient or width.
    """

    coefficient: NotNegative
    width: Positive

    def __post_init__(self) -> None:
        check_fields(self)
        if not (np.isfinite(self.coefficient) and self.coefficient >= 0):
            raise ModelError(f"a friction coefficient must be finite, not negative, got {self.coefficient}")
        if not (np.isfinite(self.width) and self.width > 0):
            raise ModelError(
                f"the width of a friction law must be a positive velocity, got {self.width}: below it "
                "contacts creep; a thousandth of the sliding velocities is usual"
            )


def regularized_direction(velocity: jax.Array, width: jax.Array) -> jax.Array:
    """`v / sqrt(|v|^2 + w^2)` for a velocity v, a number or a vector (3,), and a width w."""
    return velocity / jnp.sqrt(jnp.sum(velocity**2) + width**2)


class _Friction(AxialElement):
    """Friction of given size along an axis, with the field `width`."""

    parameter_fields: ClassVar[tuple[str, ...]] = ("width",)

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.law, Constant) and np.any(np.asarray(self.law.value) < 0):
            raise ModelError(
                f"{self.label}: the {self.law_field} must not be negative, got {self.law.value}: friction "
                "would drive the motion. Give the magnitude; friction acts against either direction"
            )


@dataclass(frozen=True, kw_only=True)
class RevoluteFriction(_Friction):
    """Moment `M v / sqrt(v^2 + w^2)` against the rate v of the angle about the axis of a hinge.

    M does not depend on the joint force. For a preload N at a radius r, `M = mu N r`. For friction that
    depends on the joint force use `HingeFriction`, or contacts.

    moment : M, a number that is not negative, or a law of time
    width : w, rad per time; for |v| below w the friction acts as a damper
    """

    moment: OverTime
    width: Positive

    law_field: ClassVar[str] = "moment"

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite moments about the first end's axis."""
        rate = axial_motion(first, second).rate
        return moment_pair(first, -value * regularized_direction(rate, parameters[0]))


@dataclass(frozen=True, kw_only=True)
class PrismaticFriction(_Friction):
    """Force `F v / sqrt(v^2 + w^2)` against the sliding speed v along an axis.

    F does not depend on the joint force. For a preload N, `F = mu N`. For friction that depends on the joint
    force use `SlideFriction`, or contacts.

    force : F, a number that is not negative, or a law of time
    width : w, a velocity; for |v| below w the friction acts as a damper
    """

    force: OverTime
    width: Positive

    law_field: ClassVar[str] = "force"

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Equal and opposite forces along the first end's axis."""
        speed = axial_motion(first, second).speed
        force = -value * regularized_direction(speed, parameters[0]) * first.axes[:, 2]
        return force_pair(first, second, force, jnp.zeros(3))
