"""Spring and damper along the line between two points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np

from supple.machine.forces.force_element import ForceElement, check_anchor, check_not_negative
from supple.machine.pose import Pose, Wrench

__all__ = ["SpringDamper"]


@dataclass(frozen=True, kw_only=True)
class SpringDamper(ForceElement):
    """Tension `k (l - l_0) + c dl/dt` along the line between the points; they must stay apart."""

    stiffness: float = 0.0
    damping: float = 0.0
    rest_length: float = 0.0
    anchor: tuple[float, float, float] | None = None
    """Global point of the end that is on the ground, where one is."""

    acts_along_line: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_not_negative(self, stiffness=self.stiffness, damping=self.damping, rest_length=self.rest_length)
        check_anchor(self, self.anchor)

    @property
    def ground_point(self) -> np.ndarray | None:
        """The anchor."""
        return None if self.anchor is None else np.asarray(self.anchor, dtype=float)

    @property
    def parameters(self) -> tuple[float, ...]:
        """`(k, c, l_0)`."""
        return (self.stiffness, self.damping, self.rest_length)

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: Any, parameters: Any) -> tuple[Wrench, Wrench]:  # noqa: ARG004
        """Equal and opposite forces along the line."""
        stiffness, damping, rest_length = parameters
        between = second.point - first.point
        length = jnp.sqrt(between @ between)
        direction = between / length
        rate = direction @ (second.velocity - first.velocity)
        force = (stiffness * (length - rest_length) + damping * rate) * direction
        return Wrench(force, jnp.zeros(3)), Wrench(-force, jnp.zeros(3))

    @staticmethod
    def energy(first: Pose, second: Pose, value: Any, parameters: Any) -> Any:  # noqa: ARG004
        """`k (l - l_0)^2 / 2`."""
        stiffness, _, rest_length = parameters
        between = second.point - first.point
        return stiffness * (jnp.sqrt(between @ between) - rest_length) ** 2 / 2
