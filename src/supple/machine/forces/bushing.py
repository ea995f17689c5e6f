"""Bushing: stiffness and damping for all six relative motions of its ends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.rotation import rotation_log, rotation_right_jacobian
from supple.errors import ModelError
from supple.machine.forces.force_element import AxialElement
from supple.machine.forces.relative_motion import force_pair
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["Bushing"]

_SYMMETRIC = 1e-9


@dataclass(frozen=True, kw_only=True)
class Bushing(AxialElement):
    """Generalized force `Q = - K x - C dx/dt` for the relative motion `x = (d, theta)` of the ends.

        d = A_1^T (r_2 - r_1) - d_0,    exp(theta) = A_1^T A_2

    A_1 and A_2 are the axes of the bushing on the first and on the second end. The bushing is undeformed at
    the offset `d_0` and without relative rotation. `Q` is conjugate to x, so `x^T K x / 2` is the elastic
    energy. The magnitude of the rotation vector theta must stay below pi.

    axis : z axis of the bushing in the initial configuration, global axes
    x_axis : direction in the initial configuration, global axes; the x axis is as near it as possible
    stiffness, damping : (6,) diagonal, or (6, 6) symmetric, positive semidefinite; translations first
    Raises ModelError for any other stiffness or damping.
    """

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    x_axis: tuple[float, float, float] | None = None
    stiffness: ArrayLike
    damping: ArrayLike = (0.0,) * 6
    offset: tuple[float, float, float] | None = None
    """d_0, in the bushing's axes; default the offset of the ends at assembly"""

    hint_field: ClassVar[str] = "x_axis"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, _matrix(f"{self.label}: {name}", getattr(self, name)))

    @property
    def parameters(self) -> tuple[np.ndarray, ...]:
        """`(K, C, d_0)`."""
        offset = np.zeros(3) if self.offset is None else np.array(self.offset)
        return (np.array(self.stiffness), np.array(self.damping), offset)

    def assembled(self, first: np.ndarray, second: np.ndarray) -> Bushing:
        """The bushing with the offset of its ends at assembly as `d_0`, if none is given."""
        if self.offset is not None:
            return self
        return replace(self, offset=tuple((self.initial_axes.T @ (second - first)).tolist()))

    @staticmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:  # noqa: ARG004
        """The wrench equivalent to `Q` on the second end, and the balancing wrench on the first."""
        stiffness, damping, offset = parameters
        x = _deformation(first, second, offset)
        turning = rotation_right_jacobian(x[3:])
        moving = second.velocity - first.velocity
        moving = moving - jnp.cross(first.angular_velocity, second.point - first.point)
        spin = second.axes.T @ (second.angular_velocity - first.angular_velocity)
        rate = jnp.concatenate([first.axes.T @ moving, jnp.linalg.solve(turning, spin)])
        load = -(stiffness @ x + damping @ rate)
        moment = second.axes @ jnp.linalg.solve(turning.T, load[3:])
        return force_pair(first, second, first.axes @ load[:3], moment)

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """`x^T K x / 2`."""
        stiffness, _, offset = parameters
        x = _deformation(first, second, offset)
        return x @ stiffness @ x / 2


def _deformation(first: Pose, second: Pose, offset: jax.Array) -> jax.Array:
    shift = first.axes.T @ (second.point - first.point) - offset
    return jnp.concatenate([shift, rotation_log(first.axes.T @ second.axes)])


def _matrix(what: str, given: ArrayLike) -> tuple[tuple[float, ...], ...]:
    """The matrix (6, 6), as tuples; ModelError unless it is symmetric and positive semidefinite."""
    array = np.asarray(given, dtype=float)
    matrix = np.diag(array) if array.shape == (6,) else array
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise ModelError(f"{what} must be (6,) or (6, 6) finite numbers, got shape {array.shape}")
    size = abs(matrix).max()
    if abs(matrix - matrix.T).max() > _SYMMETRIC * size:
        raise ModelError(f"{what} must be symmetric: otherwise it would generate energy")
    # The matrix is scaled by its diagonal, so that moments are not compared with forces.
    own = np.sqrt(np.abs(np.diag(matrix)))
    scale = np.where(own > 0, own, np.sqrt(size) if size else 1.0)
    scaled = matrix / np.outer(scale, scale)
    if np.linalg.eigvalsh(scaled).min() < -_SYMMETRIC:
        raise ModelError(f"{what} must not be negative in any direction: check its signs")
    return tuple(map(tuple, matrix.tolist()))
