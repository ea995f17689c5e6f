"""Unbalance of a rotor as a force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.machine.forces.force_element import ForceElement
from supple.machine.pose import Parameters, Pose, Wrench, Wrenches

__all__ = ["Unbalance"]


@dataclass(frozen=True, kw_only=True)
class Unbalance(ForceElement):
    """Force `- omega x (omega x U)` of a small mass m at the offset `U/m` (3,) from an interface.

    Only the centrifugal force is included. The weight and inertia of the mass, and its force under angular
    acceleration, are neglected. For a larger mass use a rigid body.

    moment : U, mass times eccentricity, in global axes at the start; it rotates with the end
    """

    moment: tuple[float, float, float]

    acts_on_first_alone: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        vector = np.asarray(self.moment, dtype=float)
        if vector.shape != (3,) or not np.isfinite(vector).all():
            raise ModelError(f"{self.label}: the moment must be three finite numbers, got {self.moment}")
        object.__setattr__(self, "moment", tuple(vector.tolist()))

    @property
    def parameters(self) -> tuple[float, ...]:
        """`U`."""
        return self.moment

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Wrench on the first end."""
        arm, spin = first.axes @ jnp.stack(parameters), first.angular_velocity
        force = -jnp.cross(spin, jnp.cross(spin, arm))
        return Wrench(force, jnp.zeros(3)), Wrench(jnp.zeros(3), jnp.zeros(3))
