"""Bases of all forces between two markers: ends, parameters, and wrenches on the ends; axis; anchor."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import jax
import numpy as np
from jax.typing import ArrayLike

from supple.arguments import check_fields, check_ranges
from supple.errors import ModelError
from supple.machine.ends import GROUND, At, as_end
from supple.machine.joints.joint import axes_along
from supple.machine.laws.time_law import TimeLaw, as_time_law, check_law_kind
from supple.machine.pose import Parameters, Pose, Wrenches

__all__ = ["ForceElement"]


@dataclass(frozen=True, kw_only=True)
class ForceElement(ABC):
    """A force law between two markers; JAX differentiates `wrenches` for the tangent."""

    first: At | Any
    """An end: "BODY.INTERFACE", `At(body, interface)`, or "ground"; stored as an `At`."""
    second: At | Any = GROUND
    """The other end."""

    law_field: ClassVar[str] = ""
    """Field with the law of time: a number, an array, a function of time or a law; empty without one."""
    parameter_fields: ClassVar[tuple[str, ...]] = ()
    """Fields that are passed to `wrenches` and `energy`, in this order."""
    value_shape: ClassVar[tuple[int, ...]] = ()
    """Shape of the law's value, if there is a law."""
    acts_along_line: ClassVar[bool] = False
    """True if the force depends on the direction between the ends, which must then not coincide."""

    reads_reaction: ClassVar[bool] = False
    """True if the `value` of `wrenches` is a joint force instead of a law's value, as in `JointFriction`."""

    acts_on_first_alone: ClassVar[bool] = False
    """True if the element has no wrench on its second end, as a `FollowerForce`."""

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "first", as_end(self.first))
        object.__setattr__(self, "second", as_end(self.second))
        if GROUND == self.first == self.second:
            raise ModelError(f"{self.label} acts on the ground alone: give a body's interface")
        if self.acts_on_first_alone and self.first == GROUND:
            raise ModelError(
                f"{self.label} acts on its first end alone, so on the ground it has no effect: give "
                f"first='{self.second}', and leave out second"
            )
        check_law_kind(self.label, self)
        check_ranges(self.label, self)

    @property
    def label(self) -> str:
        """Name for messages."""
        return f"{type(self).__name__} on {self.first}"

    @property
    def initial_axes(self) -> np.ndarray:
        """Common axes of both markers in the initial configuration, global, as columns."""
        return np.eye(3)

    @property
    def ground_point(self) -> np.ndarray | None:
        """Point of action on the ground (3,); None: the initial position of the element's other end."""
        return None

    @property
    def law(self) -> TimeLaw | None:
        """The law of time; None without one."""
        return as_time_law(getattr(self, self.law_field)) if self.law_field else None

    @property
    def parameters(self) -> tuple[ArrayLike | None, ...]:
        """Numbers and arrays passed to `wrenches` and `energy`: by default those of `parameter_fields`."""
        return tuple(getattr(self, name) for name in self.parameter_fields)

    def assembled(self, first: np.ndarray, second: np.ndarray) -> Self:  # noqa: ARG002 - most need no places
        """The element, completed by data from the global positions (3,) of its ends at assembly."""
        return self

    @staticmethod
    @abstractmethod
    def wrenches(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> Wrenches:
        """Wrenches on the two ends; `value` is the law's value at this time, None without a law."""

    @staticmethod
    def energy(first: Pose, second: Pose, value: jax.Array, parameters: Parameters) -> jax.Array | float:  # noqa: ARG004
        """Recoverable energy stored in the element; zero unless a subclass defines it."""
        return 0.0


@dataclass(frozen=True, kw_only=True)
class AxialElement(ForceElement):
    """A force element with an axis fixed to its first end; subclasses define its force.

    axis : direction in the initial configuration, global axes, of any length
    Raises ModelError for an axis without a direction.
    """

    axis: tuple[float, float, float]

    hint_field: ClassVar[str] = ""
    """Field with a direction near which the x axis lies; empty: the global axis farthest from the axis."""
    blocked_by: ClassVar[tuple[str, ...]] = ()
    """Names in `Joint.rows`, without the axis, of equations that prevent the element's motion.

    A `System` with such a joint between the same ends is an error. Empty: no check.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.initial_axes  # raises for a vector without direction

    @property
    def initial_axes(self) -> np.ndarray:
        """Z along the axis, x as near the hint as possible."""
        return axes_along(self.axis, hint=getattr(self, self.hint_field) if self.hint_field else None)


@dataclass(frozen=True, kw_only=True)
class AnchoredElement(ForceElement):
    """A force element of which one end may be a point fixed to the ground.

    anchor : global position (3,) of the end "ground"; None if both ends are interfaces
    Raises ModelError for an end on the ground without an anchor, and for an anchor without such an end.
    """

    anchor: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
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
