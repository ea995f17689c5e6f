"""Quantities given as functions of time: prescribed motions, forces, torques.

A law is a JAX pytree whose numbers are leaves: systems that differ in these numbers alone, such as the cases
of a batch, share one compiled program.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import jax
import jax.numpy as jnp

from supple.errors import ModelError
from supple.machine.laws.constant import Constant
from supple.machine.laws.time_function import TimeFunction

__all__ = ["TimeLaw", "as_time_law", "check_law_shape"]


@runtime_checkable
class TimeLaw(Protocol):
    """A value, or an array of them, over time: `law(time)`, defined from `law.begin` to `law.end`.

    A law of one's own is a dataclass with these three, registered by `jax.tree_util.register_dataclass`.
    """

    def __call__(self, time: Any) -> Any:
        """The value at a time, traced and differentiated by JAX."""

    @property
    def begin(self) -> float:
        """First time at which the law is defined."""
        ...

    @property
    def end(self) -> float:
        """Last time at which the law is defined."""
        ...


def as_time_law(value: Any) -> TimeLaw:
    """The law meant by a law, a function of time, a number or an array."""
    if isinstance(value, TimeLaw):
        return value
    return TimeFunction(value) if callable(value) else Constant(value)


def check_law_shape(what: str, law: TimeLaw, *shapes: tuple[int, ...]) -> None:
    """Raise ModelError unless the law's values have one of the shapes, and JAX can trace it."""
    try:
        shape = jax.eval_shape(lambda time: jnp.asarray(law(time)), jnp.zeros(())).shape
    except jax.errors.TracerArrayConversionError as error:
        raise ModelError(f"{what}: its function of time must be written with jax.numpy, not numpy") from error
    if shape not in shapes:
        wanted = " or ".join(map(str, shapes))
        raise ModelError(f"{what}: its values over time have shape {shape}; they must have {wanted}")
