"""Base of all joints: two ends, axes in the initial configuration, and constraint equations.

Each end has a *joint frame* (`Pose`): a point r_1 or r_2, and a matrix A_1 or A_2, whose columns are the axes
x, y and z. The two frames coincide in the initial configuration. The constraint equations must be affine
functions of `A_1^T (r_2 - r_1)` and `A_1^T A_2`. `joint_linearization` computes their Jacobian and geometric
stiffness, so a new joint defines only `constraint`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from supple.algebra.rotation import unskew
from supple.arguments import check_fields, check_numbers
from supple.errors import ModelError
from supple.machine.ends import GROUND, At, as_end
from supple.machine.laws.time_law import TimeLaw, check_law_kind
from supple.machine.pose import Pose

__all__ = ["Joint"]

POSITION = ("position x", "position y", "position z")
ROTATION = ("rotation x", "rotation y", "rotation z")
TILT = ("tilt about x", "tilt about y")
"""Names of equations, for `Joint.rows`."""


def relative_turn(first: Pose, second: Pose) -> jax.Array:
    """`sin(angle) axis` of the rotation from the first frame to the second, in the first frame, (3,)."""
    return unskew(first.axes.T @ second.axes)


def tilt(first: Pose, second: Pose) -> jax.Array:
    """`z_1 x z_2`: tilt of the second z axis about the x and y axes of the first frame, (2,)."""
    x, y, _ = first.axes.T @ second.axes[:, 2]
    return jnp.stack([-y, x])


def axes_along(axis: ArrayLike, hint: ArrayLike | None = None) -> np.ndarray:
    """Right-handed unit axes, as columns: the third along `axis`, the first along the projection of `hint`.

    hint : vector that is projected on the plane normal to `axis`; default: a global axis
    Raises ModelError for an axis that is zero or not finite, or a hint parallel to the axis.
    """
    check_numbers("the axis of a joint", axis)
    direction = _unit(axis)
    near = np.eye(3)[np.argmin(abs(direction))] if hint is None else _unit(hint)
    first = near - (near @ direction) * direction
    if np.linalg.norm(first) < 1e-8 * np.linalg.norm(near):
        raise ModelError(f"the two axes of a joint must not be parallel, got {axis} and {hint}")
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(direction, first), direction])


def _unit(axis: ArrayLike) -> np.ndarray:
    """Unit vector along an axis of any length; ModelError for an axis that is zero or not finite."""
    direction = np.asarray(axis, dtype=float)
    if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
        raise ModelError(f"a joint axis must be three finite numbers, not all zero; got {axis}")
    direction = direction / np.abs(direction).max()
    return direction / np.linalg.norm(direction)


@dataclass(frozen=True, kw_only=True)
class Joint(ABC):
    """A joint between two ends; subclasses define its constraint equations."""

    first: At | Any
    """An end: "BODY.INTERFACE", `At(body, interface)`, or "ground"; stored as an `At`."""
    second: At | Any
    """The other end."""
    name: str = ""

    rows: ClassVar[tuple[str, ...]]
    """What each constraint equation fixes; the name begins with "position" if its residual is a length."""

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "first", as_end(self.first))
        object.__setattr__(self, "second", as_end(self.second))
        if not self.name:
            object.__setattr__(self, "name", f"{type(self).__name__.lower()} {self.first} - {self.second}")
        if GROUND == self.first == self.second:
            raise ModelError(f"joint '{self.name}' joins the ground to itself: give a body's interface")
        if self.first == self.second:
            raise ModelError(f"joint '{self.name}' joins '{self.first}' to itself: give another interface")
        check_law_kind(f"joint '{self.name}'", self)
        _ = self.initial_axes  # raises for a vector without direction

    @property
    def initial_axes(self) -> np.ndarray:
        """Joint axes in the initial configuration, as columns in global components.

        z is the axis of the joint, if it has one.
        """
        return np.eye(3)

    @property
    def n_constraints(self) -> int:
        """Number of constraint equations."""
        return len(self.rows)

    @property
    def law(self) -> TimeLaw | None:
        """The law of the prescribed motion; None without one."""
        return None

    @staticmethod
    @abstractmethod
    def constraint(first: Pose, second: Pose, value: jax.Array) -> jax.Array:
        """The constraint residual g (n_constraints,), affine in the second frame relative to the first.

        value : value of `law` at this time; None without a law
        """


@dataclass(frozen=True, kw_only=True)
class AxialJoint(Joint):
    """A joint with an axis, or a line, fixed to its first end."""

    axis: tuple[float, float, float]
    """Direction of the axis in the initial configuration, in global components."""

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis."""
        return axes_along(self.axis)


def closing(first: Pose, second: Pose) -> jax.Array:
    """Vector from the first point to the second, in the axes of the first frame, (3,)."""
    return first.axes.T @ (second.point - first.point)


def stack(*equations: jax.Array) -> jax.Array:
    """Scalars and vectors as one vector of equations."""
    return jnp.concatenate([jnp.atleast_1d(jnp.asarray(e)) for e in equations])
