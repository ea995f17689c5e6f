"""Rotor bearing: stiffness and damping across its axis, with cross terms, as functions of speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.machine.forces.characteristic import curve_at
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import axial_motion, force_pair
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["JournalBearing"]

ANY_SPEED = (0.0, 1.0)
"""Speeds of a table of equal matrices."""


@dataclass(frozen=True, kw_only=True)
class JournalBearing(AxialElement):
    """Force `- K(Omega) u - C(Omega) du/dt` on the journal, the second end, across the bearing's axis.

    `u` (2,) is the offset of the journal from the bearing, the first end, along x and y of the bearing;
    `Omega` is the angular velocity of the journal relative to the bearing, about the axis. Cross terms K_xy
    and K_yx of opposite sign feed energy into whirl. K and C are interpolated linearly between the speeds of
    the table, and constant beyond the first and last speed.

    x_axis : direction at the start, global axes; the bearing's x axis is as near it as possible. Default: the
        global axis that is farthest from the axis, of equal ones the first
    stiffness, damping : (2, 2) for all speeds, or (n, 2, 2), one matrix for each speed
    speeds : (n,) rad per time, ascending, two or more; None for matrices that are the same at all speeds
    Raises ModelError for other shapes, a table without speeds, matrices that are not finite, and speeds that
    do not ascend.
    """

    x_axis: tuple[float, float, float] | None = None
    stiffness: ArrayLike
    damping: ArrayLike = ((0.0, 0.0), (0.0, 0.0))
    speeds: tuple[float, ...] | None = None

    hint_field: ClassVar[str] = "x_axis"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speeds is None:
            for name in ("stiffness", "damping"):
                if np.ndim(getattr(self, name)) == 3 and len(getattr(self, name)) > 1:
                    raise ModelError(
                        f"{self.label}: a table of {name} needs the speeds of its matrices: give speeds, "
                        "one for each matrix"
                    )
        speeds = np.asarray(ANY_SPEED if self.speeds is None else self.speeds, dtype=float)
        is_table = speeds.ndim == 1 and len(speeds) > 1 and np.isfinite(speeds).all()
        if not (is_table and (np.diff(speeds) > 0).all()):
            raise ModelError(f"{self.label}: speeds must be two or more ascending finite numbers")
        object.__setattr__(self, "speeds", tuple(speeds.tolist()))
        for name in ("stiffness", "damping"):
            given = np.asarray(getattr(self, name), dtype=float)
            alike = given.shape in ((2, 2), (1, 2, 2))
            table = np.broadcast_to(given, (len(speeds), 2, 2)) if alike else given
            if table.shape != (len(speeds), 2, 2) or not np.isfinite(table).all():
                raise ModelError(
                    f"{self.label}: {name} must be (2, 2) or ({len(speeds)}, 2, 2) finite numbers, one "
                    f"matrix a speed, got shape {given.shape}"
                )
            object.__setattr__(self, name, tuple(tuple(map(tuple, own)) for own in table.tolist()))

    @property
    def parameters(self) -> tuple[np.ndarray, ...]:
        """`(Omega (n,), K (n, 2, 2), C (n, 2, 2))`."""
        return tuple(np.array(getattr(self, name)) for name in ("speeds", "stiffness", "damping"))

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """Force on the journal, and the balancing wrench on the bearing."""
        speeds, stiffness, damping = parameters
        speed = axial_motion(first, second).rate
        across = first.axes[:, :2]
        between = second.point - first.point
        moving = second.velocity - first.velocity - jnp.cross(first.angular_velocity, between)
        force = curve_at(speed, (speeds, stiffness)) @ (across.T @ between)
        force = force + curve_at(speed, (speeds, damping)) @ (across.T @ moving)
        return force_pair(first, second, -across @ force, jnp.zeros(3))
