"""Superelements: linear bodies from the matrices of another program, condensed or not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from supple.body.checks import MatrixLike
from supple.body.flexible_body import FlexibleBody
from supple.body.free_body import RIGID_TOLERANCE, free_body
from supple.body.interface import AveragingInterface, RigidInterface
from supple.body.recovery import Recovery
from supple.errors import ModelError
from supple.importers import read_matrix

__all__ = ["read_superelement", "superelement"]


def superelement(
    name: str,
    nodes: ArrayLike,
    stiffness: MatrixLike,
    mass: MatrixLike,
    *,
    dofs_per_node: int,
    damping: MatrixLike | None = None,
    interfaces: Sequence[RigidInterface | AveragingInterface] = (),
    recovery: Recovery | None = None,
    rigid_tolerance: float = RIGID_TOLERANCE,
) -> FlexibleBody:
    """A linear body from nodes and matrices, full or condensed.

    Matrix rows after those of the nodes are modal coordinates of a condensed model (Craig-Bampton). The body
    must be free: K R = 0 for its rigid motions R, in which all modal coordinates are zero. The matrices do
    not define the displacement field of a modal coordinate. Without `recovery`, modal displacements therefore
    have no centrifugal and Coriolis forces and do not change the body's inertia. Angular velocities must then
    be well below the frequencies of the modes. Recovered points throughout the body define this field
    (`Recovery`).

    Parameters
    ----------
    nodes           : (N, 3) m, positions of the nodes
    stiffness, mass : sparse or dense (n, n), n >= N * dofs_per_node, node by node: ux uy uz [rx ry rz], then
        modal coordinates
    dofs_per_node   : 3 or 6
    damping         : (n, n) N s/m, positive semidefinite, rows as in the stiffness; None: no damping matrix
    interfaces      : as for `flexible_body`, but only with node numbers
    recovery        : interior points of a condensed model, which become the last nodes of the body
    rigid_tolerance : largest accepted |K R| and |C R| in a row, relative to the forces that cancel in this
        row; also the largest accepted negative eigenvalue of the damping matrix C, relative to its largest
        entry after scaling by 1/sqrt(K_ii). Give about the relative precision of the printed matrices
    Raises
    ------
    ModelError   as for `flexible_body`; other values of `dofs_per_node`; an interface on a node set; damping
                 that resists rigid motion or adds energy; a recovery matrix that does not fit the body
    """
    if dofs_per_node not in (3, 6):
        raise ModelError(f"body '{name}': {dofs_per_node} freedoms per node; only 3 and 6 are possible")
    for interface in interfaces:
        if isinstance(interface.nodes, str):
            raise ModelError(
                f"body '{name}': interface '{interface.name}' names the node set '{interface.nodes}', but a "
                "superelement has no node sets; give node numbers"
            )
    points = np.array(nodes, dtype=np.float64)
    n_modal = max(np.shape(stiffness)[0] - len(points) * dofs_per_node, 0)
    rotations = None
    if dofs_per_node == 6:
        rows = (6 * np.arange(len(points))[:, None] + np.arange(3, 6)).ravel()
        rotations = sparse.csr_array(sparse.eye_array(6 * len(points)))[rows].tocsc()
    return free_body(
        name,
        points,
        stiffness,
        mass,
        dofs_per_node=dofs_per_node,
        nodal_damping=damping,
        n_modal=n_modal,
        recovery=recovery,
        interfaces=tuple(interfaces),
        rotation_operator=rotations,
        rigid_tolerance=rigid_tolerance,
    )


def read_superelement(
    name: str,
    *,
    nodes: str | Path,
    stiffness: str | Path,
    mass: str | Path,
    dofs_per_node: int,
    damping: str | Path | None = None,
    interfaces: Sequence[RigidInterface | AveragingInterface] = (),
    recovery: str | Path | None = None,
    points: str | Path | None = None,
    rigid_tolerance: float = RIGID_TOLERANCE,
) -> FlexibleBody:
    """A linear body from Matrix Market files, as for `superelement`.

    nodes : file of a dense (N, 3) array, m
    recovery, points : files of the recovery matrix (3 P, n) and of the positions (P, 3) of interior points of
        a condensed model; give both or neither
    Raises ImportFormatError for a file that is not Matrix Market; ModelError as for `superelement`, naming
    the files; only one of `recovery` and `points`.
    """
    positions, K, M = read_matrix(nodes).toarray(), read_matrix(stiffness), read_matrix(mass)
    interior = None
    if (recovery is None) != (points is None):
        given, other = ("points", "recovery") if recovery is None else ("recovery", "points")
        raise ModelError(f"superelement '{name}': {given} without {other}: give both files, or neither")
    if recovery is not None and points is not None:
        interior_points = read_matrix(points).toarray()
        ids = len(positions) + np.arange(len(interior_points))
        interior = Recovery(interior_points, ids, read_matrix(recovery).toarray())
    try:
        return superelement(
            name,
            positions,
            K,
            M,
            dofs_per_node=dofs_per_node,
            damping=None if damping is None else read_matrix(damping),
            interfaces=interfaces,
            recovery=interior,
            rigid_tolerance=rigid_tolerance,
        )
    except ModelError as error:
        raise ModelError(f"{error} (read from {nodes}, {stiffness}, {mass})") from error
