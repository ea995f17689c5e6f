"""Two-node rod: Green's strain in tension, and torsion linear in the rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.fem.beam_section import RodSection
from supple.fem.mass import CellMass
from supple.fem.quadratic_strain import QuadraticStrain


def rod_strain(ends: FloatArray, dofs: NDArray[np.int64], section: RodSection) -> QuadraticStrain:
    """Strain arrays of rods: strains and stiffness D, with x along the rod and g = (u_2 - u_1) / L:

        eps = g_x + 1/2 g.g     D = E A L
        k   = x . (theta_2 - theta_1)     D = G J / L; only if J > 0

    ends : (E, 2, 3)    positions of the nodes
    dofs : (E, 6) or, with torsion, (E, 12)    ux uy uz, or ux uy uz rx ry rz of either node
    """
    chord = ends[:, 1] - ends[:, 0]
    L = np.linalg.norm(chord, axis=1)
    x = chord / L[:, None]
    d = dofs.shape[1] // 2
    G = np.zeros((len(L), 1, 3, 2 * d))
    by_length = np.eye(3) / L[:, None, None]
    G[:, 0, :, :3], G[:, 0, :, d : d + 3] = -by_length, by_length
    twists = section.J > 0
    B = np.zeros((len(L), 1, 1 + twists, 2 * d))
    B[:, 0, 0] = (x[:, None] @ G[:, 0])[:, 0]
    N = np.zeros((1 + twists, 3, 3))
    N[0] = np.eye(3)
    D = np.zeros((len(L), 1 + twists, 1 + twists))
    D[:, 0, 0] = section.material.youngs_modulus * section.area * L
    if twists:
        B[:, 0, 1, 3:6], B[:, 0, 1, 9:] = -x, x
        D[:, 1, 1] = section.material.shear_modulus * section.J / L
    return QuadraticStrain(dofs=dofs, B=B, G=G, N=N, D=D, w=np.ones((len(L), 1)))


def rod_mass(ends: FloatArray, nodes: NDArray[np.int64], section: RodSection) -> CellMass:
    """Consistent mass of rods, m L/6 (1 + delta_ab), without rotary inertia."""
    L = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert section.mass_per_length is not None  # set when left out
    return CellMass(nodes, section.mass_per_length * L[:, None, None] / 6 * (1 + np.eye(2)))
