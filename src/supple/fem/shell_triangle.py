"""Flat shell triangle: optimal membrane + discrete Kirchhoff bending, nonlinear through the membrane strain.

Six freedoms a node, ux uy uz rx ry rz in global axes. In the axes of the element (z the normal):

    eps_m = B_m q + 1/2 N(Gq, Gq)      one point; Gq the constant gradients of the linear displacement
    kappa = B_k q                      linear; integrated at the mid-sides

The gradients are constant, so the membrane does not lock and the foreshortening converges at second order.
Only the rotations enter the curvature, linearly: a shell may turn by about 0.3 rad against the body's frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ModelError
from supple.fem.kinematics import MembraneKinematics
from supple.fem.kirchhoff_bending import CENTRE, MIDSIDES, curvature
from supple.fem.optimal_membrane import (
    higher_order_stiffness,
    linear_gradients,
    membrane_strain,
    triangle_area,
)
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.shell_section import HomogeneousSection, ShellSection

FloatArray = NDArray[np.float64]

ROTATION_LIMIT = 0.3
"""Largest rotation, rad, that the linear curvature describes: its error is rotation^3/6 an element length."""

# Positions of the in-plane and the bending freedoms among the 18 local ones.
IN_PLANE = np.array([[0, 1, 5]]) + 6 * np.arange(3)[:, None]
BENDING = np.array([[2, 3, 4]]) + 6 * np.arange(3)[:, None]


def shell_triangle(
    corners: FloatArray, dofs: NDArray[np.int64], section: ShellSection, kinematics: MembraneKinematics
) -> QuadraticStrain:
    """Quadratic-strain arrays of shell triangles with one section.

    A section that couples stretching and bending (B nonzero) puts the mean curvature beside the membrane
    strain in the nonlinear point, s = 6; what varies over the triangle, and the drilling, stay in the
    linear stiffness.

    Parameters
    ----------
    corners : float array (E, 3, 3)     positions, m
    dofs : int array (E, 18)            nodal freedoms
    section : HomogeneousSection or LaminateSection
    kinematics : MembraneKinematics

    Raises
    ------
    ModelError   an element is normal to the laminate's reference direction
    """
    axes = element_axes(corners, section)
    xy = plane_coordinates(corners, axes)
    area = triangle_area(xy)
    B = _in_plane(membrane_strain(xy))
    D = section.membrane
    form = kinematics.form
    bending = _bending(curvature(xy, MIDSIDES))
    if section.coupling.any():
        mean = bending.mean(axis=1)
        bending = bending - mean[:, None]
        B = np.concatenate([B, mean], axis=1)
        D = np.block([[section.membrane, section.coupling], [section.coupling, section.bending]])
        form = np.concatenate([form, np.zeros_like(form)])

    points = bending.reshape(len(xy), -1, 18)
    moments = (section.bending @ bending).reshape(points.shape)
    linear_stiffness = (area / 3)[:, None, None] * (points.swapaxes(1, 2) @ moments)
    drilling = IN_PLANE.ravel()
    linear_stiffness[:, drilling[:, None], drilling] += higher_order_stiffness(xy, section.membrane)
    half = _to_global(linear_stiffness, axes).swapaxes(1, 2)
    return QuadraticStrain(
        dofs=dofs,
        B=_to_global(B, axes)[:, None],
        G=_to_global(_displacement_gradients(xy)[:, kinematics.gradients], axes)[:, None],
        N=form,
        D=D,
        w=area[:, None],
        linear_stiffness=_to_global(np.ascontiguousarray(half), axes),
    )


def layer_strain(
    corners: FloatArray, block: QuadraticStrain, section: HomogeneousSection, heights: tuple[float, ...]
) -> QuadraticStrain:
    """Strain arrays at the centroid of shell triangles, at heights z = h t/2: B_m + z B_k, plane stress.

    Parameters
    ----------
    corners : float array (E, 3, 3)
    block : QuadraticStrain         of the same triangles, for the gradients and kinematics
    heights : tuple of float        h in [-1, 1]: -1 bottom, 0 middle, 1 top
    Returns
    -------
    QuadraticStrain   one point for each height; weights zero, as it carries no energy of its own
    """
    axes = element_axes(corners, section)
    xy = plane_coordinates(corners, axes)
    membrane, bending = _in_plane(membrane_strain(xy)), _bending(curvature(xy, CENTRE))[:, 0]
    z = 0.5 * section.thickness * np.array(heights)
    B = [_to_global(membrane + height * bending, axes) for height in z]
    return QuadraticStrain(
        dofs=block.dofs,
        B=np.stack(B, axis=1),
        G=np.repeat(block.G, len(z), axis=1),
        N=block.N[:3],
        D=section.material.plane_stress,
        w=np.zeros((len(xy), len(z))),
    )


def element_axes(corners: FloatArray, section: ShellSection) -> FloatArray:
    """Axes (E, 3, 3) of each element, rows x y z in global components; z the normal.

    x is the section's reference direction projected onto the element, or the first side of an isotropic one.
    """
    first = corners[:, 1] - corners[:, 0]
    normal = np.cross(first, corners[:, 2] - corners[:, 0])
    z = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    x = first if section.reference_direction is None else _projected(section.reference_direction, z, corners)
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _projected(direction: ArrayLike, z: FloatArray, corners: FloatArray) -> FloatArray:
    """A unit direction projected onto the plane of each element (E, 3)."""
    direction = np.asarray(direction)
    x = direction - (z @ direction)[:, None] * z
    length = np.linalg.norm(x, axis=1)
    if length.min() < 1e-3:
        worst = int(length.argmin())
        raise ModelError(
            f"triangle {worst}, centred at {corners[worst].mean(axis=0)}, is normal to the laminate's "
            f"reference_direction {direction}; choose a direction along the shell"
        )
    return x


def plane_coordinates(corners: FloatArray, axes: FloatArray) -> FloatArray:
    """Corners (E, 3, 2) in the axes of each element, from its centroid."""
    centred = corners - corners.mean(axis=1, keepdims=True)
    return centred @ axes[:, :2].swapaxes(1, 2)


def _displacement_gradients(xy: FloatArray) -> FloatArray:
    """u,x u,y v,x v,y w,x w,y from the 18 local freedoms, (E, 6, 18)."""
    operator = np.zeros((len(xy), 3, 2, 3, 6))
    for component in range(3):
        operator[:, component, :, :, component] = linear_gradients(xy).swapaxes(1, 2)
    return operator.reshape(-1, 6, 18)


def _in_plane(operator: FloatArray) -> FloatArray:
    """Columns ux uy rz (..., 9) spread over the 18 local freedoms."""
    spread = np.zeros((*operator.shape[:-1], 18))
    spread[..., IN_PLANE.ravel()] = operator
    return spread


def _bending(operator: FloatArray) -> FloatArray:
    """Columns w rx ry (..., 9) spread over the 18 local freedoms."""
    spread = np.zeros((*operator.shape[:-1], 18))
    spread[..., BENDING.ravel()] = operator
    return spread


def _to_global(operator: FloatArray, axes: FloatArray) -> FloatArray:
    """Columns of (E, a, 18) from the axes of the element to global ones: each triad turns alike."""
    rows = operator.shape[1]
    return (operator.reshape(-1, rows * 6, 3) @ axes).reshape(-1, rows, 18)
