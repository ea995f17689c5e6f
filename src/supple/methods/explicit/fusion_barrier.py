"""A stage of a compiled step whose results are stored in memory before the next stage reads them.

Otherwise the compiler fuses all operations into one loop for each component of the result, and recomputes
shared terms in each: for a plastic hexahedron, ten times the arithmetic. The compiler removes a
`lax.optimization_barrier` before it fuses. Operations within a branch are never fused with those outside, so
a stage is the branch of a condition that is always true.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jax import lax
from jax.core import Tracer

Given = TypeVar("Given")
Found = TypeVar("Found")


def fusion_barrier(stage: Callable[[Given], Found], given: Given) -> Found:
    """stage(given); `given` and the result are trees of arrays, and no array is empty."""
    first = jax.tree.leaves(given)[0]
    if not isinstance(first, Tracer):
        return stage(given)  # no fusion outside compiled code, where each branch would be compiled by itself
    # True for every number, and for NaN; the compiler cannot derive this.
    holds = ~(first.ravel()[0] < -jnp.inf)
    like = jax.eval_shape(stage, given)

    def never(_: Given) -> Found:
        return jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), like)

    return lax.cond(holds, stage, never, given)
