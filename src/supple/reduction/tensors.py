"""The internal force of a reduced body as a cubic polynomial with packed symmetric tensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from supple.algebra import ReadOnlyArrays
from supple.algebra.available_memory import available_memory, require_memory
from supple.body.internal_force import LinearForce
from supple.errors import ModelError

if TYPE_CHECKING:
    from supple.body import FlexibleBody
    from supple.fem import QuadraticStrain

__all__ = ["InternalForceTensors", "internal_force_tensors", "unpack_symmetric"]

# Largest work array, bytes. Measured at r = 25 and 60: larger chunks gain nothing, smaller ones are slower.
CHUNK_BYTES = 16 * 2**20

_MATRICES = 16
"""Pair matrices in memory at one time in a reduction, with margin; measured: 11 plain, 14 condensed."""
_MATRICES_OF_DAMPING = 4

# Cosine of the angle between the strains of two pairs, above which the pairs are of one class of symmetry.
SMALLEST_COUPLING = 1e-8


@dataclass(frozen=True, eq=False)
class InternalForceTensors(ReadOnlyArrays):
    """Polynomial internal force of r coordinates, exact for quadratic strains.

        A3 = unpack(cubic @ g),   A4 = unpack(quartic @ m2),   m2_(kl) = g_k g_l for k <= l
        energy  U = g.(K/2 + A3/6 + A4/12) g
        force   f = (K + A3/2 + A4/3) g
        tangent   = K + A3 + A4

    Packed symmetric pairs (j, k), j <= k, are in the order of numpy.triu_indices(r); n2 = r(r+1)/2.

    stiffness : (r, r)
    cubic : (n2, r) or None     cubic[(jk), l] = d3U/dg_j dg_k dg_l at 0
    quartic : (n2, n2) or None  quartic[(jk), (lm)] = d4U/dg_j dg_k dg_l dg_m, halved where l = m
                                (None for both: a linear body)
    `energy`, `internal_force` and `tangent` take gamma (..., r), real or complex (complex-step derivatives).
    Source: [Wu2019] (49), in symmetric storage.
    """

    stiffness: np.ndarray
    cubic: np.ndarray | None = None
    quartic: np.ndarray | None = None

    @property
    def r(self) -> int:
        """Number of coordinates."""
        return self.stiffness.shape[0]

    def energy(self, gamma: ArrayLike) -> np.ndarray:
        """Strain energy (...,), J."""
        gamma, A3, A4 = self._force_matrices(gamma)
        return np.einsum("...j,...jk,...k->...", gamma, self.stiffness / 2 + A3 / 6 + A4 / 12, gamma)

    def internal_force(self, gamma: ArrayLike) -> np.ndarray:
        """Generalised internal force (..., r), the gradient of the energy."""
        gamma, A3, A4 = self._force_matrices(gamma)
        return np.einsum("...jk,...k->...j", self.stiffness + A3 / 2 + A4 / 3, gamma)

    def tangent(self, gamma: ArrayLike) -> np.ndarray:
        """Tangent stiffness (..., r, r), the gradient of the force."""
        _, A3, A4 = self._force_matrices(gamma)
        return self.stiffness + A3 + A4

    def condensed(self, energy: np.ndarray) -> InternalForceTensors:
        """Tensors of the energy U - (1/8) s^T R s: condensed motion releases the second term.

        s_(jk) = gamma_j gamma_k, twice for j < k

        energy : (n2, n2)   R of `Condensation`
        """
        if self.quartic is None:
            return self
        return replace(self, quartic=self.quartic - _fold_quartic(energy, self.r))

    def symmetrized(self) -> InternalForceTensors:
        """Tensors of the same energy, symmetric in all indices, so that the force is the energy's gradient.

        Some published tensors are symmetric in some indices only; the force of such tensors has no potential.
        """
        if self.cubic is None or self.quartic is None:
            return self
        first, second = np.triu_indices(self.r)
        pairs = self.quartic * np.where(first == second, 2.0, 1.0)
        quartic = _fold_quartic((pairs + pairs.T) / 2, self.r) / 3
        return replace(self, cubic=_fold_cubic(self.cubic.T) / 3, quartic=quartic)

    def _force_matrices(self, gamma: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        gamma = np.asarray(gamma)
        if self.cubic is None or self.quartic is None:
            none = np.zeros((*gamma.shape, self.r))
            return gamma, none, none
        first, second = np.triu_indices(self.r)
        products = gamma[..., first] * gamma[..., second]
        A3 = unpack_symmetric(gamma @ self.cubic.T, self.r)
        return gamma, A3, unpack_symmetric(products @ self.quartic.T, self.r)


def number_of_coordinates(n_pairs: int) -> int:
    """Number r of coordinates with n_pairs = r(r+1)/2 packed pairs."""
    return round((np.sqrt(8 * n_pairs + 1) - 1) / 2)


def unpack_symmetric(packed: np.ndarray, r: int) -> np.ndarray:
    """Symmetric matrices (..., r, r) from their packed upper triangles (..., r(r+1)/2)."""
    return packed[..., _pair_number(r)]


@dataclass(frozen=True, eq=False)
class StrainProducts:
    """Inner products, with weights w D, of the strains of a basis; force and damping follow from them.

        eps = e_l g_l + E_jk g_j g_k / 2

    stiffness : (r, r)                  V^T K V = sum w e^T D e
    strain_by_pair : (r, n2) or None    F = sum w e^T D E
    pair_by_pair : (n2, n2) or None     H = sum w E^T D E          (None for both: a linear body)
    """

    stiffness: np.ndarray
    strain_by_pair: np.ndarray | None = None
    pair_by_pair: np.ndarray | None = None

    def internal_force(self) -> InternalForceTensors:
        """Tensors cubic = 3 sym(F), quartic = (3/2) sym(H) with off-diagonal columns doubled."""
        if self.strain_by_pair is None or self.pair_by_pair is None:
            return InternalForceTensors(self.stiffness)
        quartic = _fold_quartic(self.pair_by_pair, len(self.stiffness))
        return InternalForceTensors(self.stiffness, _fold_cubic(self.strain_by_pair), quartic)

    def condensed(self, energy: np.ndarray) -> StrainProducts:
        """The products less those of the strains that the condensed motion removes.

        energy : (n2, n2)   R of `Condensation`: the products of the strains removed by this motion
        """
        if self.pair_by_pair is None:
            return self
        return replace(self, pair_by_pair=self.pair_by_pair - energy)

    def classes(self) -> np.ndarray:
        """Number (n2,) of the symmetry class of each pair; planes of symmetry decouple pairs of two classes.

        The strains of two pairs a, b form an angle with the cosine `H_ab / sqrt(H_aa H_bb)`. Pairs (jk) and
        (lm) are of one class if this cosine exceeds 1e-8 for (jk) and (lm), for (jl) and (km), or for (jm)
        and (kl). Without symmetry there is one class.
        """
        if self.pair_by_pair is None:
            return np.empty(0, dtype=np.int32)
        size = np.sqrt(np.maximum(np.diag(self.pair_by_pair), 0.0))
        coupled = np.abs(self.pair_by_pair) > SMALLEST_COUPLING * size[:, None] * size
        return connected_components(csr_array(_over_pairings(coupled)), directed=False)[1]

    def by_classes(self, classes: np.ndarray) -> StrainProducts:
        """The products with the coupling between classes, which is round-off, set to zero.

        The energy changes by less than 1e-8 of the sum of its terms; the force still has a potential.
        """
        if self.pair_by_pair is None or not np.any(classes):
            return self
        apart = _over_pairings(classes[:, None] != classes)
        return replace(self, pair_by_pair=np.where(apart, 0.0, self.pair_by_pair))

    def material(self, force: InternalForceTensors) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Tensors `cubic` and `quartic` of the material stiffness K_mat(g) = V^T sum w A^T D A V.

            K_mat = K + unpack(cubic @ g) + unpack(quartic @ m2) = (tangent) - unpack(F^T g + H' m2)

        A is the derivative of the strains with respect to q: K_mat(g) g_dot is the force of the stresses
        D eps_dot. H' is H with its columns l = m halved; the last term is the geometric stiffness.

        force : result of `internal_force`
        Returns None for both tensors of a linear body.
        """
        if self.strain_by_pair is None or self.pair_by_pair is None:
            return None, None
        first, second = np.triu_indices(len(self.stiffness))
        once = np.where(first == second, 0.5, 1.0)
        return force.cubic - self.strain_by_pair.T, force.quartic - self.pair_by_pair * once


def internal_force_tensors(body: FlexibleBody, basis: np.ndarray) -> InternalForceTensors:
    """Tensors of the internal force of a body on a basis V: f_r(gamma) = V^T f(V gamma), exactly.

        e_g = B_g V,  a_g = G_g V,  E_g,(jk) = N(a_j, a_k)
        cubic   = 3 sym(sum w E^T D e),   quartic = (3/2) sym(sum w E^T D E), off-diagonal columns doubled

    g counts the integration points. Arguments and errors as for `strain_products`.
    Source: [Wu2019] (49).
    """
    return strain_products(body, basis).internal_force()


def strain_products(body: FlexibleBody, basis: np.ndarray) -> StrainProducts:
    """Inner products of the strains of a basis V, summed over all integration points.

    The strains at every integration point are first computed for the columns of V; the sums over the points
    are then two matrix products for each chunk of elements.

    body : FlexibleBody (coordinates q of length n); for a linear body the stiffness alone
    basis : (n, r)
    Raises ModelError when the basis does not fit the body.
    """
    if basis.ndim != 2 or basis.shape[0] != body.n:
        raise ModelError(
            f"basis of shape {basis.shape} does not fit body '{body.name}' with {body.n} freedoms"
        )
    stiffness = basis.T @ (body.stiffness @ basis)
    stiffness = (stiffness + stiffness.T) / 2
    if isinstance(body.force, LinearForce):
        return StrainProducts(stiffness)
    r = basis.shape[1]
    n2 = r * (r + 1) // 2
    nodal_basis = body.force.expansion @ basis
    strain_by_pair = np.zeros((r, n2))
    pair_by_pair = np.zeros((n2, n2))
    for block in body.force.blocks:
        for chunk in _chunks(block, n2):
            linear, quadratic = _stress_scaled_strains(block, chunk, nodal_basis)
            strain_by_pair += linear.T @ quadratic
            pair_by_pair += quadratic.T @ quadratic
    return StrainProducts(stiffness, strain_by_pair, pair_by_pair)


def _chunks(block: QuadraticStrain, n2: int):
    """Slices of elements whose quadratic strains fit in CHUNK_BYTES."""
    n_elements, n_points, n_strains = block.B.shape[:3]
    # Before packing, pairs (j,k) and (k,j) both exist: hence twice n2.
    size = max(1, CHUNK_BYTES // (8 * n_points * n_strains * 2 * n2))
    return (slice(start, start + size) for start in range(0, n_elements, size))


def _stress_scaled_strains(block: QuadraticStrain, chunk: slice, nodal_basis: np.ndarray):
    """Linear and quadratic strains times sqrt(w D): rows are (point, strain), columns r and r(r+1)/2."""
    part = block.of(chunk)
    columns = nodal_basis[part.dofs]
    root = _square_root(part.D)
    if root.ndim == 3:
        root = root[:, None]  # one matrix per element, shared by its points
    root = np.sqrt(part.w)[:, :, None, None] * root
    r = columns.shape[-1]
    upper = np.ravel_multi_index(np.triu_indices(r), (r, r))
    linear = root @ part.with_enhanced(part.B @ columns[:, None])
    gradients = part.G @ columns[:, None]
    both = np.swapaxes(gradients, -1, -2)[:, :, None] @ (part.N @ gradients[:, :, None])
    packed = both.reshape(*both.shape[:3], r * r)[..., upper]
    quadratic = root @ part.with_enhanced(packed)
    return linear.reshape(-1, r), quadratic.reshape(-1, len(upper))


def _square_root(constitutive: np.ndarray) -> np.ndarray:
    """R with R^T R = D for symmetric D (..., s, s) that may be singular; R has as many rows as the rank of D.

    D of a shell has 18 rows but rank 12: with 18 rows in R, a third of the rows in all sums would be zero.
    """
    values, vectors = np.linalg.eigh(constitutive)
    rank = (values > 1e-14 * values[..., -1:]).sum(axis=-1).max()
    root = np.sqrt(np.maximum(values, 0.0))[..., None] * np.swapaxes(vectors, -1, -2)
    return root[..., -rank:, :]


def _fold_cubic(strain_by_pair: np.ndarray) -> np.ndarray:
    """C3[(jk), l] = F_l,jk + F_j,kl + F_k,jl: the third derivative of (1/2) F_l,jk g_l g_j g_k."""
    r = strain_by_pair.shape[0]
    full = unpack_symmetric(strain_by_pair, r)
    symmetric = full + full.transpose(1, 0, 2) + full.transpose(1, 2, 0)
    first, second = np.triu_indices(r)
    return symmetric[first, second]


def _over_pairings(pairs: np.ndarray) -> np.ndarray:
    """Sum (n2, n2) of a matrix over (jk, lm), (jl, km), (jm, kl); for a boolean matrix, the logical or."""
    pair = _pair_number(number_of_coordinates(len(pairs)))
    j, k = np.triu_indices(len(pair))
    total = pairs.copy()
    size = max(1, CHUNK_BYTES // (24 * max(len(j), 1)))
    for start in range(0, len(j), size):
        rows = slice(start, start + size)
        first, second = pair[j[rows]], pair[k[rows]]
        total[rows] += pairs[first[:, j], second[:, k]]
        total[rows] += pairs[first[:, k], second[:, j]]
    return total


def _fold_quartic(pair_by_pair: np.ndarray, r: int) -> np.ndarray:
    """C4[(jk),(lm)] = H_jk,lm + H_jl,km + H_jm,kl, columns halved where l = m, as in InternalForceTensors."""
    j, k = np.triu_indices(r)
    symmetric = _over_pairings(pair_by_pair)
    symmetric[:, j == k] /= 2
    return symmetric


def _pair_number(r: int) -> np.ndarray:
    """Position (r, r) of the pair (j, k) or (k, j) in the packed order of numpy.triu_indices."""
    number = np.empty((r, r), dtype=np.intp)
    first, second = np.triu_indices(r)
    number[first, second] = number[second, first] = np.arange(len(first))
    return number


def tensor_memory(r: int, *, strain_rate_damping: bool = False) -> int:
    """Largest memory, in bytes, for building the tensors of r coordinates; grows with r⁴."""
    n2 = r * (r + 1) // 2
    return 8 * n2**2 * (_MATRICES + _MATRICES_OF_DAMPING * strain_rate_damping)


def largest_fitting(memory: float, *, strain_rate_damping: bool = False) -> int:
    """Largest number of coordinates whose tensors fit in the given memory (bytes)."""
    r = int((memory / tensor_memory(1, strain_rate_damping=strain_rate_damping) * 4) ** 0.25) + 1
    while r and tensor_memory(r, strain_rate_damping=strain_rate_damping) > memory:
        r -= 1
    return r


def require_tensor_memory(
    body: FlexibleBody, r: int, *, strain_rate_damping: bool = False, named: str = "columns"
) -> None:
    """MemoryShortageError where the tensors of r coordinates of a nonlinear body do not fit in memory.

    named : noun for the r columns in the message, as the user sets their number
    """
    if body.is_linear:
        return
    left = available_memory()
    fits = r if left is None else largest_fitting(left, strain_rate_damping=strain_rate_damping)
    require_memory(
        tensor_memory(r, strain_rate_damping=strain_rate_damping),
        f"building the tensors of body '{body.name}' with {r} coordinates",
        f"take at most {fits} {named}, or the body without its nonlinear strains (body.linearized(), "
        "`linear = true` in a case file), which has no tensors",
    )
