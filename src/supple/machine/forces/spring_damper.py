"""Spring and damper along the line between two points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.machine.ends import GROUND
from supple.machine.forces.force_element import ForceElement, check_not_negative
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
        if (GROUND in (self.first, self.second)) != (self.anchor is not None):
            raise ModelError(
                f"{self.label}: an end on the ground, and only such an end, needs an anchor: the global "
                "point it is fixed to"
            )
        if self.anchor is not None and not (np.shape(self.anchor) == (3,) and np.isfinite(self.anchor).all()):
            raise ModelError(f"{self.label}: the anchor must be three finite numbers, got {self.anchor}")

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
