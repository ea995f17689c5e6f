"""A quantity given as a function of time of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import jax
from jax.typing import ArrayLike

from supple.errors import ModelError, SuppleError
from supple.machine.laws.unbounded_law import UnboundedLaw

__all__ = ["TimeFunction"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TimeFunction(UnboundedLaw):
    """A function of time written with `jax.numpy`.

    It must be smooth enough for its use: twice differentiable where it prescribes a motion.

    The function is part of the compiled program, not of its data: another function compiles anew, and the
    cases of a batch must share one object. Numbers that differ between runs or cases belong into the other
    laws. A later process finds the program again where the function takes all that it uses from its
    arguments, plain numbers, functions like it, `jax.numpy` and `math`.
    """

    function: Callable[[Any], Any] = field(metadata={"static": True})

    def __call__(self, time: ArrayLike) -> jax.Array:
        """The function's value; ModelError where JAX cannot trace it."""
        return traced(
            self.function, getattr(self.function, "__qualname__", type(self.function).__name__), time
        )


def traced(function: Callable[[Any], Any], name: str, time: ArrayLike) -> jax.Array:
    """The value of a function of time; ModelError names it, and the remedy, where JAX cannot trace it."""
    try:
        return function(time)
    except jax.errors.TracerArrayConversionError as error:
        raise ModelError(
            f"its function of time must be written with jax.numpy, not numpy ({name}): jnp.sin for np.sin"
        ) from error
    except (jax.errors.TracerBoolConversionError, jax.errors.NonConcreteBooleanIndexError) as error:
        raise ModelError(
            f"its function of time ({name}) branches on a condition of the time (if, while, and, "
            "or, max, "
            "min of Python), which has no value yet when JAX compiles it; write jnp.where(condition, this, "
            "that)"
        ) from error
    except (jax.errors.JAXTypeError, jax.errors.JAXIndexError) as error:
        raise ModelError(
            f"its function of time ({name}) converts the time to a Python number (math.sin, float, int, "
            "range, an "
            "index), which has no value yet when JAX compiles it; write jnp.sin for math.sin, and jnp.where("
            "condition, this, that) for a choice"
        ) from error
    except SuppleError:
        raise
    except Exception as error:  # whatever a function of somebody else's may run into
        raise ModelError(
            f"its function of time ({name}) fails: {type(error).__name__}: {error}; it takes the time and "
            "gives "
            "a number or an array, written with jax.numpy (and jnp.where for a choice)"
        ) from error
