"""Mass of the cells: consistent (exact inertia of the meshed volume), or lumped to a diagonal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, kron

from supple.algebra.cross import cross_matrices
from supple.algebra.narrow_indices import narrow_indices
from supple.arrays import FloatArray
from supple.fem.shell_section import ShellSection

__all__ = ["CellMass", "consistent_mass"]


@dataclass(frozen=True, eq=False)
class CellMass:
    """Mass of the cells of one section; translational mass is the same in every direction.

    Parameters
    ----------
    nodes : int array (E, k)
    translational : float array (E, k, k)       kg
    rotary : float array (E, k, k) or None      kg m^2, the same for all rotations, as in shells
    coupled : float array (E, 6 k, 6 k) or None
            remaining terms, in all freedoms of the nodes: rotary inertia of beams, eccentric mass; kg, kg m
            and kg m^2
    nodal : float array (E, k, 6, 6) or None
            the whole mass of each node after lumping, which `lumped` then uses; None: `lumped` sums rows
    """

    nodes: NDArray[np.int64]
    translational: FloatArray
    rotary: FloatArray | None = None
    coupled: FloatArray | None = None
    nodal: FloatArray | None = None

    def lumped(self) -> CellMass:
        """Lumped mass with equal total: the diagonal of the consistent mass, scaled.

        Source: E. Hinton, T. Rock, O. C. Zienkiewicz, "A note on mass lumping", Earthq. Eng. Struct. Dyn. 4
        (1976) 245-249. Unlike row sums, this mass is positive on quadratic cells. Coupled terms are summed
        by rows into one symmetric 6 x 6 block per node, which need not be diagonal.
        """
        if self.nodal is not None:
            own, coupled = self.nodal[:, :, 0, 0], self.nodal.copy()
            coupled[..., range(3), range(3)] -= own[..., None]
            return CellMass(self.nodes, _diagonal(own), coupled=_block_diagonal(coupled))
        rotary = None if self.rotary is None else _scaled_diagonal(self.rotary)
        coupled = None if self.coupled is None else _at_nodes(self.coupled)
        return CellMass(self.nodes, _scaled_diagonal(self.translational), rotary, coupled)


def consistent_mass(mass: CellMass) -> CellMass:
    """The mass unchanged: the mass rule for consistent mass; the alternative is `CellMass.lumped`."""
    return mass


def shell_mass(
    corners: FloatArray,
    nodes: NDArray[np.int64],
    section: ShellSection,
    mass_share: FloatArray | None = None,
) -> CellMass:
    """Consistent mass of shell triangles, with linear shape functions.

        m_ab = (mass per area) A/12 (1 + delta_ab),   and the same with the rotary inertia on all rotations

    The rotary inertia about the mass centre acts on all three rotations: drilling has none physically, but M
    must be positive definite and independent of the element's axes. An eccentric mass centre couples
    translations and rotations. mass_share (E,): the fraction of the area that has mass; None for all.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normal, axis=1)
    covered = area if mass_share is None else mass_share * area
    pattern = covered[:, None, None] / 12 * (1 + np.eye(3))
    mass, offset = section.mass_per_area, section.mass_offset
    about_centre = section.rotary_inertia_per_area - mass * offset**2
    coupled = None
    if mass and offset:
        arm = cross_matrices(normal * (offset / (2 * area))[:, None])
        block = np.zeros((len(nodes), 6, 6))
        block[:, :3, 3:], block[:, 3:, :3], block[:, 3:, 3:] = -arm, arm, -arm @ arm
        coupled = (mass * pattern[:, :, None, :, None] * block[:, None, :, None]).reshape(-1, 18, 18)
    return CellMass(nodes, mass * pattern, about_centre * pattern, coupled)


def nodal_mass_matrix(masses: tuple[CellMass, ...], n_nodes: int, dofs_per_node: int) -> csc_array:
    """Mass matrix of all nodal freedoms (n, n), kg, kg m and kg m^2."""
    translations = np.diag(np.arange(dofs_per_node) < 3).astype(float)
    if not masses:
        return csc_array((n_nodes * dofs_per_node,) * 2)
    matrix = kron(_between_nodes([(m.nodes, m.translational) for m in masses], n_nodes), translations)
    rotary = [(m.nodes, m.rotary) for m in masses if m.rotary is not None]
    if rotary:
        matrix = matrix + kron(_between_nodes(rotary, n_nodes), np.eye(dofs_per_node) - translations)
    coupled = [
        ((6 * m.nodes[:, :, None] + np.arange(6)).reshape(len(m.nodes), -1), m.coupled)
        for m in masses
        if m.coupled is not None
    ]
    if coupled:
        more = _between_nodes(coupled, 6 * n_nodes)
        more.eliminate_zeros()
        matrix = matrix + more
    return narrow_indices(csc_array(matrix))


def _between_nodes(parts: list[tuple[NDArray[np.int64], FloatArray]], n_nodes: int) -> csc_array:
    """Sparse sum (n_nodes, n_nodes) of the cell matrices (E, k, k) between nodes (E, k)."""
    rows = np.concatenate([np.repeat(nodes, nodes.shape[1], axis=1).ravel() for nodes, _ in parts])
    columns = np.concatenate([np.tile(nodes, nodes.shape[1]).ravel() for nodes, _ in parts])
    data = np.concatenate([values.ravel() for _, values in parts])
    return coo_array((data, (rows, columns)), shape=(n_nodes, n_nodes)).tocsc()


def _scaled_diagonal(mass: FloatArray) -> FloatArray:
    diagonal = np.einsum("ekk->ek", mass)
    total, own = mass.sum(axis=(1, 2)), diagonal.sum(axis=1)
    # Both sums are zero in cells without density.
    return _diagonal(diagonal * np.divide(total, own, out=np.zeros_like(total), where=own != 0)[:, None])


def _diagonal(given: FloatArray) -> FloatArray:
    return given[:, :, None] * np.eye(given.shape[1])


def _at_nodes(coupled: FloatArray) -> FloatArray:
    """Row sums (6, 6) of each node, symmetrised, of matrices (E, 6 k, 6 k)."""
    k = coupled.shape[1] // 6
    sums = coupled.reshape(-1, k, 6, k, 6).sum(axis=3)
    return _block_diagonal(0.5 * (sums + sums.swapaxes(2, 3)))


def _block_diagonal(blocks: FloatArray) -> FloatArray:
    """Matrices (E, 6 k, 6 k) with the blocks (E, k, 6, 6) on their diagonals."""
    n, k = blocks.shape[:2]
    alone = np.zeros((n, k, 6, k, 6))
    each = np.arange(k)
    alone[:, each, :, each] = blocks.swapaxes(0, 1)
    return alone.reshape(n, 6 * k, 6 * k)
