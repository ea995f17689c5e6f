"""Condensation of a finite element body to intrinsic modes, by stations along its load paths."""

from __future__ import annotations

import numpy as np
from scipy import linalg, sparse

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.body import Damping, FlexibleBody
from supple.errors import ModelError
from supple.fem import Attached, refuse_attached
from supple.methods.intrinsic.condensed_line import CondensedLine, condensed_line
from supple.methods.intrinsic.expansion import carried_by_stations
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody
from supple.methods.intrinsic.intrinsic_modes import intrinsic_modes
from supple.methods.intrinsic.load_path import StationPlan
from supple.methods.intrinsic.load_path_tree import load_path_tree
from supple.methods.intrinsic.lumped_inertia import lumped_inertia
from supple.methods.intrinsic.root_support import CLAMPED, RootSupport

__all__ = ["condense"]

SOFT = 1e-2
"""Smallest deflection of a direction in `_lumping_error`, relative to that of the softest direction."""


@checked_arguments
def condense(
    body: FlexibleBody,
    path: StationPlan,
    *,
    support: RootSupport = CLAMPED,
    n_modes: int | None = None,
    damping: Damping | None = None,
) -> IntrinsicBody:
    """Slender body in its intrinsic modes, for arbitrary rotations, from the linear model alone.

    The elements are condensed statically on the stations (Guyan), by one sparse factorisation. The inertia is
    lumped on the stations, with exact mass, first and second moments. The modes of this line on the support
    of the root are the coordinates of the body. K is the stiffness of the elements, and B maps coordinates of
    the elements to motions of the stations. The static shapes Psi and the condensed stiffness K_a follow from

        K Psi + B^T mu = 0,   B Psi = 1,   K_a = Psi^T K Psi

    Parameters
    ----------
    body : FlexibleBody     shells, solids or beams
    path : LoadPath("root", "tip", n_stations=40), LoadPaths for several, or NodeSetPath
    support : RootSupport   motions of the root that its joint leaves free: CLAMPED (also where a joint
                            prescribes its motion), FREE, BALL, hinged(axis) or sliding(axis)
    n_modes : int           number of lowest elastic modes, extended by second-order modes; default all
    damping : ModalDamping | RayleighDamping | None

    Raises
    ------
    ModelError      no elements; dashpots; masses shared by several nodes; stations that the mesh does not
                    allow; and as `intrinsic_modes`
    Source: [Wang2015] section 3; [Guyan1965].
    """
    if body.model is None:
        raise ModelError(
            f"body '{body.name}' is defined by matrices, without the position of its mass: pass the matrices "
            "of its stations to condensed_line instead"
        )
    refuse_attached(Attached(damping=body.model.attached.damping), f"the line of body '{body.name}'")
    interfaces, parents = path.stations(body)
    points = np.array([interface.position for interface in interfaces])
    tree = load_path_tree(points, parents)
    rows = sparse.csr_array(sparse.vstack([interface.motion for interface in interfaces]))
    shapes, stiffness = _statics(body, rows)
    line = condensed_line(
        body.name,
        points,
        stiffness,
        linalg.block_diag(*lumped_inertia(tree, body.model)),
        parents=parents,
    )
    modes = intrinsic_modes(line, support)
    elastic = modes.velocities[..., modes.n_rigid :]
    nodal = body.expansion @ (shapes @ elastic.reshape(6 * line.n, -1))
    expansion = carried_by_stations(
        tree, body.nodes, nodal.reshape(len(body.nodes), body.dofs_per_node, -1), elastic
    )
    names = {interface.name: number for number, interface in enumerate(interfaces)}
    names |= {f"station {number}": number for number in range(line.n)}
    whole = IntrinsicBody(modes, expansion, names, damping, lumping_error=_lumping_error(body, line, shapes))
    return whole if n_modes is None else whole.truncated(n_modes)


def _lumping_error(body: FlexibleBody, line: CondensedLine, shapes: FloatArray) -> float:
    """Relative error, due to the lumped mass, of deflections under the weight; the root is clamped.

    The exact deflections are those under the forces Psi^T M a: M is the mass of the elements, and a are unit
    accelerations in three directions. The error of a direction is the norm of the error of the stations'
    displacements, divided by the norm of their exact displacements. The result is the largest error, without
    directions in which the body is stiff (`SOFT`).
    """
    directions = slice(0, 3)
    exact = shapes.T @ (body.mass @ body.rigid_modes[:, directions])
    lumped = line.mass @ line.twists[:, directions]
    K = line.stiffness[6:, 6:]
    scale = 1 / np.sqrt(np.diag(K))
    factor = linalg.cho_factor(K * np.outer(scale, scale))

    def deflection(forces: FloatArray) -> FloatArray:
        moved = scale[:, None] * linalg.cho_solve(factor, scale[:, None] * forces[6:])
        return np.linalg.norm(moved.reshape(-1, 6, 3)[:, :3], axis=(0, 1))

    deflections, errors = deflection(exact), deflection(lumped - exact)
    soft = deflections > SOFT * deflections.max(initial=0.0)
    return float((errors[soft] / deflections[soft]).max(initial=0.0))


def _statics(body: FlexibleBody, rows: sparse.csr_array) -> tuple[FloatArray, FloatArray]:
    """Static shapes Psi (n, 6 s) of unit motions of s stations, and the condensed stiffness (6 s, 6 s)."""
    unit = np.eye(rows.indptr.size - 1)
    if len(unit) == body.n:  # stations with all freedoms leave no freedom to condense
        shapes = np.linalg.solve(rows.toarray(), unit)
        return shapes, shapes.T @ (body.stiffness @ shapes)
    shapes, forces = body.constrained(rows).solve_with_multipliers(values=unit)
    return shapes, -0.5 * (forces + forces.T)
