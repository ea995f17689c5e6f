"""Spring and damper along the line between two points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arguments import NotNegative
from supple.machine.forces.force_element import AnchoredElement
from supple.machine.forces.relative_motion import line_motion, tension_pair
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["SpringDamper"]


@dataclass(frozen=True, kw_only=True)
class SpringDamper(AnchoredElement):
    """Spring and damper with the tension `k (l - l_0) + c dl/dt` along the line between its ends.

    l is the distance of the two ends, which must not coincide.

    stiffness : k, force per length
    damping : c, force per velocity
    rest_length : l_0; None: the distance of the ends at assembly
    """

    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    rest_length: NotNegative | None = 0.0

    acts_along_line: ClassVar[bool] = True
    parameter_fields: ClassVar[tuple[str, ...]] = ("stiffness", "damping", "rest_length")

    def assembled(self, first: np.ndarray, second: np.ndarray) -> SpringDamper:
        """The spring with a rest length: if `rest_length` is None, the distance of its ends at assembly."""
        if self.rest_length is not None:
            return self
        return replace(self, rest_length=float(np.linalg.norm(second - first)))

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Equal and opposite forces along the line."""
        stiffness, damping, rest_length = parameters
        motion = line_motion(first, second)
        return tension_pair(motion, stiffness * (motion.length - rest_length) + damping * motion.rate)

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """`k (l - l_0)^2 / 2`."""
        stiffness, _, rest_length = parameters
        between = second.point - first.point
        return stiffness * (jnp.sqrt(between @ between) - rest_length) ** 2 / 2
