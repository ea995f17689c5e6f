"""Two-node Timoshenko beam with six strains, quadratic in freedoms whose rotations are rotation vectors.

Local axes: x along the chord, y and z those of the section. Nothing of the energy stays linear, so bending
and torsion couple and a rigid rotation costs energy of the eighth order in its angle only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.fem.beam_section import BeamSection
from supple.fem.mass import CellMass
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.shell_kinematics import GREEN_LAGRANGE, ShellKinematics

FloatArray = NDArray[np.float64]

# An orientation within this angle of the beam, rad, gives no axes.
NEARLY_PARALLEL = 1e-6

# The displacement gradients of a membrane that lie in its plane (see ShellKinematics).
IN_PLANE = (0, 1, 2, 3)

# Rows of the beam's gradients: g, t, theta_1, theta_2.
CHORD, MEAN, START, END = (slice(first, first + 3) for first in range(0, 12, 3))

# The permutation symbol: (a x b)_i = EPSILON_ijk a_j b_k.
EPSILON = np.cross(np.eye(3)[None, :], np.eye(3)[:, None]).transpose(2, 1, 0)


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


def beam_strain(
    ends: FloatArray,
    dofs: NDArray[np.int64],
    section: BeamSection,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
) -> QuadraticStrain:
    """Strain arrays of beams between nodes with six freedoms.

    With g = (u_2 - u_1) / L, t = (theta_1 + theta_2) / 2 and phi the shear flexibility, in local axes:

        eps = g_x + 1/2 g.g                                                  E A L
        k   = theta_2 - theta_1 - 1/2 theta_1 x theta_2                      (G J, E I2, E I1) / L
        m_y = t_y + g_z + 1/3 (g_x t_y - t_x g_y) - 1/6 t_x t_z              12 E I2 / (L (1 + phi))
        m_z = t_z - g_y + 1/3 (g_x t_z - t_x g_z) + 1/6 t_x t_y              12 E I1 / (L (1 + phi))

    k is the rotation of one end against the other, log(R_1^T R_2); m_y and m_z are the rotation of the
    sections against the chord. All to second order; 1/3 and 1/6 are the factors that leave a rigid rotation
    no third order either. The stiffness at rest is exact for end loads (cubic deflection, constant shear).

    Parameters
    ----------
    ends : float array (E, 2, 3)    positions of the nodes
    dofs : int array (E, 12)        ux uy uz rx ry rz of either node
    kinematics : ShellKinematics
        one without gradients in the plane (VON_KARMAN) is for small rotations: only the slopes of the chord
        enter, in eps, and k and m stay linear
    Source: J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), eq. (5.116), the stiffness at
    rest; the quadratic terms: docs/theory/quadratic_strain.md.
    """
    axes = beam_axes(ends, section)
    L = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    gradient = _gradients(axes, L)
    linear = np.zeros((len(L), 6, 12))
    linear[:, 0] = gradient[:, 0]
    linear[:, 1:4] = gradient[:, END] - gradient[:, START]
    linear[:, 4] = gradient[:, 4] + gradient[:, 2]
    linear[:, 5] = gradient[:, 5] - gradient[:, 1]
    return QuadraticStrain(
        dofs=dofs,
        B=linear[:, None],
        G=gradient[:, None],
        N=_large_rotation_form() if set(IN_PLANE) <= set(kinematics.gradients) else _chord_slope_form(),
        D=_section_stiffness(L, section),
        w=np.ones((len(L), 1)),
    )


def beam_mass(ends: FloatArray, nodes: NDArray[np.int64], section: BeamSection) -> CellMass:
    """Consistent mass of beams with linear shape functions: m L/6 (1 + delta_ab), rotary inertia likewise."""
    axes = beam_axes(ends, section)
    L = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    pattern = L[:, None, None] / 6 * (1 + np.eye(2))
    inertia = axes.swapaxes(1, 2) @ (section.rotary_inertia_per_length[:, None] * axes)
    return CellMass(nodes, section.mass_per_length * pattern, pattern, inertia)


def _gradients(axes: FloatArray, L: FloatArray) -> FloatArray:
    """g, t, theta_1, theta_2 in local axes by element freedoms, (E, 12, 12)."""
    gradient = np.zeros((len(L), 12, 12))
    by_length = axes / L[:, None, None]
    gradient[:, CHORD, :3], gradient[:, CHORD, 6:9] = -by_length, by_length
    gradient[:, MEAN, 3:6] = gradient[:, MEAN, 9:] = axes / 2
    gradient[:, START, 3:6] = gradient[:, END, 9:] = axes
    return gradient


def _large_rotation_form() -> FloatArray:
    """N (6, 12, 12) of the six strains over g, t, theta_1, theta_2."""
    half = np.zeros((6, 12, 12))
    half[0, CHORD, CHORD] = np.eye(3) / 2
    half[1:4, START, END] = -EPSILON / 2
    gx, gy, gz = range(3)
    tx, ty, tz = range(3, 6)
    half[4, gx, ty], half[4, tx, gy], half[4, tx, tz] = 1 / 3, -1 / 3, -1 / 6
    half[5, gx, tz], half[5, tx, gz], half[5, tx, ty] = 1 / 3, -1 / 3, 1 / 6
    return half + half.swapaxes(1, 2)


def _chord_slope_form() -> FloatArray:
    """N (6, 12, 12) of von Karman's strain: 1/2 (g_y^2 + g_z^2) in eps alone."""
    form = np.zeros((6, 12, 12))
    form[0, [1, 2], [1, 2]] = 1
    return form


def _section_stiffness(L: FloatArray, section: BeamSection) -> FloatArray:
    """Stiffness (E, 6, 6) of eps, k, m_y, m_z, diagonal in the section's axes."""
    E, G = section.material.youngs_modulus, section.material.shear_modulus
    D = np.zeros((len(L), 6, 6))
    D[:, 0, 0] = E * section.area * L
    D[:, 1, 1] = G * section.J / L
    # I2 bends about y, I1 about z.
    for moment, factor, bent, mismatch in ((section.I2, section.K2, 2, 4), (section.I1, section.K1, 3, 5)):
        phi = 12 * E * moment / (factor * G * section.area * L**2) if factor else np.zeros_like(L)
        D[:, bent, bent] = E * moment / L
        D[:, mismatch, mismatch] = 12 * E * moment / (L * (1 + phi))
    return D
