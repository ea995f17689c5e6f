"""Quantities given as functions of time: prescribed motions, forces, torques.

A law is a JAX pytree, whose leaves are its numbers. Machines that differ only in these numbers, such as the
cases of a batch, share one compiled program.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Protocol, runtime_checkable

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax.typing import ArrayLike

from supple.arguments import check_numbers, given
from supple.errors import ArgumentError, ModelError, SuppleError
from supple.machine.laws.constant import Constant
from supple.machine.laws.time_function import TimeFunction, traced
from supple.value_content import UserFunction, is_users

__all__ = ["TimeLaw"]

_EXPECTED = "a number, an array, a law such as Ramp(1.0, 2.0), or a function of time"


@runtime_checkable
class TimeLaw(Protocol):
    """A value, or an array of values, over time: `law(time)`, defined from `law.begin` to `law.end`.

    `supple` calls a law with one time, and maps the call over several times by `jax.vmap`. A user-defined law
    is a dataclass with `__call__`, `begin` and `end`, registered by `jax.tree_util.register_dataclass`.
    """

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value at a time; JAX traces and differentiates this function."""

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        ...

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        ...


OverTime = TimeLaw | Callable[[Any], Any] | npt.ArrayLike
"""A quantity as it is given: a law, a function of time, a number or an array."""


@dataclass(frozen=True)
class _UsersLaw:
    """A law of a user-defined class. Its methods, and what they read, are part of the compiled program."""

    law: TimeLaw

    def __call__(self, time: ArrayLike) -> jax.Array:
        return self.law(time)

    @property
    def begin(self) -> float:
        """Begin of the user's law."""
        return self.law.begin

    @property
    def end(self) -> float:
        """End of the user's law."""
        return self.law.end


jax.tree_util.register_pytree_node(
    _UsersLaw,
    lambda users: ((users.law,), UserFunction(type(users.law))),
    lambda _, laws: _UsersLaw(*laws),
)


def as_time_law(value: OverTime) -> TimeLaw:
    """The law of a quantity that is given as a law, a function of time, a number or an array."""
    if isinstance(value, type):  # a class such as Ramp would pass for a law below
        raise ArgumentError(f"a quantity over time: expected {_EXPECTED}, got {given(value)}")
    if isinstance(value, TimeLaw):
        return _UsersLaw(value) if is_users(type(value)) else value
    if callable(value):
        return TimeFunction(value)
    try:
        check_numbers("a quantity over time", value)
    except ArgumentError as error:
        raise ArgumentError(f"a quantity over time: expected {_EXPECTED}, got {given(value)}") from error
    return Constant(value)


def check_law_kind(what: str, element: Any) -> None:
    """Raise ArgumentError, beginning with `what`, if the `law` of a joint or load cannot be a law of time."""
    try:
        _ = element.law
    except ArgumentError as error:
        raise ArgumentError(f"{what}: {error}") from error


def check_law_shape(what: str, law: TimeLaw, *shapes: tuple[int, ...]) -> None:
    """Raise ModelError unless JAX can trace the law, and its values are real numbers of one of the shapes."""
    try:
        found = _value_of(law)
    except SuppleError as error:
        raise ModelError(f"{what}: {error}") from error
    except (TypeError, ValueError) as error:
        raise ModelError(
            f"{what}: its law over time returns no numbers ({error}); give numbers, or arrays of jax.numpy"
        ) from error
    if found.dtype.kind not in "iuf":
        raise ModelError(
            f"{what}: its values over time are of the kind {found.dtype}; give real numbers, such as "
            "jnp.where(condition, 1.0, 0.0)"
        )
    if found.shape not in shapes:
        wanted = " or ".join(map(str, shapes))
        raise ModelError(f"{what}: its values over time have shape {found.shape}; they must have {wanted}")


def begins_after(law: TimeLaw, time: float) -> bool:
    """Whether a law begins later than a time, by more than rounding."""
    return law.begin > time + 1e-12 * abs(time)


def ends_before(law: TimeLaw, time: float) -> bool:
    """Whether a law ends earlier than a time, by more than rounding."""
    return law.end < time - 1e-12 * abs(time)


def check_law_covers(what: str, law: TimeLaw, time: float) -> None:
    """Raise ModelError, beginning with `what`, for a law that is not defined at a time."""
    if begins_after(law, time) or ends_before(law, time):
        raise ModelError(
            f"{what}: its table is from t = {law.begin:g} to {law.end:g}, and its value is needed at "
            f"t = {time:g}. Give a time within the table, or extend the table"
        )


@dataclass(frozen=True)
class _LawStructure:
    """Structure of a law without its numbers: equal for laws that differ only in numbers."""

    structure: Any
    shapes: tuple[tuple[int, ...], ...]
    law: TimeLaw = field(compare=False)
    """Any law of this structure, for tracing."""


def _value_of(law: TimeLaw) -> jax.ShapeDtypeStruct:
    """Shape and type of a law's values; laws of the same structure are traced once."""
    leaves, structure = jax.tree.flatten(law)
    own = _LawStructure(structure, tuple(map(np.shape, leaves)), law)
    if all(isinstance(leaf, float) or _is_array(leaf) for leaf in leaves):
        try:
            hash(own)
        except TypeError:  # a part of the law has no hash
            pass
        else:
            return _traced_value(own)
    return _traced_value.__wrapped__(own)


def _is_array(leaf: Any) -> bool:
    """Whether a leaf is a NumPy array of float64, not a JAX tracer."""
    return isinstance(leaf, np.ndarray) and leaf.dtype == np.float64


@lru_cache(maxsize=64)
def _traced_value(of: _LawStructure) -> jax.ShapeDtypeStruct:
    law = of.law
    return jax.eval_shape(lambda time: jnp.asarray(traced(law, type(law).__name__, time)), jnp.zeros(()))
