"""Gaussian elimination of one dense system, as few operations as LAPACK allows."""

from __future__ import annotations

import jax

__all__ = ["solve_bordering_column"]


def solve_bordering_column(augmented: jax.Array) -> jax.Array:
    """Solve `A x = b` given `(A | b)`, (n, n + 1), by elimination with row pivoting; (n,).

    The factors of the wide matrix `P (A | b) = L (U | y)` hold `y = L^-1 P b`, so that one triangular solve
    is left and no row exchange has to be applied afterwards.
    """
    n = augmented.shape[0]
    factors, _, _ = jax.lax.linalg.lu(augmented)
    return jax.lax.linalg.triangular_solve(factors[:, :n], factors[:, n:], left_side=True)[:, 0]
