"""A nodal field over time as a few shapes times amplitudes: proper orthogonal decomposition.

The decomposition applies to every form of a body: a reduced body, also relative to a rotating interface, a
full body, an intrinsic body, elements with plasticity. Shapes are stored once, and amplitudes per time.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray

_SEARCHED = 200
"""Number of times at which the truncation error is measured: those with the largest remainder."""


@dataclass(frozen=True, eq=False)
class NodalShapes:
    """field(t, n) = sum_k amplitudes[t, k] shapes[k, n].

    shapes : (k, N, c)          orthonormal, by descending singular value
    amplitudes : (t, k)
    largest : largest magnitude of the field's components, over all nodes and times
    """

    shapes: FloatArray
    amplitudes: FloatArray
    largest: float

    @property
    def field(self) -> FloatArray:
        """The field, (t, N, c)."""
        return np.tensordot(self.amplitudes, self.shapes, 1)


def nodal_shapes(blocks: Iterable[FloatArray], *, tolerance: float) -> NodalShapes:
    """Shapes and amplitudes that represent a field, given in blocks of times, within a tolerance.

    Each block adds the directions that the existing shapes lack, from the eigenvectors of the Gram matrix of
    the remainder. At the end all shapes are ordered by the singular values of the amplitudes, and the
    smallest are dropped. Each of the two steps uses at most half of the tolerance.

    Parameters
    ----------
    blocks : (t', N, c) each, in the order of time
    tolerance : error of any component at any node and time, relative to the largest component
    """
    rows: list[FloatArray] = []
    shape, basis, largest = (0, 0), np.zeros((0, 0)), 0.0
    for block in blocks:
        shape, flat = block.shape[1:], block.reshape(len(block), -1)
        if not rows:
            basis = np.zeros((0, flat.shape[1]))
        largest = max(largest, float(np.abs(flat).max(initial=0.0)))
        known = flat @ basis.T
        rest = flat - known @ basis
        added = np.linalg.qr(_directions(rest, 0.5 * tolerance * largest).T)[0].T
        # A second projection removes what round-off leaves inside the basis.
        added = np.linalg.qr((added - (added @ basis.T) @ basis).T)[0].T
        basis = np.vstack([basis, added])
        rows.append(np.hstack([known, rest @ added.T]))
    amplitudes = np.zeros((sum(map(len, rows)), len(basis)))
    start = 0
    for part in rows:
        amplitudes[start : start + len(part), : part.shape[1]] = part
        start += len(part)
    basis, amplitudes = _truncated(basis, amplitudes, 0.5 * tolerance * largest)
    return NodalShapes(basis.reshape(-1, *shape), amplitudes, largest)


def _directions(rest: FloatArray, allowed: float) -> FloatArray:
    """The fewest directions (k, m) that represent rest (b, m) with the allowed error in every component."""
    values, vectors = np.linalg.eigh(rest @ rest.T)
    leading = vectors[:, ::-1].T @ rest
    kept = vectors[:, ::-1]

    def left(number: int) -> float:
        return float(np.abs(rest - kept[:, :number] @ leading[:number]).max(initial=0.0))

    return leading[: _fewest(left, len(values), allowed)]


def _truncated(basis: FloatArray, amplitudes: FloatArray, allowed: float) -> tuple[FloatArray, FloatArray]:
    """Shapes in the order of their singular values, without the smallest, and their amplitudes."""
    _, turned = np.linalg.eigh(amplitudes.T @ amplitudes)
    turned = turned[:, ::-1]
    ordered, basis = amplitudes @ turned, turned.T @ basis

    def left(number: int) -> float:
        tail = ordered[:, number:]
        worst = np.argsort(-np.einsum("tk,tk->t", tail, tail))[:_SEARCHED]
        return float(np.abs(tail[worst] @ basis[number:]).max(initial=0.0))

    number = _fewest(left, len(basis), allowed)
    return basis[:number], ordered[:, :number]


def _fewest(left: Callable[[int], float], most: int, allowed: float) -> int:
    """The smallest number with an error `left(number)` of at most `allowed`, by bisection.

    The bisection assumes that the error decreases monotonically.
    """
    if left(0) <= allowed:
        return 0
    return bisect_left(range(most), True, key=lambda number: left(number) <= allowed)
