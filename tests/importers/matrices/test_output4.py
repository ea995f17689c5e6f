"""OUTPUT4 files: the map that the mesh file implies, and files that break the format."""

from __future__ import annotations

import struct
import sys

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers import MatrixRole, NodeTable
from supple.importers.matrices.output4 import read_output4

NODES = NodeTable("arm.bdf", np.array([20, 10]), np.zeros((2, 3)))
ROOT = np.random.default_rng(0).normal(size=(12, 12))


@pytest.fixture
def written(tmp_path):
    op4 = pytest.importorskip("pyyeti.nastran.op4")

    def write(matrices, *, binary=True):
        path = tmp_path / "arm.op4"
        op4.write(str(path), matrices, binary=binary)
        return path

    return write


@pytest.mark.parametrize("binary", [True, False])
def test_rows_are_all_grids_sorted_by_id(written, binary):
    path = written({"KGG": ROOT + ROOT.T, "MGG": ROOT @ ROOT.T}, binary=binary)
    made = read_output4(path, MatrixRole.STIFFNESS, NODES)
    np.testing.assert_allclose(made.matrix.toarray(), ROOT + ROOT.T, rtol=1e-15)
    np.testing.assert_array_equal(made.freedoms[[0, 5, 6]], [[10, 1], [10, 6], [20, 1]])
    named = read_output4(path, MatrixRole.STIFFNESS, NODES, name="MGG")
    np.testing.assert_allclose(named.matrix.toarray(), ROOT @ ROOT.T, rtol=1e-14)


def test_rows_are_the_analysis_set_where_they_fit_it(written):
    retained = np.array([[10, 2], [10, 3], [20, 1]])
    nodes = NodeTable("arm.bdf", NODES.ids, NODES.positions, retained=retained)
    made = read_output4(written({"KAA": np.eye(3)}), MatrixRole.STIFFNESS, nodes)
    np.testing.assert_array_equal(made.freedoms, retained)
    with pytest.raises(
        ImportFormatError, match=r"5 rows, but arm\.bdf has 2 grids, so 12 freedoms, and an ASET of 3"
    ):
        read_output4(written({"KAA": np.eye(5)}), MatrixRole.STIFFNESS, nodes)


def test_the_digits_of_a_text_file_tell_its_resolution(tmp_path, written):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    path = tmp_path / "few.op4"
    op4.write(str(path), {"KGG": ROOT + ROOT.T}, binary=False, digits=9)
    assert read_output4(path, MatrixRole.STIFFNESS, NODES).resolution == pytest.approx(5e-10)
    exact = written({"KGG": ROOT + ROOT.T})
    assert read_output4(exact, MatrixRole.STIFFNESS, NODES).resolution < 1e-15


def output2(**matrices):
    """A file of matrices as Nastran writes OUTPUT2: records between two copies of their length."""

    def record(content):
        return struct.pack("<i", len(content)) + content + struct.pack("<i", len(content))

    def key(*values):
        return b"".join(record(struct.pack("<i", value)) for value in values)

    parts = [key(3), record(bytes(12)), key(7), record(b"NASTRAN FORT TAPE ID CODE - ")]
    parts += [key(2), record(b"XXXXXXXX"), key(-1, 0)]
    for name, matrix in matrices.items():
        rows, columns = matrix.shape
        trailer = struct.pack("<7i", 101, columns, rows, 6, 2, 2 * rows, 10000)
        label = name.ljust(8).encode()
        parts += [key(2), record(label), key(-1, 7), record(trailer), key(-2, 1, 0, 2)]
        parts += [record(label), key(-3, 1)]
        for column in matrix.T:
            content = struct.pack("<i", 1) + column.astype("<f8").tobytes()
            parts += [key(1, len(content) // 4), record(content), key(-4, 1)]
        parts.append(key(0, 0))
    return b"".join([*parts, key(0)])


def test_output2_has_the_same_map(tmp_path):
    pytest.importorskip("pyyeti.nastran.op2")
    path = tmp_path / "arm.op2"
    K, M = ROOT + ROOT.T, ROOT @ ROOT.T
    path.write_bytes(output2(KAA=K, MAA=M))
    for role, matrix in ((MatrixRole.STIFFNESS, K), (MatrixRole.MASS, M)):
        made = read_output4(path, role, NODES)
        np.testing.assert_allclose(made.matrix.toarray(), matrix, rtol=1e-15)
        np.testing.assert_array_equal(made.freedoms[[0, 5, 6]], [[10, 1], [10, 6], [20, 1]])
    path.write_bytes(output2(KAA=K)[:-700])
    with pytest.raises(ImportFormatError, match="not readable as OUTPUT2"):
        read_output4(path, MatrixRole.STIFFNESS, NODES)


def test_a_size_that_fits_no_set(written):
    message = r"arm\.op4, matrix KGG: 9 rows, but arm\.bdf has 2 grids, so 12 freedoms, and no ASET; export"
    with pytest.raises(ImportFormatError, match=message):
        read_output4(written({"KGG": np.eye(9)}), MatrixRole.STIFFNESS, NODES)


def test_matrices_that_are_not_what_was_asked(written):
    path = written({"KGG": np.eye(12), "KLL": np.eye(12)})
    with pytest.raises(
        ImportFormatError, match=r"2 matrices whose name begins with K.*the file has KGG, KLL"
    ):
        read_output4(path, MatrixRole.STIFFNESS, NODES)
    with pytest.raises(ImportFormatError, match="no matrix 'MAA'; the file has KGG, KLL"):
        read_output4(path, MatrixRole.MASS, NODES, name="MAA")
    with pytest.raises(ImportFormatError, match="matrix KGG: complex entries; stiffness and mass are real"):
        read_output4(written({"KGG": (1 + 1j) * np.eye(12)}), MatrixRole.STIFFNESS, NODES)
    with pytest.raises(ImportFormatError, match=r"matrix KGG: the matrix has shape \(12, 3\)"):
        read_output4(written({"KGG": np.ones((12, 3))}), MatrixRole.STIFFNESS, NODES)
    with pytest.raises(ImportFormatError, match="matrix KGG: not symmetric"):
        read_output4(written({"KGG": ROOT}), MatrixRole.STIFFNESS, NODES)


@pytest.mark.parametrize("binary", [True, False])
def test_a_truncated_file(written, binary):
    path = written({"KGG": ROOT + ROOT.T}, binary=binary)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ImportFormatError, match=r"arm\.op4: .*(cut short|complete)"):
        read_output4(path, MatrixRole.STIFFNESS, NODES)


@pytest.mark.parametrize(
    "content", [b"", b"\x00\xff" * 300, b"this is no matrix\n" * 20], ids=["empty", "binary", "text"]
)
def test_garbage(tmp_path, written, content):
    path = tmp_path / "arm.op4"
    path.write_bytes(content)
    with pytest.raises(ImportFormatError, match=r"arm\.op4: .*(cut short|complete)"):
        read_output4(path, MatrixRole.STIFFNESS, NODES)


def test_a_missing_file_and_a_missing_library(tmp_path, written, monkeypatch):
    with pytest.raises(ImportFormatError, match=r"absent\.op4: no such file"):
        read_output4(tmp_path / "absent.op4", MatrixRole.STIFFNESS, NODES)
    monkeypatch.setitem(sys.modules, "pyyeti.nastran", None)
    with pytest.raises(
        ImportFormatError, match=r"pip install 'supple\[nastran\]', or punch the matrices as DMIG"
    ):
        read_output4(written({"KGG": np.eye(12)}), MatrixRole.STIFFNESS, NODES)
