"""Cases that take turns where the rest of a program is mapped over them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

__all__ = ["sequential_vmap"]


def sequential_vmap(function: Callable[..., Any], *arguments: Any) -> Any:
    """`function(*arguments)`; under `jax.vmap` one case after the other instead of all at once.

    A condition then stays a branch that a case takes or leaves, where mapped together all cases would pay for
    both sides; and what is put together from many small pieces costs as little as in a program of one case.
    """
    leaves, structure = jax.tree.flatten(arguments)

    # By leaves: classes that check what they are made of do not take the flags that JAX would put in place.
    @jax.custom_batching.sequential_vmap
    def of_leaves(each: list[Any]) -> Any:
        return function(*structure.unflatten(each))

    return of_leaves([jnp.asarray(leaf) for leaf in leaves])
