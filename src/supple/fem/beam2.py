"""Two-node Timoshenko beam: Green-Lagrange strain of its chord, linear bending, shear and torsion.

Local axes: x along the beam, y and z those of the section. The axial force stiffens or softens a bent beam
through the quadratic strain of the chord; curvatures are linear, so rotations against the body's frame stay
small, as on shells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.fem.beam_section import BeamSection
from supple.fem.mass import CellMass
from supple.fem.quadratic_strain import QuadraticStrain

FloatArray = NDArray[np.float64]

# An orientation within this angle of the beam, rad, gives no axes.
NEARLY_PARALLEL = 1e-6


def beam_axes(ends: FloatArray, section: BeamSection) -> FloatArray:
    """Unit vectors x, y, z (E, 3, 3) of beams as rows, from their ends (E, 2, 3).

    Raises
    ------
    ModelError   an orientation along the beam
    """
    chord = ends[:, 1] - ends[:, 0]
    x = chord / np.linalg.norm(chord, axis=1)[:, None]
    towards = np.asarray(section.orientation) / np.linalg.norm(section.orientation)
    z = np.cross(x, towards)
    sine = np.linalg.norm(z, axis=1)
    bad = np.flatnonzero(sine < NEARLY_PARALLEL)
    if bad.size:
        raise ModelError(
            f"beam {bad[0]} of its section lies along the section's orientation {section.orientation}; "
            "give a direction across the beam"
        )
    z = z / sine[:, None]
    return np.stack([x, np.cross(z, x), z], axis=1)


def beam_strain(ends: FloatArray, dofs: NDArray[np.int64], section: BeamSection) -> QuadraticStrain:
    """Strain arrays of beams between nodes with six freedoms.

    With g = (u_2 - u_1) / L in local axes:

        eps = g_x + 1/2 g.g,     axial energy 1/2 E A L eps^2

    Bending and shear are exact for end loads (cubic deflection, constant shear strain), torsion linear.

    Parameters
    ----------
    ends : float array (E, 2, 3)    positions of the nodes
    dofs : int array (E, 12)        ux uy uz rx ry rz of either node
    Source: J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), eq. (5.116).
    """
    axes = beam_axes(ends, section)
    L = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    n = len(L)
    gradient = np.zeros((n, 3, 12))
    gradient[:, :, :3], gradient[:, :, 6:9] = -axes / L[:, None, None], axes / L[:, None, None]
    EA = section.material.youngs_modulus * section.area
    return QuadraticStrain(
        dofs=dofs,
        B=gradient[:, None, :1].copy(),
        G=gradient[:, None],
        N=np.eye(3)[None],
        D=np.array([[EA]]),
        w=L[:, None].copy(),
        linear_stiffness=_to_mesh_axes(_bending_and_torsion(L, section), axes),
    )


def beam_mass(ends: FloatArray, nodes: NDArray[np.int64], section: BeamSection) -> CellMass:
    """Consistent mass of beams with linear shape functions: m L/6 (1 + delta_ab), rotary inertia likewise."""
    axes = beam_axes(ends, section)
    L = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    pattern = L[:, None, None] / 6 * (1 + np.eye(2))
    inertia = axes.swapaxes(1, 2) @ (section.rotary_inertia_per_length[:, None] * axes)
    return CellMass(nodes, section.mass_per_length * pattern, pattern, inertia)


def _bending_and_torsion(L: FloatArray, section: BeamSection) -> FloatArray:
    """Linear stiffness (E, 12, 12) in local axes, without the axial part."""
    E, G = section.material.youngs_modulus, section.material.shear_modulus
    K = np.zeros((len(L), 12, 12))
    torsion = G * section.J / L
    K[:, [3, 9], [3, 9]] = torsion[:, None]
    K[:, [3, 9], [9, 3]] = -torsion[:, None]
    # A deflection along y turns the section about +z, one along z about -y.
    for moment, factor, freedoms, turn in (
        (section.I1, section.K1, (1, 5, 7, 11), 1.0),
        (section.I2, section.K2, (2, 4, 8, 10), -1.0),
    ):
        phi = 12 * E * moment / (factor * G * section.area * L**2) if factor else np.zeros_like(L)
        unit = E * moment / (L**3 * (1 + phi))
        a, b, c, d = 12 * unit, 6 * L * unit * turn, (4 + phi) * L**2 * unit, (2 - phi) * L**2 * unit
        plane = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]]).transpose(2, 0, 1)
        K[:, np.array(freedoms)[:, None], np.array(freedoms)] = plane
    return K


def _to_mesh_axes(K: FloatArray, axes: FloatArray) -> FloatArray:
    turn = np.zeros_like(K)
    for first in range(0, 12, 3):
        turn[:, first : first + 3, first : first + 3] = axes
    return turn.swapaxes(1, 2) @ K @ turn
