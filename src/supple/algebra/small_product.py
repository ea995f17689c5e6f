"""Products of small matrices, in a form that compiles into the surrounding loop.

XLA calls a library for every `@`: for 3 x 3 matrices the call costs many times the arithmetic. Written as a
sum, the product becomes part of the loop around it.
"""

from __future__ import annotations

import jax


@jax.jit
def small_product(a: jax.Array, b: jax.Array) -> jax.Array:
    """`a @ b` for a (..., m) and b (m, n) or (m,), m small."""
    if b.ndim == 1:
        return (a * b).sum(axis=-1)
    return (a[..., None] * b).sum(axis=-2)
