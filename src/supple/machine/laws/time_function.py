"""A quantity given as a user-defined function of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
from jax.typing import ArrayLike

from supple.errors import ModelError, SuppleError
from supple.machine.laws.law_numbers import UnboundedLaw
from supple.value_content import UserFunction

__all__ = ["TimeFunction"]


@dataclass(frozen=True)
class TimeFunction(UnboundedLaw):
    """A function of time written with `jax.numpy`.

    A function that prescribes a motion must be twice differentiable.

    The function is compiled with the equations. A change of the function, or of the value of a variable that
    it reads, therefore needs a new compilation, and all cases of a batch must have the same function object.
    For numbers that differ between runs or cases, use the other laws. The compiled program is stored. A later
    process reuses it if the function depends only on its arguments, plain numbers, `jax.numpy`, `math`, and
    functions for which the same is true.
    """

    function: Callable[[Any], Any]

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The value of the function; ModelError if JAX cannot trace the function."""
        return traced(
            self.function, getattr(self.function, "__qualname__", type(self.function).__name__), time
        )


jax.tree_util.register_pytree_node(
    TimeFunction,
    lambda law: ((), UserFunction(law.function)),
    lambda function, _: TimeFunction(function.function),
)


def traced(function: Callable[[Any], Any], name: str, time: ArrayLike) -> jax.Array:
    """The value of a function of time; ModelError, with the remedy, if JAX cannot trace the function."""
    try:
        return function(time)
    except jax.errors.TracerArrayConversionError as error:
        raise ModelError(
            f"its function of time must be written with jax.numpy, not numpy ({name}): jnp.sin for np.sin"
        ) from error
    except (jax.errors.TracerBoolConversionError, jax.errors.NonConcreteBooleanIndexError) as error:
        raise ModelError(
            f"its function of time ({name}) branches on a condition of the time (if, while, and, or, max, "
            "min of Python), which has no value yet when JAX compiles it; write jnp.where(condition, this, "
            "that)"
        ) from error
    except (jax.errors.JAXTypeError, jax.errors.JAXIndexError) as error:
        raise ModelError(
            f"its function of time ({name}) converts the time to a Python number (math.sin, float, int, "
            "range, an index), which has no value yet when JAX compiles it; write jnp.sin for math.sin, and "
            "jnp.where(condition, this, that) for a choice"
        ) from error
    except SuppleError:
        raise
    except Exception as error:  # any exception of a user's function
        raise ModelError(
            f"its function of time ({name}) fails: {type(error).__name__}: {error}; it must return "
            "a number or an array for a time, written with jax.numpy (and jnp.where for a choice)"
        ) from error
