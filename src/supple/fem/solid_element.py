"""Solid elements: isoparametric, with the full Green-Lagrange strain.

A solid element is data: its cell type, whose shape functions the mesh knows, and two quadrature rules.
Three freedoms a node, ux uy uz in global axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.errors import MeshError
from supple.fem.kinematics import SOLID_FORM
from supple.fem.material import Isotropic
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.quadrature import Quadrature
from supple.mesh.cell_type import CellType
from supple.mesh.reference_cell import reference_nodes, shape_functions, shape_gradients

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SolidElement:
    """A solid element.

    Parameters
    ----------
    cell_type : CellType
    strain_rule : Quadrature    for the strain energy: enough points that only rigid motion has none
    mass_rule : Quadrature      exact for the mass and inertia of a cell with curved sides
    """

    cell_type: CellType
    strain_rule: Quadrature
    mass_rule: Quadrature


def solid_strain(
    element: SolidElement,
    corners: FloatArray,
    dofs: IntArray,
    material: Isotropic,
    cell_ids: IntArray | None = None,
) -> QuadraticStrain:
    """Quadratic-strain arrays of solid elements.

        G q = grad u,   B q = its symmetric part,   strains xx yy zz yz xz xy (engineering shears)

    Parameters
    ----------
    corners : float array (E, k, 3)     positions of all nodes of each cell, m
    dofs : int array (E, 3k)            nodal freedoms
    cell_ids : int array (E,)           for messages; numbers from 0 when omitted

    Raises
    ------
    MeshError   the mapping of a curved cell turns over at an integration point
    """
    n_cells, k, _ = corners.shape
    rule = element.strain_rule
    reference = shape_gradients(element.cell_type, rule.points)
    jacobian = _jacobian(corners, reference)
    volume = _positive_volume(element.cell_type, corners, jacobian, cell_ids)
    gradients = (reference @ np.linalg.inv(jacobian)).swapaxes(2, 3)
    G = np.zeros((n_cells, len(rule.points), 3, 3, k, 3))
    for component in range(3):
        G[:, :, component, :, :, component] = gradients
    B = np.stack(
        [G[:, :, 0, 0], G[:, :, 1, 1], G[:, :, 2, 2]]
        + [G[:, :, i, j] + G[:, :, j, i] for i, j in ((1, 2), (0, 2), (0, 1))],
        axis=2,
    )
    return QuadraticStrain(
        dofs=dofs,
        B=B.reshape(n_cells, -1, 6, 3 * k),
        G=G.reshape(n_cells, -1, 9, 3 * k),
        N=SOLID_FORM,
        D=material.elasticity,
        w=rule.weights * volume,
    )


def solid_mass(element: SolidElement, corners: FloatArray, density: float) -> FloatArray:
    """Consistent mass of each cell between its nodes, the same for each direction: (E, k, k), kg."""
    rule = element.mass_rule
    volume = np.linalg.det(_jacobian(corners, shape_gradients(element.cell_type, rule.points)))
    shape = shape_functions(element.cell_type, rule.points)
    products = rule.weights[:, None, None] * shape[:, :, None] * shape[:, None, :]
    k = shape.shape[1]
    return density * (volume @ products.reshape(-1, k * k)).reshape(-1, k, k)


def solid_rotation(element: SolidElement, corners: FloatArray) -> FloatArray:
    """Rotation vector at the centre of each cell, half the curl of u: (E, 3, 3k)."""
    centre = element.strain_rule.points.mean(axis=0, keepdims=True)
    reference = shape_gradients(element.cell_type, centre)
    gradients = (reference @ np.linalg.inv(_jacobian(corners, reference)))[:, 0]
    rotation = np.zeros((len(corners), 3, gradients.shape[1], 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        rotation[:, i, :, k] = 0.5 * gradients[..., j]
        rotation[:, i, :, j] = -0.5 * gradients[..., k]
    return rotation.reshape(len(corners), 3, -1)


def extrapolation(element: SolidElement) -> FloatArray:
    """Values at the nodes (k, g) from those at the strain points, by the linear field that fits them best."""
    points, nodes = element.strain_rule.points, reference_nodes(element.cell_type)
    if len(points) == 1:
        return np.ones((len(nodes), 1))
    linear = [np.column_stack([np.ones(len(x)), x]) for x in (nodes, points)]
    return linear[0] @ np.linalg.pinv(linear[1])


def _jacobian(corners: FloatArray, reference: FloatArray) -> FloatArray:
    """dx_i/dxi_j at each point, (E, p, 3, 3), from reference gradients (p, k, 3)."""
    return np.einsum("eki,pkj->epij", corners, reference, optimize=True)


def _positive_volume(
    cell_type: CellType, corners: FloatArray, jacobian: FloatArray, cell_ids: IntArray | None
) -> FloatArray:
    volume = np.linalg.det(jacobian)
    smallest = volume.min(axis=1)
    if smallest.min() <= 0:
        bad = int(np.flatnonzero(smallest <= 0)[0])
        called = bad if cell_ids is None else cell_ids[bad]
        raise MeshError(
            f"{cell_type.name} cell {called}, centred at {corners[bad].mean(axis=0)}, turns over at an "
            f"integration point (Jacobian {smallest[bad]:.3e}); straighten its sides or refine there"
        )
    return volume
