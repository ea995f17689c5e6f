"""HDF5 files of nodes, freedoms, stiffness, mass and damping, for programs without another export.

/nodes                 (N, 3) float     positions
/node_ids              (N,) int         labels; default 1 .. N
/freedoms              (n, 2) int       node id and component (1 to 6) of each row; 0: a modal coordinate
/stiffness, /mass      groups with data, indices, indptr of a compressed sparse column matrix (n, n)
/damping               likewise; optional
/node_sets/NAME        (k,) int         node ids; optional

The file may come from other programs, so it is copied before reading: see `copied_hdf5`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from supple.copied_hdf5 import open_copied
from supple.errors import ImportFormatError
from supple.importers.matrices.labelled_matrix import SINGLE_PRECISION, LabelledMatrix, MatrixRole
from supple.importers.node_table import NodeTable
from supple.importers.numbering import first_repeated, positions_of_ids
from supple.importers.text_file import is_file


def read_hdf5_nodes(path: str | Path) -> NodeTable:
    """Nodes and node sets of an HDF5 file of matrices.

    Raises
    ------
    ImportFormatError   missing, cut or foreign file; missing datasets or datasets of a wrong shape; ids given
                        twice; sets with unknown nodes
    """
    path = Path(path)
    with opened(path, ("nodes", "node_ids", "node_sets")) as file:
        positions = array_of(file, path, "nodes", np.float64)
        if positions.ndim != 2 or positions.shape[1] != 3 or not np.isfinite(positions).all():
            raise ImportFormatError(
                f"{path}: /nodes has shape {positions.shape}; write (N, 3), all finite numbers"
            )
        N = len(positions)
        ids = array_of(file, path, "node_ids", np.int64) if "node_ids" in file else np.arange(1, N + 1)
        if ids.shape != (N,):
            raise ImportFormatError(
                f"{path}: /node_ids has shape {ids.shape}, /nodes {N} rows; write one id per node"
            )
        second = first_repeated(ids)
        if second is not None:
            raise ImportFormatError(f"{path}: node id {ids[second]} is given twice in /node_ids; renumber it")
        sets = {}
        group = file.get("node_sets")
        for name in group if isinstance(group, h5py.Group) else ():
            wanted = array_of(file, path, f"node_sets/{name}", np.int64)
            sets[name], known = positions_of_ids(ids, wanted)
            if not known.all():
                raise ImportFormatError(
                    f"{path}: node set '{name}' names node {wanted[~known][0]}, which /node_ids lacks; "
                    "correct the set"
                )
    return NodeTable(str(path), ids, positions, node_sets=sets)


def read_hdf5_matrix(path: str | Path, role: MatrixRole) -> LabelledMatrix:
    """The stiffness, mass or damping of an HDF5 file of matrices.

    Raises
    ------
    ImportFormatError   missing, cut or foreign file; missing datasets or datasets of a wrong shape; indices
                        outside the matrix or given twice; errors of `LabelledMatrix`
    """
    path = Path(path)
    source = f"{path}, /{role.label}"
    with opened(path, ("freedoms", role.label)) as file:
        freedoms = array_of(file, path, "freedoms", np.int64)
        if freedoms.ndim != 2 or freedoms.shape[1] != 2:
            raise ImportFormatError(
                f"{path}: /freedoms has shape {freedoms.shape}; write (n, 2): node id, component"
            )
        data = array_of(file, path, f"{role.label}/data", np.float64)
        is_single = file[f"{role.label}/data"].dtype == np.float32
        indices, indptr = (
            array_of(file, path, f"{role.label}/{part}", np.int64) for part in ("indices", "indptr")
        )
    n = len(indptr) - 1
    if (
        indices.shape != data.shape
        or indptr.ndim != 1
        or not indptr.size
        or indptr[0] != 0
        or indptr[-1] != len(data)
        or (np.diff(indptr) < 0).any()
    ):
        raise ImportFormatError(
            f"{source}: data, indices and indptr do not fit each other ({len(data)}, {len(indices)}, last "
            f"of indptr {indptr[-1] if indptr.size else 'missing'}); write those of a csc matrix"
        )
    largest = int(indices.max(initial=0))
    if largest >= n or indices.min(initial=0) < 0:
        raise ImportFormatError(
            f"{source}: row index {largest} in a matrix of {n} columns; write a square matrix"
        )
    places = np.repeat(np.arange(n), np.diff(indptr)) * n + indices
    second = first_repeated(places)
    if second is not None:
        raise ImportFormatError(
            f"{source}: the entry of row {indices[second]} and column {places[second] // n} (from 0) is "
            "given twice; sum them up (scipy: sum_duplicates)"
        )
    resolution = SINGLE_PRECISION if is_single else float(np.finfo(float).eps)
    return LabelledMatrix(source, csc_array((data, indices, indptr), shape=(n, n)), freedoms, resolution)


@contextmanager
def opened(path: Path, parts: Collection[str]) -> Iterator[h5py.File]:
    """A copy of these parts of the file; ImportFormatError if it is missing or damaged."""
    if not is_file(path):
        raise ImportFormatError(f"{path}: no such file; check its name and folder")
    try:
        with open_copied(path, parts) as file:
            yield file
    except ImportFormatError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError) as error:
        raise ImportFormatError(f"{path}: not readable as HDF5 ({error}); is it cut short?") from error


def array_of(file: h5py.File, path: Path, name: str, dtype: type) -> NDArray:
    """A dataset; ImportFormatError if it is missing, or of another number type."""
    dataset = file.get(name)
    if not isinstance(dataset, h5py.Dataset):
        raise ImportFormatError(
            f"{path}: no dataset /{name}; a file of matrices holds /nodes, /freedoms, and data, indices, "
            "indptr below /stiffness and /mass"
        )
    if not np.can_cast(dataset.dtype, dtype, "same_kind"):
        raise ImportFormatError(f"{path}: /{name} holds {dataset.dtype} values; write {np.dtype(dtype)}")
    return dataset[()].astype(dtype)
