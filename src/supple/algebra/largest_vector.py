"""The largest of many vectors along a motion, from evaluation at few times."""

from __future__ import annotations

import numpy as np

from supple.algebra.sparse_factor import Matrix
from supple.arrays import FloatArray

STRIDE = 64
"""Interval, in times, of the first pass; each later pass halves it, so it is a power of two."""
AT_ONCE = 64
"""Number of times whose vectors are in memory together."""
ROUNDING = 1e-12
"""Largest relative rounding error of the bound over all times."""


def largest_vector(rows: Matrix, coordinates: FloatArray) -> tuple[float, int]:
    """Largest length of the vectors `R_p q(t)` of a motion, and the index of the time.

        f(q) = max_p |R_p q|,    f(q) <= f(q_k) + sum_j |q - q_k|_j f(e_j)

    because f is a norm; e_j are the unit vectors, and q_k is the motion at an evaluated time. A time is
    evaluated only if its bounds from the nearest evaluated times exceed the largest known value; for a
    vibration, a tenth of the times are evaluated. A vector is left out if its bound over all times,
    |R_p q| <= sum_j |R_p e_j| max_t |q_j|, is below the largest value of the first pass.

    rows : (3 P, r)     the matrices R_p (3, r) of P vectors. If the array is sparse, all times are evaluated:
        with the thousands of coordinates of a full body, the bounds would exclude no time
    coordinates : (t, r)
    """
    if not isinstance(rows, np.ndarray):
        lengths = _lengths(rows, coordinates)
        return float(lengths.max()), int(np.argmax(lengths))
    n_times = len(coordinates)
    vectors = rows.reshape(-1, 3, rows.shape[1])
    unit_lengths = np.sqrt((vectors**2).sum(axis=1))
    of_each = unit_lengths.max(axis=0)
    known = np.arange(0, n_times, STRIDE)
    values = _lengths(rows, coordinates[known])
    longest = unit_lengths @ np.abs(coordinates).max(axis=0)
    rows = vectors[longest * (1 + ROUNDING) >= values.max()].reshape(-1, rows.shape[1])
    stride = STRIDE
    while stride > 1:
        stride //= 2
        new = np.arange(stride, n_times, 2 * stride)
        after = np.searchsorted(known, new)
        bounds = [
            values[own] + np.abs(coordinates[new] - coordinates[known[own]]) @ of_each
            for own in (after - 1, np.minimum(after, len(known) - 1))
        ]
        new = new[np.minimum(*bounds) > values.max()]
        values = np.concatenate([values, _lengths(rows, coordinates[new])])
        known = np.concatenate([known, new])
        in_order = np.argsort(known)
        known, values = known[in_order], values[in_order]
    place = int(np.argmax(values))
    return float(values[place]), int(known[place])


def _lengths(rows: Matrix, coordinates: FloatArray) -> FloatArray:
    """Values (t,) of `f` at some times."""
    found = np.empty(len(coordinates))
    for start in range(0, len(found), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        vectors = (coordinates[part] @ rows.T).reshape(-1, rows.shape[0] // 3, 3)
        found[part] = np.sqrt(np.einsum("tpc,tpc->tp", vectors, vectors).max(axis=1, initial=0.0))
    return found
