"""Strain points of explicit solid elements at rest: gradients, hourglass vectors, stable steps.

Tetrahedra use the points of the quadratic strains. The hexahedron has one point, with the gradient averaged
over its volume: its volume change is then exact. Hourglass control resists the remaining modes by vectors

    gamma_a = h_a - sum_i (h_a . X_i) b_i,      a = xi eta, eta zeta, zeta xi, xi eta zeta

with the corner pattern h_a and the mean gradient b. gamma_a is orthogonal to every affine motion. So the
amplitudes gamma_a . x rotate with the element, and their energy 1/2 kappa |gamma_a . x|^2 is invariant under
rotations.

Source: D. P. Flanagan, T. Belytschko, "A uniform strain hexahedron and quadrilateral with orthogonal
hourglass control", Int. J. Numer. Methods Eng. 17 (1981) 679-706.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import FiniteElementModel, Isotropic, QuadraticStrain
from supple.fem.section import Section
from supple.mesh import CellType
from supple.mesh.reference_cell import reference_nodes

__all__ = ["SolidPoints", "element_limits", "hourglass_stiffness", "solid_points"]


@dataclass(frozen=True, eq=False)
class SolidPoints:
    """Strain points of E elements of k nodes with g points.

    nodes : int (E, k);   gradients : (E, g, 3, k), 1/m;   volumes : (E, g), m^3
    gamma : (E, 4, k)     hourglass vectors; (E, 0, k) for elements without hourglass modes
    """

    nodes: NDArray[np.int64]
    gradients: FloatArray
    volumes: FloatArray
    gamma: FloatArray


def solid_points(model: FiniteElementModel, section: Section, block: QuadraticStrain) -> SolidPoints:
    """The points of one section; ModelError for cells without an explicit element."""
    kind, nodes = section.cell_type, section.nodes(model.mesh)
    if kind not in (CellType.TETRA4, CellType.TETRA10, CellType.HEXA8):
        raise ModelError(
            f"{kind.name} has no explicit element: use TETRA4, TETRA10 or HEXA8, and "
            "explicit_shell for TRIANGLE3"
        )
    gradients, volumes = block.G[:, :, :3, ::3], block.w
    gamma = np.zeros((len(nodes), 0, nodes.shape[1]))
    if kind is CellType.HEXA8:
        total = volumes.sum(axis=1, keepdims=True)
        gradients = (gradients * (volumes / total)[:, :, None, None]).sum(axis=1, keepdims=True)
        volumes = total
        xi, eta, zeta = reference_nodes(kind).T
        patterns = np.stack([xi * eta, eta * zeta, zeta * xi, xi * eta * zeta])
        along = "ak,eki,eil->eal"
        gamma = patterns - np.einsum(
            along, patterns, section.corners(model.mesh), gradients[:, 0], optimize=True
        )
    return SolidPoints(nodes, gradients, volumes, gamma)


def hourglass_stiffness(points: SolidPoints, elastic: Isotropic, hourglass: float) -> FloatArray:
    """Stiffness kappa (E,), N/m: kappa |gamma|^2 is `hourglass` times (lambda + 2 mu) V |b|^2 / 3."""
    b = (points.gradients[:, 0] ** 2).sum(axis=(1, 2)) / 3
    norm = (points.gamma**2).sum(axis=2).max(axis=1, initial=0.0)
    free = np.where(norm > 0, norm, 1.0)
    return hourglass * elastic.elasticity[0, 0] * points.volumes.sum(axis=1) * b / free


def element_limits(
    points: SolidPoints, masses: FloatArray, elastic: Isotropic, hourglass: FloatArray
) -> FloatArray:
    """2 / omega_max of each element at rest, (E,), s.

        omega_max(M, K) <= max_e omega_max(M_e, K_e)

    No mode of a mesh is faster than the fastest of its single elements (Irons and Treharne 1971). The largest
    eigenvalue of an element is exact, from A A^T with A = sqrt(V) D^(1/2) B M_e^(-1/2), six rows per strain
    point; the hourglass stiffness adds at most its own eigenvalue.

    masses : (E, k) lumped, kg;   hourglass : (E,) kappa, N/m
    """
    root = np.linalg.cholesky(elastic.elasticity).T
    g = points.gradients / np.sqrt(masses)[:, None, None, :]
    E, n_points, _, k = g.shape
    B = np.zeros((E, n_points, 6, k, 3))
    for i in range(3):
        B[:, :, i, :, i] = g[:, :, i]
    for row, (i, j) in enumerate(((1, 2), (0, 2), (0, 1)), start=3):
        B[:, :, row, :, i] = g[:, :, j]
        B[:, :, row, :, j] = g[:, :, i]
    A = (root @ B.reshape(E, n_points, 6, 3 * k)) * np.sqrt(points.volumes)[:, :, None, None]
    A = A.reshape(E, 6 * n_points, 3 * k)
    largest = np.linalg.eigvalsh(A @ A.swapaxes(1, 2))[:, -1]
    if points.gamma.shape[1]:
        gamma = points.gamma / np.sqrt(masses)[:, None]
        largest = largest + hourglass * np.linalg.eigvalsh(gamma @ gamma.swapaxes(1, 2))[:, -1]
    return 2 / np.sqrt(largest)
