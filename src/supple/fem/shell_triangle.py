"""Flat shell triangle: optimal membrane + discrete Kirchhoff bending, quadratic in its nodal rotations.

A node has six freedoms, ux uy uz rx ry rz in global axes; the rotations are true rotation vectors. The
element has one point with 18 strains (supple.fem.shell_kinematics). Linear in these strains are the strain
eps_m of the middle surface, the drilling d, the curvature kappa and the transverse shear gamma; kappa and
gamma vary linearly over the triangle. The strain energy is

    U = A/2 [e^T A_s e + mean(kappa^T D_f kappa) + mean(gamma^T H gamma)] + 1/2 d^T K_h d
    e = eps_m + A_s^-1 B_s kappa_1

with the area A, the section's stiffness A_s, B_s, D_s, H (gamma = 0 in a wall rigid in shear), and kappa_1
the curvature of rotations that are linear over the triangle. D_f = D_s - B_s A_s^-1 B_s is the bending
stiffness of a wall that is free to stretch: an eccentric wall bends about its own mid-surface, as if on rigid
arms. In a facet of a curved surface, eps_m and d are reduced by the effects of the bending of that surface
(supple.fem.curved_facet). The displacement gradients are constant, and the foreshortening converges at second
order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem.curved_facet import bent_with_surface
from supple.fem.kirchhoff_bending import (
    CENTRE,
    MIDSIDES,
    curvature,
    linear_curvature,
    side_directions,
    side_shear_flexibility,
    transverse_shear,
)
from supple.fem.optimal_membrane import (
    drilling_stiffness,
    drilling_strain,
    linear_gradients,
    triangle_area,
)
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.shell_kinematics import (
    BENDING,
    CORNER_ROTATION,
    DRILLING,
    MEMBRANE,
    N_GRADIENTS,
    N_STRAINS,
    ROTATION,
    SIDE_MISMATCH,
    SIDES,
    UX,
    UY,
    VX,
    VY,
    WX,
    WY,
    ShellKinematics,
    V,
    Y,
)
from supple.fem.shell_section import HomogeneousSection, ShellSection


def shell_triangle(
    corners: FloatArray,
    dofs: NDArray[np.int64],
    section: ShellSection,
    kinematics: ShellKinematics,
    directions: FloatArray | None = None,
    surface_curvature: FloatArray | None = None,
) -> QuadraticStrain:
    """Quadratic-strain arrays of shell triangles with one section.

    corners : (E, 3, 3)    positions, m
    dofs : (E, 18)    nodal freedoms
    directions : (E, 3) or None    as in `Section`
    surface_curvature : (E, 3, 3) or None   as in `Section`
    Raises ModelError for a direction that is normal to its element.
    """
    axes = element_axes(corners, section, directions)
    xy = plane_coordinates(corners, axes)
    gradients = _gradients(xy, _shear_flexibility(xy, section))
    return QuadraticStrain(
        dofs=dofs,
        B=_to_global(_linear_strain(gradients), axes)[:, None],
        G=_to_global(gradients[:, kinematics.gradients], axes)[:, None],
        N=kinematics.form,
        D=_stiffness_per_area(xy, section, plane_tensor(surface_curvature, axes)),
        w=triangle_area(xy)[:, None],
    )


def drilling_rotations(
    xy: FloatArray, section: ShellSection, surface_curvature: FloatArray | None = None
) -> FloatArray:
    """Drilling d_i (E, 3, 18) of the mid-surface from the strains of the element.

    Parameters as for `resultant_strains`.
    """
    drilling = np.zeros((len(xy), 3, N_STRAINS))
    drilling[..., DRILLING] = np.eye(3)
    if section.coupling.any():
        # In-plane rotation of the mid-surface, on the nodes' rigid arms.
        middle = (section.coupling * section.membrane).sum() / (section.membrane**2).sum()
        drilling[..., CORNER_ROTATION] += 0.5 * middle * linear_gradients(xy)[:, None]
    if surface_curvature is not None:
        drilling[..., BENDING] -= bent_with_surface(xy, surface_curvature)[1]
    return drilling


def resultant_strains(
    xy: FloatArray,
    points: FloatArray,
    section: ShellSection,
    surface_curvature: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Strain eps_m + A^-1 B kappa_1 (E, 3, 18), and curvature (E, p, 3, 18), from the strains of the element.

    xy : (E, 3, 2)    corners in the plane of the element
    points : (p, 3)    area coordinates of the curvature
    surface_curvature : (E, 2, 2) or None   of the surface, in that plane, 1/m
    """
    membrane = drilling_strain(xy) @ drilling_rotations(xy, section, surface_curvature)
    membrane[..., MEMBRANE] += np.eye(3)
    if surface_curvature is not None:
        membrane[..., BENDING] -= bent_with_surface(xy, surface_curvature)[0]
    if section.coupling.any():
        to_stretch = np.linalg.solve(section.membrane, section.coupling)
        membrane[..., BENDING] += to_stretch @ linear_curvature(xy)
    bending = np.zeros((len(xy), len(points), 3, N_STRAINS))
    bending[..., BENDING] = curvature(xy, points, _shear_flexibility(xy, section))
    return membrane, bending


def layer_strain(
    corners: FloatArray,
    axes: FloatArray,
    section: HomogeneousSection,
    heights: ArrayLike,
    surface_curvature: FloatArray | None = None,
) -> FloatArray:
    """In-plane strain eps_m + o kappa_1 + z kappa at the centroid from the element strains, (E, l, 3, 18).

    axes : (E, 3, 3)    of the elements
    section : with the offset o of its mid-surface
    heights : (l,)    z along the normal from the middle of the wall, m
    surface_curvature : (E, 3, 3) or None   as in `Section`
    """
    xy = plane_coordinates(corners, axes)
    membrane, bending = resultant_strains(xy, CENTRE, section, plane_tensor(surface_curvature, axes))
    return membrane[:, None] + np.asarray(heights)[:, None, None] * bending


def _shear_flexibility(xy: FloatArray, section: ShellSection) -> FloatArray:
    """Shear flexibility phi (E, 3) of the sides."""
    return side_shear_flexibility(xy, free_bending(section), section.shear)


def free_bending(section: ShellSection) -> FloatArray:
    """Bending stiffness (3, 3) of a wall that is free to stretch, D - B A^-1 B, N m."""
    if not section.coupling.any():
        return section.bending
    return section.bending - section.coupling @ np.linalg.solve(section.membrane, section.coupling)


def _stiffness_per_area(
    xy: FloatArray, section: ShellSection, surface_curvature: FloatArray | None
) -> FloatArray:
    """The constitutive matrix (E, 18, 18) of the strains of the element."""
    membrane, bending = resultant_strains(xy, MIDSIDES, section, surface_curvature)
    D = membrane.swapaxes(1, 2) @ (section.membrane @ membrane)
    points = bending.reshape(len(xy), -1, N_STRAINS)
    D += points.swapaxes(1, 2) @ (free_bending(section) @ bending).reshape(points.shape) / len(MIDSIDES)
    if section.shear is not None:
        shear = transverse_shear(xy, MIDSIDES, _shear_flexibility(xy, section))
        points = shear.reshape(len(xy), -1, shear.shape[3])
        stress = (section.shear @ shear).reshape(points.shape)
        D[:, BENDING, BENDING] += points.swapaxes(1, 2) @ stress / len(MIDSIDES)
    drilling = drilling_rotations(xy, section, surface_curvature)
    stiffness = drilling_stiffness(xy, section.membrane) / triangle_area(xy)[:, None, None]
    return D + drilling.swapaxes(1, 2) @ stiffness @ drilling


def _gradients(xy: FloatArray, phi: FloatArray) -> FloatArray:
    """The gradients of supple.fem.shell_kinematics from the 18 local freedoms, (E, 19, 18)."""
    G = np.zeros((len(xy), N_GRADIENTS, 3, 6))
    shape = linear_gradients(xy).swapaxes(1, 2)
    for component in range(3):
        G[:, 2 * component : 2 * component + 2, :, component] = shape
    for corner in range(3):
        for component in range(3):
            G[:, ROTATION[corner, component], corner, 3 + component] = 1
    G = G.reshape(-1, N_GRADIENTS, 18)
    # Least-squares fits to the vectors of the sides: sum_k (s s^T)^-1 s_k s_k . (t_k, b_k).
    s = side_directions(xy)
    fit = np.linalg.inv(s.swapaxes(1, 2) @ s)[:, None] @ (s[..., :, None] * s[..., None, :])
    for side, ends in enumerate(SIDES):
        t = G[:, ROTATION[ends, :2]].mean(axis=1)
        G[:, Y] += fit[:, side] @ t
        G[:, V] += fit[:, side] @ np.stack([t[:, 1], -t[:, 0]], axis=1)
    G[:, V] += G[:, (WX, WY)]
    if phi.any():
        # V is the bending part of the mismatches; in a wall with shear, their shear part causes no bending.
        sheared = fit * (phi / (1 + phi))[..., None, None]
        for side, ends in enumerate(SIDES):
            t = G[:, ROTATION[ends, :2]].mean(axis=1)
            G[:, V] -= sheared[:, side] @ (G[:, (WX, WY)] + np.stack([t[:, 1], -t[:, 0]], axis=1))
    return G


def _linear_strain(G: FloatArray) -> FloatArray:
    """The linear parts of the strains (E, 18, 18) from the gradients."""
    B = np.zeros((len(G), N_STRAINS, 18))
    B[:, MEMBRANE] = np.stack([G[:, UX], G[:, VY], G[:, UY] + G[:, VX]], axis=1)
    B[:, DRILLING] = G[:, ROTATION[:, 2]] - 0.5 * (G[:, VX] - G[:, UY])[:, None]
    B[:, CORNER_ROTATION] = G[:, ROTATION[:, :2]]
    for side, ends in enumerate(SIDES):
        t = G[:, ROTATION[ends, :2]].mean(axis=1)
        B[:, SIDE_MISMATCH[side]] = G[:, (WX, WY)] + np.stack([t[:, 1], -t[:, 0]], axis=1)
    return B


def element_axes(
    corners: FloatArray, section: ShellSection, directions: FloatArray | None = None
) -> FloatArray:
    """Axes (E, 3, 3) of each element, rows x y z in global components; z the normal.

    x is the projection of `directions`, or else of the section's reference direction, onto the element;
    without both, the first side.
    """
    first = corners[:, 1] - corners[:, 0]
    normal = np.cross(first, corners[:, 2] - corners[:, 0])
    z = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    towards = section.reference_direction if directions is None else directions
    x = first if towards is None else _projected(np.asarray(towards), z, corners)
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _projected(direction: FloatArray, z: FloatArray, corners: FloatArray) -> FloatArray:
    """A direction (3,), or one of each element (E, 3), projected onto the plane of each element (E, 3)."""
    direction = np.broadcast_to(direction, z.shape)
    x = direction - (z * direction).sum(axis=1, keepdims=True) * z
    length = np.linalg.norm(x, axis=1)
    if (length < 1e-3 * np.linalg.norm(direction, axis=1)).any() or not length.all():
        worst = int(length.argmin())
        raise ModelError(
            f"triangle {worst}, centred at {corners[worst].mean(axis=0)}, is normal to the laminate's "
            f"reference_direction {direction[worst]}; choose a direction along the shell"
        )
    return x


def plane_coordinates(corners: FloatArray, axes: FloatArray) -> FloatArray:
    """Corners (E, 3, 2) in the axes of each element, from its centroid."""
    centred = corners - corners.mean(axis=1, keepdims=True)
    return centred @ axes[:, :2].swapaxes(1, 2)


def plane_tensor(tensor: FloatArray | None, axes: FloatArray) -> FloatArray | None:
    """Components (E, 2, 2) of tensors (E, 3, 3) in the plane of each element; None for None."""
    return None if tensor is None else axes[:, :2] @ tensor @ axes[:, :2].swapaxes(1, 2)


def _to_global(operator: FloatArray, axes: FloatArray) -> FloatArray:
    """Columns of (E, a, 18) from element axes to global ones; each triad of columns is rotated."""
    rows = operator.shape[1]
    return (operator.reshape(-1, rows * 6, 3) @ axes).reshape(-1, rows, 18)
