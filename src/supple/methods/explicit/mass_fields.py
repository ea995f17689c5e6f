"""Vector fields that carry the mass of a body: its nodes, and directors of nodes with rotations.

A node with rotations has three unit directors e_d, which rotate with it. Their rates have the kinetic energy
of an isotropic rotary inertia J, since sum_d |theta x e_d|^2 = 2 |theta|^2:

    1/2 m |x'|^2 + 1/2 (J/2) sum_d |d'_d|^2

A director is a direction, so its weights on the frame's points sum to zero. Nodal rotations need no separate
equations, and momentum and energy are conserved as for nodes without rotations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from supple.arrays import FloatArray
from supple.body import FlexibleBody
from supple.body.rigid_motion import cross_of_axes
from supple.errors import ModelError
from supple.methods.explicit.frame_points import CORNERS, FramePoints


@dataclass(frozen=True, eq=False)
class MassFields:
    """F vectors x_f = sum_a (w_fa + CORNERS_a Phi_f y) x_a with the mass matrix between them.

    weights : (F, 4)        on the four points
    shapes : (F, 3, k)      local displacement per modal coordinate, in units of the arm
    mass : sparse (F, F)    kg, equal for the three directions
    """

    weights: FloatArray
    shapes: FloatArray
    mass: sparse.csr_array


def mass_fields(body: FlexibleBody, points: FramePoints, vectors: FloatArray) -> MassFields:
    """Fields of a body whose deformation is `vectors @ y`.

    vectors : (n, k)    in the coordinates of the body
    Raises ModelError for a mass that differs between directions, as for beams or imported matrices.
    """
    d = body.dofs_per_node
    nodal = (body.expansion @ vectors).reshape(len(body.nodes), d, -1) / points.arm
    translational = isotropic_part(body, body.nodal_mass, slice(0, 3))
    weights, shapes, masses = [points.weights(body.nodes)], [nodal[:, :3]], [translational]
    if d == 6:
        rotary = isotropic_part(body, body.nodal_mass, slice(3, 6))
        for axis in np.eye(3):
            turn = cross_of_axes(axis)  # theta -> theta x e_d
            weights.append(np.tile(CORNERS @ axis / points.arm, (len(body.nodes), 1)))
            shapes.append(turn @ nodal[:, 3:])
            masses.append(0.5 * rotary)
    return MassFields(
        np.concatenate(weights), np.concatenate(shapes), sparse.csr_array(sparse.block_diag(masses))
    )


def isotropic_part(body: FlexibleBody, mass: sparse.csc_array, part: slice) -> sparse.csr_array:
    """The (N, N) mass matrix common to all directions; ModelError where directions differ or are coupled."""
    matrix = sparse.csr_array(mass)
    d = body.dofs_per_node
    rows = [np.arange(i, body.n_nodal, d) for i in range(part.start, part.stop)]
    first = matrix[rows[0]][:, rows[0]]
    scale = abs(first).max()
    for i, own in enumerate(rows):
        for j, other in enumerate(rows):
            difference = matrix[own][:, other] - (first if i == j else 0 * first)
            if abs(difference).max() > 1e-9 * scale:
                raise ModelError(
                    f"body '{body.name}': the mass of its nodes differs between directions, or couples them; "
                    "a modal sub-domain needs a mesh of solids or shells"
                )
    return sparse.csr_array(first)
