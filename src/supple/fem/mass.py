"""Mass of the cells: consistent (exact inertia of the meshed volume), or lumped to a diagonal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, kron

from supple.algebra.narrow_indices import narrow_indices
from supple.fem.shell_section import ShellSection

__all__ = ["CellMass"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CellMass:
    """Mass of the cells of one section; translations have the same in every direction.

    Parameters
    ----------
    nodes : int array (E, k)
    translational : float array (E, k, k)       kg
    rotary : float array (E, k, k) or None      kg m^2, on the rotations of shells; m, on those of beams
    rotary_inertia : float array (E, 3, 3) or None
        kg m, of beams: the rotary part couples rotations of nodes a and b by rotary_ab * rotary_inertia; the
        identity (shells) when None
    """

    nodes: NDArray[np.int64]
    translational: FloatArray
    rotary: FloatArray | None = None
    rotary_inertia: FloatArray | None = None

    def lumped(self) -> CellMass:
        """Diagonal mass with the same total: the consistent diagonal, scaled.

        Source: E. Hinton, T. Rock, O. C. Zienkiewicz, "A note on mass lumping", Earthq. Eng. Struct. Dyn. 4
        (1976) 245-249. Unlike row sums it stays positive on quadratic cells.
        """
        rotary = None if self.rotary is None else _scaled_diagonal(self.rotary)
        return CellMass(self.nodes, _scaled_diagonal(self.translational), rotary, self.rotary_inertia)


def shell_mass(corners: FloatArray, nodes: NDArray[np.int64], section: ShellSection) -> CellMass:
    """Consistent mass of shell triangles, with linear shape functions.

        m_ab = (mass per area) A/12 (1 + delta_ab),   and the same with the rotary inertia on all rotations

    The rotary inertia acts on all three rotations: drilling has none physically, but M must be positive
    definite and independent of the element's axes.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(normal, axis=1)
    pattern = area[:, None, None] / 12 * (1 + np.eye(3))
    return CellMass(nodes, section.mass_per_area * pattern, section.rotary_inertia_per_area * pattern)


def mass_matrix(masses: tuple[CellMass, ...], n_nodes: int, dofs_per_node: int) -> csc_array:
    """Mass matrix of all nodal freedoms (n, n), kg and kg m^2; translations and rotations do not couple."""
    translations = np.diag(np.arange(dofs_per_node) < 3).astype(float)
    if not masses:
        return csc_array((n_nodes * dofs_per_node,) * 2)
    matrix = kron(_between_nodes([(m.nodes, m.translational) for m in masses], n_nodes), translations)
    rotary = [(m.nodes, m.rotary) for m in masses if m.rotary is not None and m.rotary_inertia is None]
    if rotary:
        matrix = matrix + kron(_between_nodes(rotary, n_nodes), np.eye(dofs_per_node) - translations)
    beams = [
        (m.nodes, m.rotary, m.rotary_inertia)
        for m in masses
        if m.rotary is not None and m.rotary_inertia is not None
    ]
    for i, j in np.ndindex(3, 3) if beams else ():
        parts = [(nodes, values * inertia[:, i, j, None, None]) for nodes, values, inertia in beams]
        place = coo_array(([1.0], ([3 + i], [3 + j])), shape=(6, 6))
        matrix = matrix + kron(_between_nodes(parts, n_nodes), place)
    return narrow_indices(csc_array(matrix))


def _between_nodes(parts: list[tuple[NDArray[np.int64], FloatArray]], n_nodes: int) -> csc_array:
    rows = np.concatenate([np.repeat(nodes, nodes.shape[1], axis=1).ravel() for nodes, _ in parts])
    columns = np.concatenate([np.tile(nodes, nodes.shape[1]).ravel() for nodes, _ in parts])
    data = np.concatenate([values.ravel() for _, values in parts])
    return coo_array((data, (rows, columns)), shape=(n_nodes, n_nodes)).tocsc()


def _scaled_diagonal(mass: FloatArray) -> FloatArray:
    diagonal = np.einsum("ekk->ek", mass)
    scaled = diagonal * (mass.sum(axis=(1, 2)) / diagonal.sum(axis=1))[:, None]
    return scaled[:, :, None] * np.eye(mass.shape[1])
