"""The quartic tensor as its nonzero blocks of pairs; zeros result from symmetry or a truncated energy.

If a body has planes of symmetry, every shape is even or odd in each plane. A term of the strain energy that
is odd in a plane is zero. The packed products `g_l g_m` therefore fall into classes: two for one plane, four
for two planes. The matrix of pairs couples no two classes. Zero blocks are neither stored nor multiplied:
with two planes a quarter of the matrix remains. Without symmetry there is one class. Rows of a class with
nonzero entries in few columns form a block of only these columns, for example after `second_order_beyond`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from supple.arrays import BoolArray, FloatArray
from supple.reduction.tensors import number_of_coordinates

Indices = NDArray[np.intp]

_LARGEST_SHARE = 0.75
"""Ratio of the entries in the parts of a matrix, or of a block, to all entries; above it, it is not split."""
_FEWEST_PAIRS = 100
"""Smallest number of pairs of a matrix that is split; below it, splitting costs more than it saves."""
_SMALLEST_BLOCK = 16
"""Smallest number of rows of a part of a split block; smaller classes are merged into one block."""


class PairBlocks(NamedTuple):
    """Blocks of a matrix Q (n2, n2) of packed pairs.

    The product `Q m2`, with `m2_(lm) = g_l g_m`, is unpacked to (r, r).
    """

    first: tuple[NDArray[np.int32], ...]
    """(c_b,) for each block: the coordinate l of the pair (l, m) of every column"""
    second: tuple[NDArray[np.int32], ...]
    """(c_b,) for each block: the coordinate m of the pair (l, m) of every column"""
    matrices: tuple[FloatArray, ...]
    """(n_b, c_b) for each block: its entries"""
    position: NDArray[np.int32]
    """(r, r): position of each pair in the concatenated products of all blocks; a pair without a block has
    the position of a zero appended to these products"""


def pair_blocks(packed: FloatArray) -> FloatArray | PairBlocks:
    """Nonzero blocks of a matrix (n2, n2) of packed pairs; the matrix itself if small or mostly nonzero."""
    n2 = len(packed)
    if n2 < _FEWEST_PAIRS:
        return packed
    present = packed != 0
    blocks = [part for members in _coupled(present) for part in _by_columns(present, members, members)]
    if sum(rows.size * columns.size for rows, columns in blocks) > _LARGEST_SHARE * n2**2:
        return packed
    r = number_of_coordinates(n2)
    ordered = np.concatenate([*(rows for rows, _ in blocks), np.arange(0)])
    number = np.full(n2, len(ordered), dtype=np.int32)
    number[ordered] = np.arange(len(ordered))
    first, second = (side.astype(np.int32) for side in np.triu_indices(r))
    position = np.empty((r, r), dtype=np.int32)
    position[first, second] = position[second, first] = number
    return PairBlocks(
        tuple(first[columns] for _, columns in blocks),
        tuple(second[columns] for _, columns in blocks),
        tuple(packed[np.ix_(rows, columns)] for rows, columns in blocks),
        position,
    )


def _coupled(present: BoolArray) -> list[Indices]:
    """Classes of pairs coupled by the matrix, small ones merged; pairs of zero rows and columns left out."""
    alone = ~(present.any(axis=0) | present.any(axis=1))
    _, label = connected_components(csr_array(present), directed=False)
    label[alone] = -1
    sizes = np.bincount(label[~alone])
    blocks = [np.flatnonzero(label == i) for i in np.flatnonzero(sizes >= _SMALLEST_BLOCK)]
    rest = np.flatnonzero(~alone & (sizes[label] < _SMALLEST_BLOCK)) if sizes.size else np.arange(0)
    return [*blocks, rest] if rest.size else blocks


def _by_columns(present: BoolArray, rows: Indices, columns: Indices) -> list[tuple[Indices, Indices]]:
    """(rows, columns) of the parts of a block, split recursively while the parts have few enough entries."""
    own = present[np.ix_(rows, columns)]
    ascending = np.argsort(own.sum(axis=1), kind="stable")
    used = own[ascending]
    # Numbers of columns with nonzero entries in the first k rows, and in the other rows.
    of_first = np.logical_or.accumulate(used).sum(axis=1)[:-1]
    of_others = np.logical_or.accumulate(used[::-1]).sum(axis=1)[-2::-1]
    n_first = np.arange(1, len(rows))
    sizes = n_first * of_first + (len(rows) - n_first) * of_others
    large = slice(_SMALLEST_BLOCK - 1, len(rows) - _SMALLEST_BLOCK)
    if not sizes[large].size or sizes[large].min() > _LARGEST_SHARE * own.size:
        return [(rows, columns)]
    parts = np.split(ascending, [int(sizes[large].argmin()) + _SMALLEST_BLOCK])
    return [
        block
        for part in map(np.sort, parts)
        for block in _by_columns(present, rows[part], columns[own[part].any(axis=0)])
    ]
