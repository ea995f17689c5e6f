"""HDF5 files of matrices: the documented layout, and every part of it broken."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from scipy.sparse import csc_array

from supple.errors import ImportFormatError
from supple.importers import MatrixRole
from supple.importers.matrices.hdf5_matrices import read_hdf5_matrix, read_hdf5_nodes

pytestmark = pytest.mark.usefixtures("hdf5_copied_here")
K = csc_array(np.array([[4.0, -1.0, 0], [-1, 3, 0], [0, 0, 2]]))


@pytest.fixture
def path(tmp_path):
    with h5py.File(tmp_path / "arm.h5", "w") as file:
        file["nodes"] = np.eye(2, 3)
        file["node_ids"] = [7, 3]
        file["freedoms"] = [[7, 1], [7, 2], [3, 1]]
        for part in ("data", "indices", "indptr"):
            file[f"stiffness/{part}"] = getattr(K, part)
        file["node_sets/tip"] = [3]
    return tmp_path / "arm.h5"


def test_the_layout(path):
    table = read_hdf5_nodes(path)
    np.testing.assert_array_equal(table.ids, [7, 3])
    np.testing.assert_array_equal(table.node_sets["tip"], [1])
    made = read_hdf5_matrix(path, MatrixRole.STIFFNESS)
    np.testing.assert_array_equal(made.matrix.toarray(), K.toarray())
    np.testing.assert_array_equal(made.freedoms, [[7, 1], [7, 2], [3, 1]])
    with h5py.File(path, "a") as file:
        del file["node_ids"], file["node_sets"]
    np.testing.assert_array_equal(read_hdf5_nodes(path).ids, [1, 2])


def test_single_precision_is_known_as_such(path):
    assert read_hdf5_matrix(path, MatrixRole.STIFFNESS).resolution < 1e-15
    with h5py.File(path, "a") as file:
        del file["stiffness/data"]
        file["stiffness/data"] = K.data.astype(np.float32)
    assert read_hdf5_matrix(path, MatrixRole.STIFFNESS).resolution == np.finfo(np.float32).eps


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("nodes", None, r"arm\.h5: no dataset /nodes; a file of matrices holds"),
        ("nodes", np.zeros((2, 2)), r"/nodes has shape \(2, 2\); write \(N, 3\)"),
        ("nodes", np.full((2, 3), np.nan), "/nodes has shape .* all finite"),
        ("nodes", np.array([[b"a"] * 3] * 2), "/nodes holds .* values; write float64"),
        ("node_ids", [1, 2, 3], r"/node_ids has shape \(3,\), /nodes 2 rows; write one id per node"),
        ("node_ids", [7, 7], "node id 7 is given twice"),
        ("node_sets/tip", [4], "node set 'tip' names node 4, which /node_ids lacks"),
        ("freedoms", None, "no dataset /freedoms"),
        ("freedoms", [1, 2, 3], r"/freedoms has shape \(3,\); write \(n, 2\)"),
        ("freedoms", [[7, 1], [7, 2]], r"the matrix has shape \(3, 3\), but its map names 2 freedoms"),
        ("stiffness", None, "no dataset /stiffness/data"),
        ("stiffness/indices", K.indices + 1, "row index 3 in a matrix of 3 columns"),
        ("stiffness/indptr", [0, 1, 2], "data, indices and indptr do not fit each other"),
        ("stiffness/indptr", np.empty(0, int), "data, indices and indptr do not fit each other"),
        (
            "stiffness/indices",
            np.array([*K.indices[:1], *K.indices[:-1]]),
            "the entry of row 0 and column 0 .from 0. is given twice; sum them up",
        ),
        ("stiffness/data", [4.0, -1, -2, 3, 2], "/stiffness: not symmetric"),
    ],
)
def test_every_part_broken(path, name, value, message):
    with h5py.File(path, "a") as file:
        del file[name]
        if value is not None:
            file[name] = value

    def read():
        read_hdf5_nodes(path)
        read_hdf5_matrix(path, MatrixRole.STIFFNESS)

    with pytest.raises(ImportFormatError, match=message):
        read()


def test_files_that_are_not_hdf5(tmp_path, path):
    with pytest.raises(ImportFormatError, match=r"absent\.h5: no such file"):
        read_hdf5_nodes(tmp_path / "absent.h5")
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(ImportFormatError, match=r"arm\.h5: not readable as HDF5.*cut short"):
        read_hdf5_nodes(path)
