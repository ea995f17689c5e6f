"""Assembly: energy, force, tangent and their derivatives of a whole model, in reduced freedoms u = T q."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, eye_array

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import quadratic_strain
from supple.fem.model import FiniteElementModel
from supple.fem.node_sparsity import (
    NodeSparsity,
    cell_nodes,
    compressed_columns,
    full_cells,
    node_sparsity,
)
from supple.fem.quadratic_strain import QuadraticStrain

__all__ = ["Assembly", "StrainWorks", "assemble", "assemble_strains"]

Array = NDArray[Any]
IntArray = NDArray[np.integer]
# Any scipy.sparse array: their common base declares no shape.
SparseArray = Any

# Numbers in memory at once while many elements are evaluated: 2 MiB, within a processor's cache.
CHUNK = 2**18
# Factor on CHUNK for `works`: in a larger portion more elements share a node, whose force is projected once.
LARGER_FOR_WORKS = 4


class StrainWorks(NamedTuple):
    """Work of each term of the internal force at q = X g on k directions z, X with m columns x_j.

    w, B, D, N, G as in supple.fem.quadratic_strain; p pairs j <= l in the order of numpy.triu_indices(m).

    linear : (k, p)     sum w (B z)^T D N(G x_j, G x_l)
    turned : (k, m, m)  sum w N(G z, G x_j)^T D B x_l
    cubic : (m, k, p)   sum w N(G z, G x_i)^T D N(G x_j, G x_l)
    """

    linear: FloatArray
    turned: FloatArray
    cubic: FloatArray


class _Portion(NamedTuple):
    """Some elements of a block, along m directions."""

    block: QuadraticStrain
    directions: FloatArray
    """(e, n_e, m): the directions in the n_e freedoms of each of e elements"""
    reached: IntArray
    """Numbers of the freedoms q on which these elements depend"""
    to_reached: SparseArray
    """(freedoms reached, e n_e): sums element forces into the forces on these freedoms"""

    def summed(self, forces: FloatArray) -> FloatArray:
        """Sums of element forces (e, n_e, p) on the freedoms `reached`: (freedoms reached, p)."""
        return self.to_reached @ forces.reshape(-1, forces.shape[-1])


@dataclass(frozen=True, eq=False)
class Assembly:
    """Sums over the elements of a body, prepared once for one expansion T (nodal freedoms u = T q).

    Every matrix has the same sparsity (`indices`, `indptr`, symmetric) for all q. Forces, energies and
    tangents accept complex q.

    Parameters
    ----------
    blocks : tuple of QuadraticStrain           the elements, in nodal freedoms
    gathers : tuple of csr_array (E n_e, n)     freedoms of all elements of a block from q
    nodal : NodeSparsity                        sparsity of the matrices of the nodal freedoms
    transform : csr_array (nnz, nodal nnz) or None      entries of T^T K T from those of K; None when T = 1
    indices, indptr : int32 arrays              compressed columns of the matrices (n, n)
    """

    blocks: tuple[QuadraticStrain, ...]
    gathers: tuple[csr_array, ...]
    nodal: NodeSparsity
    transform: csr_array | None
    indices: IntArray
    indptr: IntArray

    def __post_init__(self) -> None:
        # All matrices share these arrays.
        self.indices.setflags(write=False)
        self.indptr.setflags(write=False)

    @property
    def n(self) -> int:
        """Number of freedoms q."""
        return len(self.indptr) - 1

    def energy(self, q: Array) -> np.number:
        """Strain energy U(q), J."""
        return self.energies(q[:, None])[0]

    def energies(self, Q: Array) -> Array:
        """Strain energies (t,), J, of every column of Q (n, t)."""
        t = Q.shape[1]
        total = np.zeros(t, dtype=np.result_type(Q, np.float64))
        for block, gather in zip(self.blocks, self.gathers, strict=True):
            n_elements, n_points, s, n_e = block.B.shape
            each = (n_points * (s + 5 * block.G.shape[2]) + n_e) * t
            for elements in _ranges(n_elements, each):
                own = (gather[elements.start * n_e : elements.stop * n_e] @ Q).reshape(-1, n_e, t)
                total += quadratic_strain.energies(block.of(elements), own).sum(axis=0)
        return total

    def internal_force(self, q: Array) -> Array:
        """Internal force dU/dq (n,), N and N m."""
        forces = self._over_elements(quadratic_strain.internal_force, q)
        return np.sum([gather.T @ f.ravel() for gather, f in zip(self.gathers, forces, strict=True)], axis=0)

    def strain_rate_force(self, q: Array, rates: Array) -> Array:
        """Force K_mat(q) q_dot (n,) of the stresses D eps_dot, q_dot = `rates`; zero in a rigid motion."""
        forces = self._over_elements(quadratic_strain.strain_rate_force, q, rates)
        return np.sum([gather.T @ f.ravel() for gather, f in zip(self.gathers, forces, strict=True)], axis=0)

    def strain_rate_tangent(self, q: Array, rates: Array) -> csr_array:
        """Derivative (n, n) of `strain_rate_force` with respect to q, at constant rates; not symmetric."""
        # Transposed, because entries in row order are read by columns, on a symmetric pattern.
        return self._matrix(self._over_elements(quadratic_strain.strain_rate_tangent, q, rates)).T

    def tangent(self, q: Array, *, material: float = 1.0) -> csc_array:
        """Tangent stiffness (n, n), the derivative of the internal force.

        material : a factor on all but the geometric term
        """
        return self._matrix(self._over_elements(partial(quadratic_strain.tangent, material=material), q))

    def tangent_parts(self, q: Array) -> tuple[csc_array, csc_array]:
        """The material and the geometric term of the tangent (n, n), from one evaluation."""
        both = self._over_elements(quadratic_strain.tangent_parts, q)
        material, geometric = (self._matrix([each[:, number] for each in both]) for number in (0, 1))
        return material, geometric

    def tangent_derivative(self, x: Array) -> csc_array:
        """Derivative of the tangent at q = 0 in the direction x (n,), exact; (n, n)."""
        return self._matrix(self._over_elements(quadratic_strain.tangent_derivative, x))

    def pair_forces(self, X: FloatArray) -> FloatArray:
        """Second derivative of the internal force at q = 0 along all pairs of columns of X (n, m).

        Returns
        -------
        float array (n, m(m+1)/2)   f''(x_j, x_k), exact, j <= k in the order of numpy.triu_indices(m)
        """
        m = X.shape[1]
        forces = np.zeros((self.n, m * (m + 1) // 2))
        for own in self._along(X, lambda block: _pair_numbers(block, m, forces.shape[1])):
            forces[own.reached] += own.summed(quadratic_strain.pair_forces(own.block, own.directions))
        return forces

    def works(self, X: FloatArray, onto: FloatArray) -> StrainWorks:
        """Work of each term of the internal force at q = X g, X (n, m), on the columns of `onto` (n, k)."""
        m, k = X.shape[1], onto.shape[1]
        n_pairs = m * (m + 1) // 2
        linear, turned = np.zeros((k, n_pairs)), np.zeros((m, k, m))
        cubic = np.zeros((m, k, n_pairs))
        sums = (linear, *turned, *cubic)

        def numbers(block: QuadraticStrain) -> int:
            _, n_points, s, n_e = block.B.shape
            return n_points * s * (n_pairs + m * n_e) + n_e * n_pairs

        for own in self._along(X, numbers, larger=LARGER_FOR_WORKS):
            seen = onto[own.reached].T
            parts = quadratic_strain.force_parts(own.block, own.directions)
            for total, part in zip(sums, parts, strict=True):
                np.add(total, seen @ own.summed(part), out=total)
        return StrainWorks(linear, turned.swapaxes(0, 1), cubic)

    def strain_pair_forces(self, X: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
        """Forces of the quadratic strain of pairs of columns of X, in the undeformed geometry.

            f_p = sum w B^T D N(G x_first(p), G x_second(p))

        Parameters
        ----------
        X : (n, m)
        first, second : (p,)    columns of X

        Returns
        -------
        float array (n, p)      self-equilibrated: a rigid motion has no linear strain
        """
        m, n_pairs = X.shape[1], len(first)
        forces = np.zeros((self.n, n_pairs))
        for own in self._along(X, lambda block: _pair_numbers(block, m, n_pairs)):
            pairs = quadratic_strain.strain_pair_forces(own.block, own.directions, first, second)
            forces[own.reached] += own.summed(pairs)
        return forces

    @cached_property
    def _portions(self) -> tuple[tuple[QuadraticStrain, ...], ...]:
        """The elements of each block in portions whose matrices fit a processor's cache."""
        portions = []
        for block in self.blocks:
            n_elements, n_points, s, n_e = block.B.shape
            d = block.G.shape[2]
            each = (n_points * (s + d) + n_e) * (n_e + d)
            portions.append(tuple(block.of(elements) for elements in _ranges(n_elements, each)))
        return tuple(portions)

    def _along(
        self, X: FloatArray, numbers: Callable[[QuadraticStrain], int], *, larger: int = 1
    ) -> Iterator[_Portion]:
        """All elements in portions, with the columns of X (n, m) in their freedoms.

        `numbers` gives the storage per element of a block, as a count of numbers.
        """
        for block, gather in zip(self.blocks, self.gathers, strict=True):
            n_elements, _, _, n_e = block.B.shape
            for elements in _ranges(n_elements, numbers(block), larger):
                rows = gather[elements.start * n_e : elements.stop * n_e]
                reached = np.unique(rows.indices)
                directions = (rows @ X).reshape(-1, n_e, X.shape[1])
                yield _Portion(block.of(elements), directions, reached, rows[:, reached].T)

    def _over_elements(self, evaluate: Callable[..., Array], *vectors: Array) -> list[Array]:
        """Values (E, ...) of all elements of each block, from their freedoms (E, n_e) in each vector (n,)."""
        values = []
        for block, portions, gather in zip(self.blocks, self._portions, self.gathers, strict=True):
            ends = np.cumsum([len(portion.dofs) for portion in portions])
            own = [np.split((gather @ x).reshape(block.dofs.shape), ends[:-1]) for x in vectors]
            pieces = zip(portions, ends, *own, strict=True)
            values.append(_stacked(((evaluate(portion, *x), end) for portion, end, *x in pieces), ends[-1]))
        return values

    def _matrix(self, cell_matrices: list[Array]) -> csc_array:
        d = self.nodal.dofs_per_node
        pairs = zip(cell_matrices, self.blocks, strict=True)
        data = self.nodal.data([full_cells(matrices, block.dofs, d) for matrices, block in pairs])
        if self.transform is not None:
            data = self.transform @ data
        return compressed_columns(data, self.indices, self.indptr)


def assemble(model: FiniteElementModel, expansion: SparseArray | None = None) -> Assembly:
    """Prepare the sums over the elements of a model.

    Parameters
    ----------
    expansion : sparse array (n_nodal, n) or None
            T of u = T q; an empty row fixes its freedom, a row of several entries ties it (rigid interfaces);
            the identity when None

    Raises
    ------
    ModelError   expansion with a wrong number of rows
    """
    if expansion is not None and expansion.shape[0] != model.n_dofs:
        raise ModelError(
            f"expansion has {expansion.shape[0]} rows; the model has {model.n_dofs} nodal freedoms: give one "
            "row for each"
        )
    return assemble_strains(model.strains, model.mesh.n_nodes, model.dofs_per_node, expansion)


def assemble_strains(
    blocks: tuple[QuadraticStrain, ...],
    n_nodes: int,
    dofs_per_node: int,
    expansion: SparseArray | None = None,
) -> Assembly:
    """Prepare the sums over the elements of `blocks`, whose freedoms are numbered node by node.

    expansion : as for `assemble`, of n_nodes * dofs_per_node rows
    """
    cells = [cell_nodes(block.dofs, dofs_per_node) for block in blocks]
    nodal = node_sparsity(cells, n_nodes, dofs_per_node)
    if expansion is None:
        T = csr_array(eye_array(n_nodes * dofs_per_node))
        transform, indices, indptr = None, nodal.indices, nodal.indptr
    else:
        T = csr_array(expansion)
        transform, indices, indptr = _congruence(nodal, T)
    gathers = tuple(T[block.dofs.ravel()] for block in blocks)
    return Assembly(blocks, gathers, nodal, transform, indices, indptr)


def _congruence(nodal: NodeSparsity, T: SparseArray) -> tuple[csr_array, IntArray, IntArray]:
    """Pattern of T^T K T, and the map from the entries of K to those of T^T K T.

    Entry (a, b) of K adds T_ai T_bj K_ab to entry (i, j), for all entries i of row a of T and j of row b.
    """
    row = np.repeat(np.arange(nodal.n_rows), np.diff(nodal.indptr))
    in_row = np.diff(T.indptr)
    count = in_row[row] * in_row[nodal.indices]
    source = np.repeat(np.arange(len(row)), count)
    turn = np.arange(len(source)) - np.repeat(np.cumsum(count) - count, count)
    a, b = row[source], nodal.indices[source]
    left, right = np.divmod(turn, in_row[b])
    left, right = left + T.indptr[a], right + T.indptr[b]
    columns, n = T.indices.astype(np.int64), T.shape[1]
    keys, target = np.unique(columns[left] * n + columns[right], return_inverse=True)
    i, j = np.divmod(keys, n)
    indptr = np.concatenate([[0], np.cumsum(np.bincount(i, minlength=n))]).astype(np.int32)
    values = T.data[left] * T.data[right]
    transform = csr_array((values, (target, source)), shape=(len(keys), len(row)))
    return transform, j.astype(np.int32), indptr


def _stacked(pieces: Iterable[tuple[Array, int]], n: int) -> Array:
    """Arrays (e, ...), each given with the row where it ends, copied into one array of n rows.

    A concatenation would store all of them at once: twice the memory, which costs more than the arithmetic.
    """
    stacked = None
    for piece, end in pieces:
        if stacked is None:
            stacked = np.empty((n, *piece.shape[1:]), dtype=piece.dtype)
        stacked[end - len(piece) : end] = piece
    assert stacked is not None
    return stacked


def _pair_numbers(block: QuadraticStrain, m: int, n_pairs: int) -> int:
    """Storage (numbers) per element for the forces of pairs of m directions."""
    _, n_points, s, n_e = block.B.shape
    d = block.G.shape[2]
    return n_points * (s + d) * (d + 3 * m) + n_e * n_pairs


def _ranges(n_elements: int, each: int, larger: int = 1) -> Iterator[slice]:
    """Slices of elements, of about `larger * CHUNK` numbers each; an element stores `each` numbers."""
    bounds = np.append(np.arange(0, n_elements, max(1, larger * CHUNK // each)), n_elements)
    return (slice(first, last) for first, last in pairwise(bounds))
