"""Mass, centre and inertia: of a mass matrix, from its rigid motions, and of the volume of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body.rigid_motion import nodal_rigid_modes
from supple.fem import BeamSection, FiniteElementModel, Isotropic, ShellSection
from supple.fem.beam2 import beam_axes
from supple.fem.quadrature import conical_tetrahedron, gauss_cube
from supple.mesh import CellType
from supple.mesh.reference_cell import shape_functions, shape_gradients

__all__ = ["MassProperties", "mesh_mass_properties", "rigid_mass_properties"]

FloatArray = NDArray[np.float64]

# Exact for x x^T det J: degree 4 + 5 in one direction of a HEXA20, 4 + 3 in all of a TETRA10.
_CUBE, _TETRAHEDRON = gauss_cube(5), conical_tetrahedron(4)
_CELLS_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, kg; centre (3,), m; inertia (3, 3) about the centre, kg m^2; in the mesh axes."""

    mass: float
    centre: FloatArray
    inertia: FloatArray


def rigid_mass_properties(mass: Any, nodes: FloatArray, dofs_per_node: int) -> MassProperties:
    """What a mass matrix says of rigid motion, R^T M R: the mean of its three masses, centre and inertia.

    Parameters
    ----------
    mass : sparse (n, n), of N * dofs_per_node nodal freedoms, then of modal coordinates;  nodes : (N, 3)
    Returns
    -------
    MassProperties   centre and inertia are zero where the mass is
    """
    # About the middle of the nodes, so that the inertia is no small difference of large numbers.
    middle = nodes.mean(axis=0)
    R = nodal_rigid_modes(nodes - middle, dofs_per_node)
    gram = R.T @ (mass[: len(R), : len(R)] @ R)
    total = float(np.trace(gram[:3, :3]) / 3)
    if not total > 0:
        return MassProperties(total, middle, np.zeros((3, 3)))
    arm = centre_of_gram(gram)
    about_centre = gram[3:, 3:] - total * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return MassProperties(total, middle + arm, about_centre)


def centre_of_gram(gram: FloatArray) -> FloatArray:
    """Centre of mass (3,) of R^T M R (6, 6), about the point that the rotations are about.

    The coupling of u_i with theta_j is m (e_j x r)_i: its skew part holds m times the centre.
    """
    C, total = gram[:3, 3:6], np.trace(gram[:3, :3]) / 3
    return np.array([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]]) / (2 * total)


def mesh_mass_properties(model: FiniteElementModel) -> MassProperties:
    """Density integrated over the mesh itself: a check of the mass matrix.

    A simplex of k corners x_a and size V has
        int 1 = V,   int x = V s / k,   int x x^T = V / (k (k + 1)) (sum_a x_a x_a^T + s s^T),   s = sum_a x_a
    Solid cells are integrated over their own map, which curves with their middle nodes. Shells count as
    sheets and beams as lines, with the rotary inertia of their sections.
    """
    middle = model.mesh.nodes.mean(axis=0)
    total, first, second, rotary = 0.0, np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    for section in model.sections:
        x = section.corners(model.mesh) - middle
        moments = _simplex_moments(x) if section.cell_type.dimension < 3 else _moments(section.cell_type, x)
        density = _density(section.property)
        total += density * moments[0]
        first += density * moments[1]
        second += density * moments[2]
        rotary += _rotary_inertia(section.property, x)
    arm = first / total
    central = second - total * np.outer(arm, arm)
    return MassProperties(float(total), middle + arm, np.trace(central) * np.eye(3) - central + rotary)


def _moments(kind: CellType, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Volume, int x and int x x^T over solid cells (E, k, 3), by quadrature on their parent."""
    rule = _CUBE if kind in (CellType.HEXA8, CellType.HEXA20) else _TETRAHEDRON
    shape, gradients = shape_functions(kind, rule.points), shape_gradients(kind, rule.points)
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for start in range(0, len(x), _CELLS_AT_ONCE):
        some = x[start : start + _CELLS_AT_ONCE]
        jacobian = np.einsum("eki,pkj->epij", some, gradients, optimize=True)
        weights = (rule.weights * np.linalg.det(jacobian)).ravel()
        points = (shape @ some).reshape(-1, 3)
        volume += float(weights.sum())
        first += weights @ points
        second += points.T @ (weights[:, None] * points)
    return volume, first, second


def _simplex_moments(x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """The same over lines (E, 2, 3) or triangles (E, 3, 3)."""
    k, sizes, s = x.shape[1], _sizes(x), x.sum(axis=1)
    second = np.einsum("e,eai,eaj->ij", sizes, x, x, optimize=True)
    second += np.einsum("e,ei,ej->ij", sizes, s, s, optimize=True)
    return float(sizes.sum()), sizes @ s / k, second / (k * (k + 1))


def _density(made_of: Isotropic | ShellSection | BeamSection) -> float:
    """Mass per volume, area or length."""
    if isinstance(made_of, Isotropic):
        return made_of.density
    if isinstance(made_of, BeamSection):
        assert made_of.mass_per_length is not None  # set when left out
        return made_of.mass_per_length
    return made_of.mass_per_area


def _rotary_inertia(made_of: Isotropic | ShellSection | BeamSection, x: FloatArray) -> FloatArray:
    """Inertia (3, 3) of sections about their own middle, summed over simplices x."""
    if isinstance(made_of, Isotropic):
        return np.zeros((3, 3))
    if isinstance(made_of, BeamSection):
        axes = beam_axes(x, made_of)
        return np.einsum("e,eki,k,ekj->ij", _sizes(x), axes, made_of.rotary_inertia_per_length, axes)
    return made_of.rotary_inertia_per_area * _sizes(x).sum() * np.eye(3)


def _sizes(x: FloatArray) -> FloatArray:
    """Lengths of lines (E, 2, 3), areas of triangles (E, 3, 3)."""
    edges = x[:, 1:] - x[:, :1]
    if x.shape[1] == 2:
        return np.linalg.norm(edges[:, 0], axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    return 0.5 * np.linalg.norm(normal, axis=1)
