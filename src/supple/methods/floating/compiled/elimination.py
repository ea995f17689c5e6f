"""Solution and inverse of small dense systems in a compiled program, by LAPACK or by compiled loops.

LAPACK is an external library. XLA splits a loop with LAPACK calls into hundreds of separate operations, each
a fraction of a microsecond. Without such calls, the time integration is one function of machine code
(`algebra/jax_settings.py`): a step takes a third to a sixth of the time, compilation twice the time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import jax
import jax.numpy as jnp


class DenseElimination(Protocol):
    """Solver of the dense systems in a compiled program."""

    def solution(self, augmented: jax.Array) -> jax.Array:
        """Solve `A x = b` given `(A | b)`, (n, n + 1), with row exchanges; (n,)."""
        ...

    def inverse(self, matrix: jax.Array) -> jax.Array:
        """Inverse of a matrix (n, n), with row exchanges."""
        ...


@dataclass(frozen=True)
class ByLapack:
    """Factorisation by LAPACK: fast for large matrices, and compiled quickly."""

    def solution(self, augmented: jax.Array) -> jax.Array:
        """Solution as specified by `DenseElimination`."""
        return solve_bordering_column(augmented)

    def inverse(self, matrix: jax.Array) -> jax.Array:
        """Inverse as specified by `DenseElimination`."""
        return _factored(jnp.concatenate([matrix, jnp.eye(len(matrix))], axis=1))


@dataclass(frozen=True)
class ByLoops:
    """Gaussian elimination in compiled loops for matrices up to `largest`; LAPACK is faster beyond.

    Devices other than CPUs use their own library, since a loop there is a sequence of separate programs.
    """

    largest: int = 48

    def solution(self, augmented: jax.Array) -> jax.Array:
        """Solution as specified by `DenseElimination`."""
        return _eliminated(augmented)[:, 0] if self._serve(augmented) else ByLapack().solution(augmented)

    def inverse(self, matrix: jax.Array) -> jax.Array:
        """Inverse as specified by `DenseElimination`."""
        return _exchanged(matrix) if self._serve(matrix) else ByLapack().inverse(matrix)

    def _serve(self, matrix: jax.Array) -> bool:
        return len(matrix) <= self.largest and jax.default_backend() == "cpu"


_ROWS_BESIDE_SIDES = range(25, 44), 44
_ROWS_IN_PLACE = range(13, 32), 32
"""Lengths of rows whose loop the compiler unrolls, at up to twice the run time; and the length to which such
rows are padded with zeros. From this length on, the compiler vectorises the loop over a row."""


def solve_bordering_column(augmented: jax.Array) -> jax.Array:
    """Solve `A x = b` given `(A | b)`, (n, n + 1), by LAPACK with row pivoting; (n,)."""
    return _factored(augmented)[:, 0]


def _factored(augmented: jax.Array) -> jax.Array:
    """`A^-1 B` (n, m) of `(A | B)`, (n, n + m), by LAPACK, or by the library of another device.

    The factors of the wide matrix `P (A | B) = L (U | Y)` contain `Y = L^-1 P B`. So one triangular solve
    suffices, without later row exchanges. A GPU factorises many matrices in one call only if they are square;
    wide ones it factorises one after the other.
    """
    n = len(augmented)
    if jax.default_backend() != "cpu":
        return jnp.linalg.solve(augmented[:, :n], augmented[:, n:])
    factors, _, _ = jax.lax.linalg.lu(augmented)
    return jax.lax.linalg.triangular_solve(factors[:, :n], factors[:, n:], left_side=True)


def _eliminated(augmented: jax.Array) -> jax.Array:
    """`A^-1 B` (n, m) of `(A | B)`, (n, n + m), by Gaussian elimination.

    The pivot of column k is the largest entry there among the rows that have not been pivots. Rows stay in
    place; the pivot row of each column is stored for the substitution.
    """
    n, width = augmented.shape
    rows = jnp.arange(n)

    def clear(k: jax.Array, known: tuple[jax.Array, jax.Array, jax.Array]):
        matrix, done, order = known
        column = jax.lax.dynamic_slice(matrix, (0, k), (n, 1))[:, 0]
        pivot = jnp.argmax(jnp.where(done, -1.0, jnp.abs(column)))
        done = done | (rows == pivot)
        factors = jnp.where(done, 0.0, column / column[pivot])
        return matrix - factors[:, None] * matrix[pivot], done, jnp.where(rows == k, pivot, order)

    start = _filled_up(augmented, *_ROWS_BESIDE_SIDES), jnp.zeros(n, dtype=bool), jnp.zeros(n, dtype=int)
    matrix, _, order = jax.lax.fori_loop(0, n, clear, start)

    def substitute(number: jax.Array, solution: jax.Array):
        k = n - 1 - number
        row = matrix[order[k]]
        known = (row[:n, None] * solution).sum(axis=0)
        return jax.lax.dynamic_update_slice(solution, ((row[n:width] - known) / row[k])[None], (k, 0))

    return jax.lax.fori_loop(0, n, substitute, jnp.zeros((n, width - n)))


def _exchanged(matrix: jax.Array) -> jax.Array:
    """Inverse of a matrix (n, n) by exchange steps, in place: a third of the work of eliminating (A | I).

    Each step solves the equation of one `y_p` in `y = A x` for one `x_k` and exchanges the two,

        a_pk <- 1 / a_pk,   a_pj <- - a_pj / a_pk,   a_ik <- a_ik / a_pk,   a_ij <- a_ij - a_ik a_pj / a_pk

    with `p` the row of the largest `|a_pk|` among those not yet exchanged. Source: [Stiefel1963], chapter 1.
    """
    n = len(matrix)
    rows = jnp.arange(n)
    start = _filled_up(matrix, *_ROWS_IN_PLACE)
    columns = jnp.arange(start.shape[1])

    def exchange(k: jax.Array, known: tuple[jax.Array, jax.Array, jax.Array]):
        matrix, done, order = known
        column = jax.lax.dynamic_slice(matrix, (0, k), (n, 1))[:, 0]
        pivot = jnp.argmax(jnp.where(done, -1.0, jnp.abs(column)))
        inverted = 1.0 / column[pivot]
        row = jnp.where(columns == k, inverted, -inverted * matrix[pivot])
        here = rows == pivot
        # Masks instead of indexed writes: the whole step is one loop over the matrix.
        others = jnp.where(here[:, None] | (columns == k), 0.0, matrix)
        exchanged = others + jnp.where(here, 1.0, column)[:, None] * row
        return exchanged, done | here, jnp.where(rows == k, pivot, order)

    start = start, jnp.zeros(n, dtype=bool), jnp.zeros(n, dtype=int)
    matrix, _, order = jax.lax.fori_loop(0, n, exchange, start)
    # Inverse of the permutation; not by sorting, which would call a library.
    return matrix[order][:, jnp.argmax(order == rows[:, None], axis=1)]


def _filled_up(matrix: jax.Array, short: range, long: int) -> jax.Array:
    """The matrix with rows padded to length `long` where their length is in the range `short`."""
    width = matrix.shape[1]
    return jnp.pad(matrix, ((0, 0), (0, long - width))) if width in short else matrix
