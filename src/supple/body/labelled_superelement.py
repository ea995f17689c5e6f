"""Superelements from labelled matrices: rows identified by node id and component, in the mesh axes.

Freedoms without a node (scalar points, QSET) are modal coordinates of a condensed model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.arrays import IntArray
from supple.body.flexible_body import FlexibleBody
from supple.body.free_body import RIGID_TOLERANCE
from supple.body.interface import AveragingInterface, RigidInterface, connection_interface
from supple.body.recovery import Recovery
from supple.body.superelement import superelement
from supple.errors import ModelError
from supple.importers import (
    Connection,
    LabelledMatrix,
    MatrixRole,
    NodeTable,
    RecoveryMatrix,
    freedom_name,
    positions_of_ids,
    read_labelled_matrix,
    read_nodes,
    read_recovery,
)
from supple.importers.matrices.recovery_matrix import in_order

__all__ = [
    "MatrixFiles",
    "NodalMatrices",
    "labelled_superelement",
    "nodal_matrices",
    "read_labelled_superelement",
    "read_nodal_matrices",
]

# Residual of a row of K R, with some hundred printed entries, relative to the rounding error of one entry.
ROUNDED_ROWS = 100.0


@dataclass(frozen=True, eq=False)
class NodalMatrices:
    """Matrices in the mesh axes: rows of the nodes with stiffness or mass, then of modal coordinates.

    source          : name of the stiffness file, for messages
    nodes           : (N, 3);  node_ids : (N,) ids in the files
    stiffness, mass : csc (n, n), n = N * dofs_per_node + n_modal
    damping         : csc (n, n); None without
    node_sets       : {name: node numbers};  connections : RBE2 and RBE3 elements on these nodes
    resolution      : largest relative rounding error of a matrix entry
    modal           : (n_modal, 2) id and component of modal coordinates, component 0 for scalar points
    recovery        : recovery of interior points; None without
    """

    source: str
    nodes: NDArray[np.float64]
    node_ids: IntArray
    dofs_per_node: int
    stiffness: sparse.csc_array = field(repr=False)
    mass: sparse.csc_array = field(repr=False)
    node_sets: dict[str, IntArray] = field(repr=False)
    connections: tuple[Connection, ...]
    resolution: float
    modal: IntArray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    recovery: Recovery | None = field(default=None, repr=False)
    damping: sparse.csc_array | None = field(default=None, repr=False)

    @property
    def all_ids(self) -> IntArray:
        """Ids of the nodes of the body: matrix nodes, then recovered points."""
        return self.node_ids if self.recovery is None else np.concatenate([self.node_ids, self.recovery.ids])

    @property
    def rigid_tolerance(self) -> float:
        """Largest |K R| due to rounding of printed digits, relative to the forces that cancel in it.

        At least RIGID_TOLERANCE.
        """
        return max(RIGID_TOLERANCE, ROUNDED_ROWS * self.resolution)


@dataclass(frozen=True)
class MatrixFiles:
    """Files of a linear body from another program, full or condensed.

    A condensed model has boundary grids and modal coordinates (Craig-Bampton). QSET and SPOINT cards of the
    mesh file, or the component 0 in the matrix file, define the modal coordinates. See `superelement`.

    nodes           : mesh file: Abaqus or CalculiX .inp, Nastran .bdf, or HDF5
    stiffness, mass : DMIG .pch, OUTPUT4 .op4, OUTPUT2 .op2, HDF5, Abaqus .mtx, CalculiX .sti and .mas
    damping         : file of a format as for stiffness and mass; None without
    recovery        : HDF5 or OUTPUT4 file of the recovery matrix of interior points, which become nodes; None
        without
    stiffness_name, mass_name, damping_name, recovery_name : names of the matrices in files with several
        matrices (DMIG, OUTPUT4)
    """

    nodes: str | Path
    stiffness: str | Path
    mass: str | Path
    damping: str | Path | None = None
    recovery: str | Path | None = None
    stiffness_name: str | None = None
    mass_name: str | None = None
    damping_name: str | None = None
    recovery_name: str | None = None


def read_labelled_superelement(
    name: str,
    files: MatrixFiles,
    interfaces: Sequence[RigidInterface | AveragingInterface] | None = None,
) -> FlexibleBody:
    """A linear body from the matrices of another program and the file of its nodes, full or condensed.

    interfaces : on node sets of the mesh file, or node numbers; None: one for each RBE2 and RBE3 element of
        the mesh file. If it has none, and the model has modal coordinates and nodal rotations, each boundary
        grid becomes a rigid interface grid_ID
    Raises
    ------
    ImportFormatError   files that cannot be read
    ModelError          as for `nodal_matrices` and `superelement`
    """
    return labelled_superelement(name, read_nodal_matrices(files), interfaces)


def read_nodal_matrices(files: MatrixFiles) -> NodalMatrices:
    """The matrices of the files in the mesh axes, from which `labelled_superelement` builds a body.

    Raises ImportFormatError for files that cannot be read; ModelError as for `nodal_matrices`.
    """
    table = read_nodes(files.nodes)

    def matrix(path: str | Path, role: MatrixRole, name: str | None) -> LabelledMatrix:
        return read_labelled_matrix(path, role, table, name=name)

    recovery, damping = files.recovery, files.damping
    return nodal_matrices(
        table,
        matrix(files.stiffness, MatrixRole.STIFFNESS, files.stiffness_name),
        matrix(files.mass, MatrixRole.MASS, files.mass_name),
        None if recovery is None else read_recovery(recovery, table, name=files.recovery_name),
        None if damping is None else matrix(damping, MatrixRole.DAMPING, files.damping_name),
    )


def labelled_superelement(
    name: str,
    matrices: NodalMatrices,
    interfaces: Sequence[RigidInterface | AveragingInterface] | None = None,
    *,
    rigid_tolerance: float | None = None,
) -> FlexibleBody:
    """A linear body from nodal matrices; interfaces as for `read_labelled_superelement`.

    rigid_tolerance : as for `superelement`; None: from the resolution of the matrices
    Raises ModelError for an unknown node set; as for `superelement`, with the name of the file.
    """
    if interfaces is None:
        interfaces = [connection_interface(connection) for connection in matrices.connections]
        if not interfaces and len(matrices.modal) and matrices.dofs_per_node == 6:
            ids = matrices.node_ids.tolist()
            interfaces = [RigidInterface(f"grid_{label}", [i]) for i, label in enumerate(ids)]
    resolved = [
        replace(given, nodes=_node_set(matrices, given.nodes)) if isinstance(given.nodes, str) else given
        for given in interfaces
    ]
    try:
        return superelement(
            name,
            matrices.nodes,
            matrices.stiffness,
            matrices.mass,
            dofs_per_node=matrices.dofs_per_node,
            interfaces=resolved,
            damping=matrices.damping,
            recovery=matrices.recovery,
            rigid_tolerance=matrices.rigid_tolerance if rigid_tolerance is None else rigid_tolerance,
        )
    except ModelError as error:
        raise ModelError(f"{error} (read from {matrices.source})") from error


def nodal_matrices(
    nodes: NodeTable,
    stiffness: LabelledMatrix,
    mass: LabelledMatrix,
    recovery: RecoveryMatrix | None = None,
    damping: LabelledMatrix | None = None,
) -> NodalMatrices:
    """Labelled matrices in node order and mesh axes: three or six rows for each node, then modal coordinates.

    Nodes without stiffness and mass (reference points) are omitted. All rotations are omitted if no node has
    entries for them (solids, in programs whose nodes always have six freedoms); otherwise nodes without such
    entries have zero rows for their rotations, which `coordinates` fixes.

    Raises ModelError for freedoms of nodes that the mesh file does not define; nodes with only some of their
    translations; only modal coordinates, from a model with a clamped boundary; zero matrices; component 0 of
    a grid; ImportFormatError for a recovery matrix for other freedoms.
    """
    given = [stiffness, mass, *([] if damping is None else [damping])]
    modal = _modal_freedoms(nodes, *given)
    K, M, *C = (_on_all_freedoms(nodes, modal, matrix) for matrix in given)
    n_all = 6 * len(nodes.ids)
    used = ((abs(K).sum(axis=1) + abs(M).sum(axis=1)) > 0)[:n_all].reshape(-1, 6)
    kept = used.any(axis=1)
    if not kept.any():
        raise ModelError(
            f"{stiffness.source}: {len(modal)} modal coordinates, and no freedom of a node: the model was "
            "clamped at its boundary. Condense it again with its boundary grids free and kept (BSET, ASET)"
            if len(modal)
            else f"{stiffness.source}: no freedom has any stiffness or mass; check the name of the matrix"
        )
    dofs_per_node = 6 if used[:, 3:].any() else 3
    missing = np.argwhere(kept[:, None] & ~used[:, :3])
    if missing.size:
        node, component = missing[0]
        raise ModelError(
            f"{stiffness.source}: {freedom_name(int(nodes.ids[node]), int(component) + 1)} has neither "
            f"stiffness nor mass, while other freedoms have ({len(missing)} such in all). A body needs all "
            "translations of every node: export the matrices free, without supports, and name modal "
            "coordinates on grids in a QSET"
        )
    of_nodes = np.flatnonzero(np.repeat(kept, 6) & np.tile(np.arange(6) < dofs_per_node, len(kept)))
    freedoms = np.concatenate([of_nodes, n_all + np.arange(len(modal))])
    number = np.cumsum(kept) - 1
    labels = np.concatenate([np.column_stack([nodes.ids[of_nodes // 6], of_nodes % 6 + 1]), modal])
    T = None if recovery is None else in_order(recovery, labels).matrix
    K, M, *C = (matrix[freedoms][:, freedoms] for matrix in (K, M, *C))
    if nodes.axes is not None:
        axes = np.repeat(nodes.axes[kept], dofs_per_node // 3, axis=0)
        turn = sparse.bsr_array((axes, np.arange(len(axes)), np.arange(len(axes) + 1)))
        turn = sparse.csr_array(sparse.block_diag([turn, sparse.eye_array(len(modal))], format="csr"))
        K, M, *C = (turn @ matrix @ turn.T for matrix in (K, M, *C))
        T = None if T is None else T @ turn.T
    sets = {name: number[members[kept[members]]] for name, members in nodes.node_sets.items()}
    return NodalMatrices(
        source=stiffness.source,
        nodes=nodes.positions[kept],
        node_ids=nodes.ids[kept],
        dofs_per_node=dofs_per_node,
        stiffness=_symmetric(K),
        mass=_symmetric(M),
        node_sets={name: members for name, members in sets.items() if members.size},
        connections=tuple(made for c in nodes.connections if (made := _on_kept(c, kept, number)) is not None),
        resolution=max(matrix.resolution for matrix in given),
        modal=modal,
        recovery=None if recovery is None or T is None else Recovery(recovery.points, recovery.ids, T),
        damping=_symmetric(C[0]) if C else None,
    )


def _modal_freedoms(nodes: NodeTable, *matrices: LabelledMatrix) -> IntArray:
    """Modal freedoms (k, 2), id and component: component 0 (scalar points), and freedoms in a QSET.

    ModelError for component 0 of a grid, if the node file lists modal freedoms.
    """
    labels = np.unique(np.concatenate([matrix.freedoms for matrix in matrices]), axis=0)
    width = 7
    is_modal = np.isin(labels @ [width, 1], nodes.modal @ [width, 1]) | (labels[:, 1] == 0)
    modal = labels[is_modal]
    grids = np.flatnonzero((modal[:, 1] == 0) & positions_of_ids(nodes.ids, modal[:, 0])[1])
    # Without QSET or SPOINT cards, as in HDF5 files, the ids of modal coordinates may equal those of grids.
    if grids.size and len(nodes.modal):
        raise ModelError(
            f"{matrices[0].source}: component 0 of grid {modal[grids[0], 0]}, which is not a scalar point; "
            "correct it"
        )
    return modal


def _on_all_freedoms(nodes: NodeTable, modal: IntArray, labelled: LabelledMatrix) -> sparse.csr_array:
    """The matrix over six freedoms of every node of the table, then over the modal coordinates.

    ModelError for a node that is not in the table.
    """
    n_nodes, width = len(nodes.ids), 7
    key, modal_key = labelled.freedoms @ [width, 1], modal @ [width, 1]
    own = np.isin(key, modal_key)
    number, known = positions_of_ids(nodes.ids, labelled.freedoms[~own, 0])
    if not known.all():
        raise ModelError(
            f"{labelled.source}: has node {labelled.freedoms[~own][~known][0, 0]}, which {nodes.source} "
            "does not define; take nodes and matrices from the same model"
        )
    place = np.empty(len(key), dtype=np.int64)
    place[~own] = 6 * number + labelled.freedoms[~own, 1] - 1
    place[own] = 6 * n_nodes + np.searchsorted(modal_key, key[own])
    entries = labelled.matrix.tocoo()
    n = 6 * n_nodes + len(modal)
    return sparse.csr_array((entries.data, (place[entries.row], place[entries.col])), shape=(n, n))


def _on_kept(connection: Connection, kept: NDArray[np.bool_], number: IntArray) -> Connection | None:
    """The connection on the kept nodes; None for an RBE3 with omitted nodes or an RBE2 without kept nodes."""
    members = kept[connection.nodes]
    is_rigid = connection.weights is None
    if not (members.any() if is_rigid else members.all()):
        return None
    return replace(connection, nodes=number[connection.nodes[members]])


def _symmetric(matrix: sparse.csr_array) -> sparse.csc_array:
    return sparse.csc_array(0.5 * (matrix + matrix.T))


def _node_set(matrices: NodalMatrices, name: str) -> IntArray:
    if name not in matrices.node_sets:
        known = ", ".join(f"'{known}'" for known in matrices.node_sets) or "none"
        raise ModelError(f"{matrices.source}: no node set '{name}' in the mesh file; it has {known}")
    return matrices.node_sets[name]
