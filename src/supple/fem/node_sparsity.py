"""Node sparsity: pattern and assembly of a matrix whose blocks couple nodes that share a cell."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array, csr_array

IntArray = NDArray[np.integer]
Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class NodeSparsity:
    """A symmetric pattern of full node blocks, in compressed rows (which are also its compressed columns).

    indptr, indices : int32 arrays      compressed pattern, sorted
    scatter : csr_array (blocks, pairs)    sums the node pairs of all cells into the blocks
    order : int32 array (nnz,)    entries of the blocks in compressed order
    """

    indptr: IntArray
    indices: IntArray
    scatter: csr_array
    order: IntArray
    dofs_per_node: int

    def __post_init__(self) -> None:
        for array in (self.indptr, self.indices, self.order):
            array.setflags(write=False)

    @property
    def n_rows(self) -> int:
        """Number of freedoms."""
        return len(self.indptr) - 1

    def data(self, cell_matrices: list[Array]) -> Array:
        """Sum cell matrices (E, k d, k d), in the order of the cells, into the entries (nnz,)."""
        d = self.dofs_per_node
        pairs = [_node_pairs(matrices, d) for matrices in cell_matrices]
        blocks = self.scatter @ (pairs[0] if len(pairs) == 1 else np.concatenate(pairs))
        return np.take(blocks, self.order)

    def data_of_portions(self, portions: Iterable[Array]) -> Array:
        """As `data`, for portions of the cells in sequence, one in memory at a time."""
        d, block_of_pair = self.dofs_per_node, csc_array(self.scatter).indices
        blocks, first = np.zeros((len(self.order) // d**2, d * d)), 0
        for matrices in portions:
            pairs = _node_pairs(matrices, d)
            # One entry per column: the block of each pair. A portion contributes to few blocks.
            reached, own = np.unique(block_of_pair[first : first + len(pairs)], return_inverse=True)
            order = np.arange(len(pairs) + 1)
            blocks[reached] += (
                csc_array((np.ones(len(pairs)), own, order), shape=(len(reached), len(pairs))) @ pairs
            )
            first += len(pairs)
        return np.take(blocks, self.order)

    def matrix(self, data: Array) -> csc_array:
        """Symmetric matrix (n, n) with these entries."""
        return compressed_columns(data, self.indices, self.indptr)


def node_sparsity(cells: Sequence[IntArray], n_nodes: int, dofs_per_node: int) -> NodeSparsity:
    """Pattern of the node pairs in the cells, a list of node arrays (E, k)."""
    if not cells:
        cells = [np.empty((0, 1), dtype=np.int64)]
    keys = np.concatenate([(nodes[:, :, None] * n_nodes + nodes[:, None, :]).ravel() for nodes in cells])
    unique, block = np.unique(keys, return_inverse=True)
    ones = csc_array(
        (np.ones(len(keys)), block.astype(np.int32), np.arange(len(keys) + 1, dtype=np.int32)),
        shape=(len(unique), len(keys)),
    )
    d = dofs_per_node
    row, column = np.divmod(unique, n_nodes)
    row_start = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=n_nodes))])
    entries = np.arange(len(unique) * d * d, dtype=np.int64).reshape(-1, d, d)
    pattern = bsr_array((entries, column, row_start), shape=(n_nodes * d, n_nodes * d)).tocsr()
    return NodeSparsity(
        indptr=pattern.indptr.astype(np.int32),
        indices=pattern.indices.astype(np.int32),
        scatter=ones.tocsr(),
        order=pattern.data.astype(np.int32),
        dofs_per_node=d,
    )


def cell_nodes(dofs: IntArray, dofs_per_node: int) -> IntArray:
    """Nodes (E, k) of elements with freedoms (E, n): all freedoms of each node, or the first 3 of 6."""
    nodes = dofs // dofs_per_node
    return nodes[:, np.flatnonzero(np.append(True, np.diff(nodes[0]) != 0))]


def full_cells(matrices: Array, dofs: IntArray, dofs_per_node: int) -> Array:
    """Element matrices (E, n, n) of freedoms (E, n), expanded to all freedoms of their nodes."""
    own = dofs[0] // dofs_per_node
    node = np.cumsum(np.append(0, np.diff(own) != 0))
    n = (node[-1] + 1) * dofs_per_node
    if n == len(own):
        return matrices
    places = node * dofs_per_node + dofs[0] % dofs_per_node
    full = np.zeros((len(matrices), n, n), dtype=matrices.dtype)
    full[:, places[:, None], places] = matrices
    return full


def compressed_columns(data: Array, indices: IntArray, indptr: IntArray) -> csc_array:
    """Square csc_array on a sorted pattern, shared and not checked again."""
    matrix = csc_array((len(indptr) - 1,) * 2, dtype=data.dtype)
    matrix.data, matrix.indices, matrix.indptr = data, indices, indptr
    matrix.has_sorted_indices = True
    matrix.has_canonical_format = True
    return matrix


def _node_pairs(matrices: Array, d: int) -> Array:
    """Cell matrices (E, k d, k d) as node-pair blocks (E k k, d d)."""
    k = matrices.shape[1] // d
    return matrices.reshape(-1, k, d, k, d).transpose(0, 1, 3, 2, 4).reshape(-1, d * d)
