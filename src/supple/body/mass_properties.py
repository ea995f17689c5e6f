"""Mass, centre of mass and inertia: of a mass matrix from rigid motions, of a mesh by integration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from supple.arrays import FloatArray
from supple.body.rigid_motion import nodal_rigid_modes
from supple.fem import (
    Anisotropic,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    LineSection,
    RodSection,
    Section,
)
from supple.fem.beam2 import BeamLine, beam_line
from supple.mesh import CellType, Mesh
from supple.mesh.quadrature import product_rule
from supple.mesh.reference_cell import shape_functions, shape_gradients

__all__ = ["MassProperties", "mesh_mass_properties", "rigid_mass_properties"]

_CELLS_AT_ONCE = 4096


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, kg; centre of mass (3,), m; inertia (3, 3) about the centre of mass, kg m^2; in the mesh axes."""

    mass: float
    centre: FloatArray
    inertia: FloatArray


def rigid_mass_properties(
    mass: np.ndarray | sparse.csc_array, nodes: FloatArray, dofs_per_node: int
) -> MassProperties:
    """Mass, centre of mass and inertia from R^T M R; the mass is the mean of those along x, y, z.

    Parameters
    ----------
    mass : sparse (n, n), of N * dofs_per_node nodal freedoms, then of modal coordinates;  nodes : (N, 3)
    Returns
    -------
    MassProperties   without positive mass, the centre is the mean of the nodes and the inertia is zero
    """
    # Rotations about the mean of the nodes, so that the inertia is not a small difference of large numbers.
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
    """Centre of mass r (3,) from R^T M R (6, 6), relative to the point about which R rotates.

    The entry of u_i and theta_j is m (e_j x r)_i; the skew part of this block gives m r.
    """
    C, total = gram[:3, 3:6], np.trace(gram[:3, :3]) / 3
    return np.array([C[1, 2] - C[2, 1], C[2, 0] - C[0, 2], C[0, 1] - C[1, 0]]) / (2 * total)


def mesh_mass_properties(model: FiniteElementModel) -> MassProperties:
    """Mass properties from the density integrated over the mesh, and attached masses; checks the mass matrix.

    A simplex of k corners x_a and size V has
        int 1 = V,   int x = V s / k,   int x x^T = V / (k (k + 1)) (sum_a x_a x_a^T + s s^T),   s = sum_a x_a
    Solid cells are integrated over their isoparametric map, including curved edges. Shells are surfaces and
    beams lines through their mass centres, with the rotary inertia of their sections.
    """
    middle = model.mesh.nodes.mean(axis=0)
    parts: list[_Moments] = [(0.0, np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3)))]
    parts += [_moments(model.mesh, section, middle) for section in model.sections]
    if model.attached.mass is not None:
        added = rigid_mass_properties(model.attached.mass, model.mesh.nodes, model.dofs_per_node)
        place = added.centre - middle
        parts.append((added.mass, added.mass * place, added.mass * np.outer(place, place), added.inertia))
    total, first, second, rotary = (sum(each[1:], each[0]) for each in zip(*parts, strict=True))
    arm = first / total if total else first
    central = second - total * np.outer(arm, arm)
    return MassProperties(float(total), middle + arm, np.trace(central) * np.eye(3) - central + rotary)


_Moments = tuple[float, FloatArray, FloatArray, FloatArray]


def _moments(mesh: Mesh, section: Section, middle: FloatArray) -> _Moments:
    """Mass, int x dm, int x x^T dm and rotary inertia (3, 3) of a section's cells, with x from `middle`."""
    x, given = section.corners(mesh) - middle, section.property
    match given:
        case Isotropic() | Anisotropic():
            volume, first, second = _solid_moments(section.cell_type, x)
            return given.density * volume, given.density * first, given.density * second, np.zeros((3, 3))
        case HomogeneousSection() | LaminateSection():
            normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            m, offset = given.mass_per_area, given.mass_offset
            area, first, second = _simplex_moments(x + offset * normal[:, None], section.mass_share)
            own = (given.rotary_inertia_per_area - m * offset**2) * area * np.eye(3)
            return m * area, m * first, m * second, own
        case RodSection():
            assert given.mass_per_length is not None  # the section computes a missing value
            length, first, second = _simplex_moments(x)
            m = given.mass_per_length
            return m * length, m * first, m * second, np.zeros((3, 3))
        case _:
            return _beam_moments(beam_line(x, given, section.directions, section.offsets), x, given)


def _beam_moments(line: BeamLine, x: FloatArray, section: LineSection) -> _Moments:
    """`_moments` of beams between nodes x (E, 2, 3), by Gauss quadrature with three points along a beam."""
    s, weights = np.polynomial.legendre.leggauss(3)
    s = (1 + s) / 2
    ends = x + line.arms @ line.axes
    total, first, second, rotary = 0.0, np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    for at, weight, inertia in zip(s, weights / 2, section.inertia(s), strict=True):
        m, arm = inertia[0, 0], inertia[3:, :3]
        centre = np.array([arm[2, 1], arm[0, 2], arm[1, 0]]) / (m or 1.0)
        place = (1 - at) * ends[:, 0] + at * ends[:, 1] + centre @ line.axes
        mass = weight * m * line.length
        about_centre = inertia[3:, 3:] - m * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        total += float(mass.sum())
        first += mass @ place
        second += place.T @ (mass[:, None] * place)
        turned = line.axes.swapaxes(1, 2) @ about_centre @ line.axes
        rotary += weight * np.einsum("e,eij->ij", line.length, turned)
    return total, first, second, rotary


def _solid_moments(kind: CellType, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Volume, int x dV and int x x^T dV over solid cells (E, k, 3), by quadrature on the reference cell."""
    # Exact for x x^T det J: degree 4 + 5 in one direction of a HEXA20, 4 + 3 in all of a TETRA10.
    rule = product_rule(kind, 4 if kind.n_corners == 4 else 6 if kind.n_corners == 5 else 5)
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


def _simplex_moments(x: FloatArray, share: FloatArray | None = None) -> tuple[float, FloatArray, FloatArray]:
    """Size, int x, int x x^T over lines (E, 2, 3) or triangles (E, 3, 3), weighted by `share` (E,)."""
    k, sizes, s = x.shape[1], _sizes(x), x.sum(axis=1)
    if share is not None:
        sizes = share * sizes
    second = np.einsum("e,eai,eaj->ij", sizes, x, x, optimize=True)
    second += np.einsum("e,ei,ej->ij", sizes, s, s, optimize=True)
    return float(sizes.sum()), sizes @ s / k, second / (k * (k + 1))


def _sizes(x: FloatArray) -> FloatArray:
    """Lengths of lines (E, 2, 3), areas of triangles (E, 3, 3)."""
    edges = x[:, 1:] - x[:, :1]
    if x.shape[1] == 2:
        return np.linalg.norm(edges[:, 0], axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    return 0.5 * np.linalg.norm(normal, axis=1)
