"""Solid elements: isoparametric, with the full Green-Lagrange strain.

A solid element consists of data: its cell type, whose shape functions are in supple.mesh, and two quadrature
rules. A node has three freedoms, ux uy uz in global axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.fem.kinematics import SOLID_FORM, VOIGT
from supple.fem.material import Anisotropic, Isotropic
from supple.fem.quadratic_strain import QuadraticStrain
from supple.mesh.cell_type import CellType
from supple.mesh.quadrature import (
    Quadrature,
    four_point_tetrahedron,
    product_rule,
    reduced_cube,
    strain_rule,
)
from supple.mesh.reference_cell import reference_nodes, shape_functions, shape_gradients


@dataclass(frozen=True, eq=False)
class SolidElement:
    """A solid element.

    strain_rule : for the strain energy, with enough points to exclude zero-energy modes
    mass_rule : exact for the mass and inertia of a cell with curved sides
    incompatible : HEXA8 with three incompatible modes, which bend without shear
    """

    cell_type: CellType
    strain_rule: Quadrature
    mass_rule: Quadrature
    incompatible: bool = False


def solid_strain(
    element: SolidElement,
    corners: FloatArray,
    dofs: IntArray,
    material: Isotropic | Anisotropic,
    directions: FloatArray | None = None,
) -> QuadraticStrain:
    """Quadratic-strain arrays of solid elements.

        G q = grad u,   B q = its symmetric part,   strains xx yy zz yz xz xy (engineering shears)

    The symmetric gradients of the incompatible modes are enhanced strains, added to the strain of q and not
    to its gradient ([SimoRifai1990]; for Green-Lagrange strains [KlinkelWagner1997]). The linear stiffness is
    that of Wilson and Taylor, and the energy is invariant to any rotation.

    corners : (E, k, 3)    positions of all nodes of each cell, m
    dofs : (E, 3k)    nodal freedoms
    directions : (E, 3, 3) or None    axes of the material, as columns; global ones when None
    """
    rule = element.strain_rule
    reference = shape_gradients(element.cell_type, rule.points)
    jacobian = _jacobian(corners, reference)
    B, G = _of_gradients((reference @ np.linalg.inv(jacobian)).swapaxes(2, 3))
    D = material.elasticity if directions is None else turned_elasticity(material.elasticity, directions)
    w = rule.weights * np.linalg.det(jacobian)
    enhanced = None
    if element.incompatible:
        modes, _ = _of_gradients(_incompatible_gradients(element, corners, jacobian))
        stress = w[..., None, None] * np.reshape(D, (-1, 1, 6, 6)) @ modes
        energy = np.einsum("egsi,egsj->eij", modes, stress, optimize=True)
        enhanced = modes @ np.linalg.inv(np.linalg.cholesky(energy)).swapaxes(1, 2)[:, None]
    return QuadraticStrain(
        dofs=dofs,
        B=B,
        G=G,
        N=SOLID_FORM,
        D=D,
        w=w,
        enhanced=enhanced,
    )


def _of_gradients(gradients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """B (E, p, 6, 3k) and G (E, p, 9, 3k) of k functions whose gradients (E, p, 3, k) are given."""
    n_cells, n_points, _, k = gradients.shape
    G = np.zeros((n_cells, n_points, 3, 3, k, 3))
    for component in range(3):
        G[:, :, component, :, :, component] = gradients
    B = np.stack(
        [G[:, :, 0, 0], G[:, :, 1, 1], G[:, :, 2, 2]]
        + [G[:, :, i, j] + G[:, :, j, i] for i, j in ((1, 2), (0, 2), (0, 1))],
        axis=2,
    )
    return B.reshape(n_cells, n_points, 6, 3 * k), G.reshape(n_cells, n_points, 9, 3 * k)


def _incompatible_gradients(element: SolidElement, corners: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Gradients (E, p, 3, 3) of  1 - xi^2, 1 - eta^2, 1 - zeta^2,  by the Jacobian at the centre.

    With the factor det J at the centre over det J at the point, constant stress does no work on the modes, so
    any element passes the patch test (Taylor, Beresford and Wilson, Int. J. Numer. Meth. Eng. 10, 1976).
    """
    centre = _jacobian(corners, shape_gradients(element.cell_type, np.zeros((1, 3))))
    reference = -2.0 * element.strain_rule.points[:, :, None] * np.eye(3)
    scale = np.linalg.det(centre) / np.linalg.det(jacobian)
    return ((reference @ np.linalg.inv(centre)) * scale[..., None, None]).swapaxes(2, 3)


def turned_elasticity(elasticity: FloatArray, directions: FloatArray) -> FloatArray:
    """Stiffness (E, 6, 6) in global axes of a material with its own axes, T^T C T.

        T_IJ = f/2 (R_ki R_lj + R_li R_kj),   I = ij, J = kl,   f = 1 (i = j) or 2

    T takes strains (engineering shears) from global axes to those of the material, the columns of R.

    elasticity : (6, 6)    in the axes of the material, order of `SOLID_FORM`
    directions : (E, 3, 3)    orthonormal, as columns
    Raises ModelError for columns that are not orthonormal.
    """
    square = directions.swapaxes(1, 2) @ directions
    bad = np.flatnonzero(np.abs(square - np.eye(3)).max(axis=(1, 2)) > 1e-6)
    if bad.size:
        raise ModelError(
            f"the material axes of {bad.size} solid cells, first number {bad[0]} of its section, are not "
            "orthonormal; give orthogonal unit vectors as columns"
        )
    i, j = np.array(VOIGT).T
    both = directions[:, i[:, None], i] * directions[:, j[:, None], j]
    crossed = directions[:, j[:, None], i] * directions[:, i[:, None], j]
    T = 0.5 * np.where(i == j, 1.0, 2.0)[:, None] * (both + crossed).swapaxes(1, 2)
    return T.swapaxes(1, 2) @ elasticity @ T


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


SOLID_ELEMENTS = {
    kind: SolidElement(kind, strain_rule(kind), mass_rule)
    for kind, mass_rule in (
        (CellType.TETRA4, four_point_tetrahedron()),
        (CellType.TETRA10, product_rule(CellType.TETRA10, 4)),
        (CellType.PYRAMID5, product_rule(CellType.PYRAMID5, 4)),
        (CellType.PYRAMID13, product_rule(CellType.PYRAMID13, 6)),
        (CellType.WEDGE6, product_rule(CellType.WEDGE6, 3)),
        (CellType.WEDGE15, product_rule(CellType.WEDGE15, 5)),
        # The inertia integrand x^2 det J has degree 2 + 2 in each direction; with curved sides 4 + 5.
        (CellType.HEXA8, product_rule(CellType.HEXA8, 3)),
        (CellType.HEXA20, product_rule(CellType.HEXA20, 5)),
    )
}
"""The plain element of each cell type. Linear elements are too stiff in bending, above all slender ones:
prefer quadratic elements, or HEXA8 with incompatible modes.
"""

_REDUCED_HEXA20 = replace(SOLID_ELEMENTS[CellType.HEXA20], strain_rule=reduced_cube())
_INCOMPATIBLE_HEXA8 = replace(SOLID_ELEMENTS[CellType.HEXA8], incompatible=True)


def solid_element(kind: CellType, *, reduced: bool = False, incompatible: bool = False) -> SolidElement:
    """The element of a cell type; `reduced` acts on HEXA20 only, `incompatible` on HEXA8 only."""
    if reduced and kind is CellType.HEXA20:
        return _REDUCED_HEXA20
    return _INCOMPATIBLE_HEXA8 if incompatible and kind is CellType.HEXA8 else SOLID_ELEMENTS[kind]
