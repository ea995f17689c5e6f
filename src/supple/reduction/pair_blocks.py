"""The quartic tensor as those blocks of pairs that the symmetries of a body leave nonzero.

In a body with planes of symmetry every shape is even or odd in each of them. A term of the strain energy that
is odd as a whole is zero, so that the packed products `g_l g_m` fall into classes, two for one plane and four
for two, and the matrix of pairs does not couple them. Zero blocks are neither stored nor multiplied: with two
planes a quarter remains. A body without symmetry has one block, the matrix itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from supple.reduction.tensors import number_of_coordinates

__all__ = ["PairBlocks", "pair_blocks"]

Array = NDArray[np.float64]

_LARGEST_SHARE = 0.75
"""Largest share of the matrix in its blocks; above it the order of the pairs is left unchanged."""
_FEWEST_PAIRS = 100
"""Smallest matrix that is split: below it, the overhead of a product exceeds the saving."""
_SMALLEST_BLOCK = 16
"""Smallest number of pairs in a block; smaller classes are merged, for the same reason."""


class PairBlocks(NamedTuple):
    """Blocks of a matrix Q (n2, n2) of packed pairs; `Q m2`, `m2_(lm) = g_l g_m`, is unpacked to (r, r)."""

    first: tuple[NDArray[np.int32], ...]
    """(n_b,) the coordinate l of every pair of a block"""
    second: tuple[NDArray[np.int32], ...]
    """(n_b,) the coordinate m of every pair"""
    matrices: tuple[Array, ...]
    """(n_b, n_b)"""
    position: NDArray[np.int32]
    """(r, r): position of each pair in the concatenated products of all blocks, which end with a zero"""


def pair_blocks(packed: Array) -> Array | PairBlocks:
    """Nonzero blocks of a matrix (n2, n2) of packed pairs; the matrix itself where zero blocks are few."""
    n2 = len(packed)
    if n2 < _FEWEST_PAIRS:
        return packed
    blocks = _coupled(packed)
    if sum(len(block) ** 2 for block in blocks) > _LARGEST_SHARE * n2**2:
        return packed
    r = number_of_coordinates(n2)
    ordered = np.concatenate([*blocks, np.arange(0)])
    number = np.full(n2, len(ordered), dtype=np.int32)
    number[ordered] = np.arange(len(ordered))
    first, second = (side.astype(np.int32) for side in np.triu_indices(r))
    position = np.empty((r, r), dtype=np.int32)
    position[first, second] = position[second, first] = number
    return PairBlocks(
        tuple(first[block] for block in blocks),
        tuple(second[block] for block in blocks),
        tuple(packed[np.ix_(block, block)] for block in blocks),
        position,
    )


def _coupled(packed: Array) -> list[NDArray[np.intp]]:
    """Classes of pairs that the matrix couples, small ones merged; all-zero pairs belong to none."""
    present = packed != 0
    alone = ~(present.any(axis=0) | present.any(axis=1))
    _, label = connected_components(csr_array(present), directed=False)
    label[alone] = -1
    sizes = np.bincount(label[~alone])
    blocks = [np.flatnonzero(label == i) for i in np.flatnonzero(sizes >= _SMALLEST_BLOCK)]
    rest = np.flatnonzero(~alone & (sizes[label] < _SMALLEST_BLOCK)) if sizes.size else np.arange(0)
    return [*blocks, rest] if rest.size else blocks
