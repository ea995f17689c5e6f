"""A stage of a compiled step that is worked out in memory before the next one reads it.

The compiler would rather join all operations into one loop for each component of the result, and work out
what the components share again in each: for a hexahedron that yields, ten times the arithmetic. A barrier
(`lax.optimization_barrier`) is gone before it decides so. What stands in a branch is never joined with what
stands outside, so a stage is the branch of a condition that always holds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jax import lax
from jax.core import Tracer

__all__ = ["fusion_barrier"]

Given = TypeVar("Given")
Found = TypeVar("Found")


def fusion_barrier(stage: Callable[[Given], Found], given: Given) -> Found:
    """stage(given), both trees of arrays, none of them empty."""
    first = jax.tree.leaves(given)[0]
    if not isinstance(first, Tracer):
        return stage(given)  # outside compiled code nothing is joined, and a branch would be compiled alone
    # True of every number, also of none, which the compiler does not know.
    holds = ~(first.ravel()[0] < -jnp.inf)
    like = jax.eval_shape(stage, given)

    def never(_: Given) -> Found:
        return jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), like)

    return lax.cond(holds, stage, never, given)
