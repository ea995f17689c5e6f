"""Cases computed one after the other within a program that is mapped over them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

__all__ = ["sequential_vmap"]


def sequential_vmap(function: Callable[..., Any], *arguments: Any) -> Any:
    """`function(*arguments)`; under `jax.vmap` the cases are computed one after the other.

    A condition then stays a branch for each case, whereas mapped cases all compute both sides. Many small
    operations cost as little as in a program of one case.
    """
    leaves, structure = jax.tree.flatten(arguments)

    # Leaf by leaf: classes that check their fields do not accept the flags that JAX would put in their place.
    @jax.custom_batching.sequential_vmap
    def of_leaves(each: list[Any]) -> Any:
        return function(*structure.unflatten(each))

    return of_leaves([jnp.asarray(leaf) for leaf in leaves])
