"""Recovery matrices (OTM): displacements of inner points of a condensed model from its freedoms.

HDF5, beside the matrices of `hdf5_matrices`:

/recovery/points       (P, 3) float     positions
/recovery/ids          (P,) int         labels; default 1 .. P
/recovery/matrix       (3 P, n) float   ux uy uz of each point, columns as /freedoms

OUTPUT4: a matrix with three or six rows for each grid of the mesh file that is not in the analysis set, in
ascending order of ids, and one column for each freedom of the analysis set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.matrices.hdf5_matrices import array_of, opened
from supple.importers.matrices.matrix_file import HDF5_SUFFIXES
from supple.importers.matrices.output4 import named_matrix
from supple.importers.node_table import NodeTable
from supple.importers.numbering import positions_of_ids

__all__ = ["RecoveryMatrix", "read_recovery"]


@dataclass(frozen=True, eq=False)
class RecoveryMatrix:
    """Ids (P,), positions (P, 3); matrix (3 P, n), a column for each freedom (node id, component)."""

    source: str
    ids: IntArray
    points: FloatArray
    matrix: FloatArray
    freedoms: IntArray


def read_recovery(path: str | Path, nodes: NodeTable, *, name: str | None = None) -> RecoveryMatrix:
    """The recovery matrix of an HDF5 or OUTPUT4 (.op4, .op2) file.

    nodes : node table of the mesh file;  name : name of the matrix, required for OUTPUT4

    Raises
    ------
    ImportFormatError   files of another kind; a matrix size that does not fit the points and freedoms
    """
    path = Path(path)
    if path.suffix.lower() in HDF5_SUFFIXES:
        return _of_hdf5(path)
    if name is None:
        raise ImportFormatError(f"{path}: name the recovery matrix to take (recovery_name); HDF5 needs none")
    return _of_output4(path, nodes, name)


def _of_hdf5(path: Path) -> RecoveryMatrix:
    with opened(path, ("freedoms", "recovery")) as file:
        freedoms = array_of(file, path, "freedoms", np.int64)
        points = array_of(file, path, "recovery/points", np.float64)
        matrix = array_of(file, path, "recovery/matrix", np.float64)
        known = "recovery/ids" in file
        ids = array_of(file, path, "recovery/ids", np.int64) if known else np.arange(1, len(points) + 1)
    wanted = 3 * len(points), len(freedoms)
    if points.shape != (len(ids), 3) or matrix.shape != wanted:
        raise ImportFormatError(
            f"{path}: /recovery holds points {points.shape}, {len(ids)} ids and a matrix {matrix.shape}; "
            f"write points (P, 3) and a matrix (3 P, {len(freedoms)}), rows ux uy uz of each point, "
            "columns as /freedoms"
        )
    return RecoveryMatrix(f"{path}, /recovery", ids, points, matrix, freedoms)


def _of_output4(path: Path, nodes: NodeTable, name: str) -> RecoveryMatrix:
    source, matrix = named_matrix(path, name)
    retained = nodes.retained
    if retained is None or len(retained) != matrix.shape[1]:
        n = 0 if retained is None else len(retained)
        raise ImportFormatError(
            f"{source}: {matrix.shape[1]} columns, but the analysis set of {nodes.source} has {n} freedoms; "
            "add its ASET, BSET, QSET and SPOINT cards to the mesh file"
        )
    ids = np.setdiff1d(nodes.ids, retained[:, 0])
    each = matrix.shape[0] // max(len(ids), 1)
    if each not in (3, 6) or each * len(ids) != matrix.shape[0]:
        raise ImportFormatError(
            f"{source}: {matrix.shape[0]} rows, but {len(ids)} grids of {nodes.source} are not in the "
            "analysis set; a recovery matrix has three or six rows for each of them, by their ids"
        )
    number, _ = positions_of_ids(nodes.ids, ids)
    moved = matrix.toarray().reshape(len(ids), each, -1)[:, :3]
    if nodes.axes is not None:
        moved = nodes.axes[number] @ moved
    flat = moved.reshape(3 * len(ids), -1)
    return RecoveryMatrix(source, ids, nodes.positions[number], flat, retained)


def in_order(recovery: RecoveryMatrix, freedoms: IntArray) -> RecoveryMatrix:
    """The recovery matrix with a column for each of the freedoms (m, 2), in order; missing columns are zero.

    Raises
    ------
    ImportFormatError   a column that is not zero belongs to a freedom that is not given
    """
    place = {tuple(freedom): i for i, freedom in enumerate(freedoms.tolist())}
    found = np.array(
        [place.get(tuple(freedom), -1) for freedom in recovery.freedoms.tolist()], dtype=np.int64
    )
    lost = np.flatnonzero((found < 0) & recovery.matrix.any(axis=0))
    if lost.size:
        node, component = recovery.freedoms[lost[0]]
        raise ImportFormatError(
            f"{recovery.source}: a column of node {node} component {component}, which the matrices lack; "
            "take all from the same run"
        )
    matrix = np.zeros((len(recovery.matrix), len(freedoms)))
    matrix[:, found[found >= 0]] = recovery.matrix[:, found >= 0]
    return replace(recovery, matrix=matrix, freedoms=freedoms)
