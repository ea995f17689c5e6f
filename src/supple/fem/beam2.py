"""Two-node Timoshenko beam with six strains, quadratic in the nodal rotation vectors.

Local axes: x along the chord, y and z those of the section. All strains are quadratic, so bending and torsion
couple, and the energy of a rigid rotation is of eighth order in its angle.

The stiffness of the six strains is the inverse of the flexibility, which is integrated for the forces of end
loads. It is exact in the linear limit for any section: coupled, tapered, or with the neutral axis or the mass
off the chord.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.algebra.cross import cross_matrices
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem.beam_section import MX, MY, MZ, VY, VZ, LineSection, N
from supple.fem.mass import CellMass
from supple.fem.quadratic_strain import QuadraticStrain
from supple.fem.shell_kinematics import GREEN_LAGRANGE, ShellKinematics

# An orientation within this angle of the beam, rad, does not define axes; ends closer than this fraction of
# the distance of their nodes coincide. Both raise ModelError.
NEARLY_PARALLEL = 1e-6

# Relative eigenvalue of the stiffness of released freedoms, scaled to a unit diagonal: below it a motion has
# no stiffness, and condensation leaves it unchanged.
UNHELD = 1e-10

# The in-plane displacement gradients of a membrane (see ShellKinematics).
IN_PLANE = (0, 1, 2, 3)

# Rows of the beam's gradients: g, t, theta_1, theta_2; with offsets also the rotations of the nodes.
CHORD, MEAN, START, END, START_NODE, END_NODE = (slice(first, first + 3) for first in range(0, 18, 3))

# The permutation symbol: (a x b)_i = EPSILON_ijk a_j b_k.
EPSILON = np.cross(np.eye(3)[None, :], np.eye(3)[:, None]).transpose(2, 1, 0)


class BeamLine(NamedTuple):
    """Lines of beams between their ends, which rigid arms connect to the nodes.

    axes : (E, 3, 3) unit vectors x, y, z as rows;  length : (E,), m
    arms : (E, 2, 3) from the nodes to the ends in these axes, m
    """

    axes: FloatArray
    length: FloatArray
    arms: FloatArray

    @property
    def of_ends(self) -> FloatArray:
        """Freedoms of the ends in the axes of the beam from those of the nodes, (E, 12, 12)."""
        of_ends = np.zeros((len(self.axes), 12, 12))
        for end in range(2):
            u, theta = slice(6 * end, 6 * end + 3), slice(6 * end + 3, 6 * end + 6)
            of_ends[:, u, u] = of_ends[:, theta, theta] = self.axes
            of_ends[:, u, theta] = -cross_matrices(self.arms[:, end]) @ self.axes
        return of_ends


def beam_line(
    nodes: FloatArray,
    section: LineSection,
    directions: FloatArray | None = None,
    offsets: FloatArray | None = None,
) -> BeamLine:
    """Axes of beams between nodes (E, 2, 3); `directions` and `offsets` as in `Section`.

    Raises ModelError for an orientation along the beam; ends that coincide.
    """
    ends = nodes if offsets is None else nodes + offsets
    chord = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(chord, axis=1)
    bad = np.flatnonzero(length <= NEARLY_PARALLEL * np.linalg.norm(nodes[:, 1] - nodes[:, 0], axis=1))
    if bad.size:
        raise ModelError(f"the offsets of beam {bad[0]} of its section make its ends coincide; correct them")
    x = chord / length[:, None]
    towards = np.broadcast_to(np.asarray(section.orientation) if directions is None else directions, x.shape)
    z = np.cross(x, towards)
    sine = np.linalg.norm(z, axis=1) / np.maximum(np.linalg.norm(towards, axis=1), np.finfo(float).tiny)
    bad = np.flatnonzero(sine < NEARLY_PARALLEL)
    if bad.size:
        raise ModelError(
            f"beam {bad[0]} of its section lies along the section's orientation {towards[bad[0]]}; "
            "give a direction across the beam"
        )
    z = z / np.linalg.norm(z, axis=1)[:, None]
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    arms = np.zeros_like(nodes) if offsets is None else offsets @ axes.swapaxes(1, 2)
    return BeamLine(axes, length, arms)


def beam_strain(
    line: BeamLine,
    dofs: NDArray[np.int64],
    section: LineSection,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
    released: NDArray[np.bool_] | None = None,
) -> QuadraticStrain:
    """Strain arrays of beams between nodes with six freedoms.

    With g = (u_2 - u_1) / L, t = (theta_1 + theta_2) / 2 of the ends, in local axes:

        eps = g_x + 1/2 g.g
        k   = theta_2 - theta_1 - 1/2 theta_1 x theta_2
        m_y = t_y + g_z + 1/3 (g_x t_y - t_x g_y) - 1/6 t_x t_z
        m_z = t_z - g_y + 1/3 (g_x t_z - t_x g_z) + 1/6 t_x t_y

    k is the rotation of end 2 relative to end 1, log(R_1^T R_2); m_y and m_z are the mean rotations of the
    ends relative to the chord. The strains are exact to second order; the factors 1/3 and 1/6 also cancel the
    third-order strains of a rigid rotation. Their stiffness is `chord_stiffness`. For a constant section in
    principal axes, with the neutral axis at the shear centre, the stiffness is E A L for eps and (G J, E I2,
    E I1) / L for k. For m_y and m_z it is 12 E I / (L (1 + phi)), with phi = 12 E I / (K G A L^2).

    An end on an arm o moves by u + theta x o + 1/2 theta x (theta x o); a rigid rotation then leaves strains
    of third order, as at a rigid interface. Released freedoms are condensed with the linear stiffness, so
    that the energy is correct to third order and the force to second.

    dofs : (E, 12)    ux uy uz rx ry rz of either node
    kinematics : without in-plane gradients (VON_KARMAN) for small rotations: only eps has quadratic terms, of
        the slopes of the chord; k and m stay linear
    released : (E, 12) or None    as in `Section`
    Source: J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), eq. (5.116), the stiffness at
    rest; the quadratic terms: docs/theory/quadratic_strain.md.
    """
    L = line.length
    gradient = _gradients(L)
    linear = np.zeros((len(L), 6, 12))
    linear[:, 0] = gradient[:, 0]
    linear[:, 1:4] = gradient[:, END] - gradient[:, START]
    linear[:, 4] = gradient[:, 4] + gradient[:, 2]
    linear[:, 5] = gradient[:, 5] - gradient[:, 1]
    D = chord_stiffness(L, section)
    of_ends = line.of_ends
    ends = of_ends
    if released is not None and released.any():
        D, following = _condensed(D, linear, released)
        ends = following @ of_ends
    large = set(IN_PLANE) <= set(kinematics.gradients)
    form = _large_rotation_form() if large else _chord_slope_form()
    gradient = gradient @ ends
    if large and line.arms.any():
        gradient = np.concatenate([gradient, of_ends[:, 3:6], of_ends[:, 9:]], axis=1)
        form = _with_arms(form, line)[:, None]
    return QuadraticStrain(
        dofs=dofs,
        B=(linear @ ends)[:, None],
        G=gradient[:, None],
        N=form,
        D=D,
        w=np.ones((len(L), 1)),
    )


def chord_stiffness(L: FloatArray, section: LineSection) -> FloatArray:
    """Stiffness (E, 6, 6) of eps, k, m_y, m_z: inverse of the flexibility for the conjugate forces Q.

        N = Q_1 / L,  M_x = Q_2,  M_y = Q_3 + xi Q_5,  M_z = Q_4 + xi Q_6,  V_z = Q_5 / L,  V_y = -Q_6 / L

    with xi from -1/2 to 1/2 along the beam: the forces in equilibrium with loads at the ends alone. Forces
    that the section does not carry have no stiffness.
    """
    # Exact for a constant section; the flexibility of a tapered one is smooth, but no polynomial.
    xi, weights = np.polynomial.legendre.leggauss(2 if section.second is None else 12)
    xi, weights = xi / 2, weights / 2
    even, by_length = np.zeros((len(xi), 6, 6)), np.zeros((6, 6))
    even[:, MX, 1] = even[:, MY, 2] = even[:, MZ, 3] = 1.0
    even[:, MY, 4] = even[:, MZ, 5] = xi
    by_length[N, 0] = by_length[VZ, 4] = 1.0
    by_length[VY, 5] = -1.0
    weighted = weights[:, None, None] * section.flexibility(xi + 0.5)
    moments = (even.swapaxes(1, 2) @ weighted @ even).sum(axis=0)
    mixed = (even.swapaxes(1, 2) @ weighted @ by_length).sum(axis=0)
    forces = by_length.T @ weighted.sum(axis=0) @ by_length
    length = L[:, None, None]
    flexibility = length * moments + (mixed + mixed.T) + forces / length
    carried = section.carried[[N, MX, MY, MZ, MY, MZ]]
    D = np.zeros((len(L), 6, 6))
    D[:, np.flatnonzero(carried)[:, None], carried] = np.linalg.inv(flexibility[:, carried][:, :, carried])
    return D


def beam_mass(line: BeamLine, nodes: NDArray[np.int64], section: LineSection) -> CellMass:
    """Consistent mass of beams with linear shape functions: m L/6 (1 + delta_ab), also for rotary inertia.

    The mass of released freedoms remains at their nodes. Lumped mass is at the ends of the beam, so that it
    is positive semidefinite for any offsets; sums of rows are not if the offsets of the ends differ.
    """
    s, weights = np.polynomial.legendre.leggauss(2)
    s, weights = (1 + s) / 2, weights / 2
    shape = np.stack([1 - s, s], axis=1)
    inertia = section.inertia(s)
    of_length = np.einsum("p,pa,pb,pij->aibj", weights, shape, shape, inertia).reshape(12, 12)
    of_ends = line.of_ends
    mass = line.length[:, None, None] * (of_ends.swapaxes(1, 2) @ of_length @ of_ends)
    translational = line.length[:, None, None] * of_length[::6, ::6]
    mass.reshape(-1, 2, 6, 2, 6)[:, :, np.arange(3), :, np.arange(3)] -= translational
    at_ends = line.length[:, None, None, None] * np.einsum("p,pa,pij->aij", weights, shape, inertia)
    arms = np.stack([of_ends[:, :6, :6], of_ends[:, 6:, 6:]], axis=1)
    return CellMass(nodes, translational, coupled=mass, nodal=arms.swapaxes(2, 3) @ at_ends @ arms)


def _gradients(L: FloatArray) -> FloatArray:
    """g, t, theta_1, theta_2 from the freedoms of the ends, all in local axes, (E, 12, 12)."""
    gradient = np.zeros((len(L), 12, 12))
    eye = np.eye(3)
    by_length = eye / L[:, None, None]
    gradient[:, CHORD, :3], gradient[:, CHORD, 6:9] = -by_length, by_length
    gradient[:, MEAN, 3:6] = gradient[:, MEAN, 9:] = eye / 2
    gradient[:, START, 3:6] = gradient[:, END, 9:] = eye
    return gradient


def _condensed(
    D: FloatArray, linear: FloatArray, released: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Condensed stiffness (E, 6, 6), and the end freedoms after condensation from those before, (E, 12, 12).

    The released freedoms minimise the energy. With B `linear` and C its columns of released freedoms:
        D - D C (C^T D C)^+ C^T D,   1 - (C^T D C)^+ C^T D B
    """
    free = linear * released[:, None]
    stress = D @ free
    K = free.swapaxes(1, 2) @ stress
    diagonal = np.einsum("eii->ei", K)
    scale = np.where(diagonal > 0, 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), 0.0)
    scaled = scale[:, :, None] * K * scale[:, None]
    inverse = scale[:, :, None] * np.linalg.pinv(scaled, rcond=UNHELD, hermitian=True) * scale[:, None]
    gain = inverse @ stress.swapaxes(1, 2)
    return D - stress @ gain, np.eye(12) - gain @ linear


def _with_arms(form: FloatArray, line: BeamLine) -> FloatArray:
    """N (E, 6, 18, 18): `form`, and the second-order terms 1/2 theta x (theta x o) / L of the arms in g.

    theta x (theta x o) = theta (theta . o) - o (theta . theta)
    """
    full = np.zeros((len(line.length), 6, 18, 18))
    full[:, :, :12, :12] = form
    eye = np.eye(3)
    for end, sign, of_node in ((0, -1.0, START_NODE), (1, 1.0, END_NODE)):
        o = sign * line.arms[:, end] / line.length[:, None]
        # Twice 1/2 theta x (theta x o), as a symmetric form of theta: (E, component, 3, 3).
        turned = 0.5 * (np.einsum("ij,ek->eijk", eye, o) + np.einsum("ik,ej->eijk", eye, o))
        turned -= np.einsum("ei,jk->eijk", o, eye)
        full[:, 0, of_node, of_node] += turned[:, 0]
        full[:, 4, of_node, of_node] += turned[:, 2]
        full[:, 5, of_node, of_node] -= turned[:, 1]
    return full


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
