"""Matrices as lists of entries, of Abaqus and CalculiX; what breaks their form."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.matrices.coordinate_matrices import read_abaqus_matrix, read_calculix_matrix
from supple.importers.node_table import NodeTable

ABAQUS = "** made by hand\n*MATRIX INPUT\n5,1, 5,1, 2.5\n5,2, 5,1, -1.0\n5,2, 5,2, 4e+00\n"


@pytest.fixture
def files(tmp_path):
    def write(**texts):
        for name, text in texts.items():
            (tmp_path / name.replace("_", ".")).write_bytes(
                text if isinstance(text, bytes) else text.encode()
            )
        return tmp_path

    return write


def test_abaqus_entries_have_labels(files):
    made = read_abaqus_matrix(files(K_mtx=ABAQUS) / "K.mtx")
    np.testing.assert_array_equal(made.freedoms, [[5, 1], [5, 2]])
    np.testing.assert_array_equal(made.matrix.toarray(), [[2.5, -1], [-1, 4]])


def nodes(ids):
    return NodeTable("own", np.array(ids), np.zeros((len(ids), 3)))


@pytest.mark.parametrize("blank", [" ", ", "])
def test_abaqus_coordinates_run_through_the_nodes_by_their_ids(files, blank):
    """Row 3 (k - 1) + c is component c of the node with the k-th id."""
    text = "** made by hand\n" + "\n".join(
        blank.join((str(i), str(j), value)) for i, j, value in ((1, 1, "2.5"), (2, 5, "-1."), (6, 6, "4."))
    )
    made = read_abaqus_matrix(files(K_mtx=text) / "K.mtx", nodes([9, 5]))
    np.testing.assert_array_equal(made.freedoms, [[5, 1], [5, 2], [5, 3], [9, 1], [9, 2], [9, 3]])
    expected = np.zeros((6, 6))
    expected[0, 0], expected[1, 4], expected[4, 1], expected[5, 5] = 2.5, -1, -1, 4
    np.testing.assert_array_equal(made.matrix.toarray(), expected)
    shell = read_abaqus_matrix(files(K_mtx=text) / "K.mtx", nodes([7]))
    np.testing.assert_array_equal(shell.freedoms, [[7, i] for i in range(1, 7)])


def test_abaqus_coordinates_need_the_nodes_of_the_model(files):
    folder = files(K_mtx="1 1 2.5\n7 7 1.0\n")
    with pytest.raises(
        ImportFormatError, match=r"K\.mtx: rows 1 to 7, which are neither 3 nor 6 .* of 2 nodes"
    ):
        read_abaqus_matrix(folder / "K.mtx", nodes([1, 2]))


def test_calculix_entries_have_a_map_beside_them(files):
    folder = files(arm_sti="1 1 2.5\n 1 2 -1.0\n2 2 4.0\n", arm_dof="    5.1\n   17.3\n")
    made = read_calculix_matrix(folder / "arm.sti")
    np.testing.assert_array_equal(made.freedoms, [[5, 1], [17, 3]])
    np.testing.assert_array_equal(made.matrix.toarray(), [[2.5, -1], [-1, 4]])
    same = read_calculix_matrix(folder / "arm.sti", folder / "arm.dof")
    np.testing.assert_array_equal(same.freedoms, made.freedoms)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            ABAQUS[:-10],
            r"K\.mtx, line 5: '5,2, 5' is not node, component, node, component, value; is the file cut",
        ),
        (ABAQUS.replace("2.5", "two"), r"K\.mtx, line 3: '5,1, 5,1, two' is not node"),
        (ABAQUS.replace("5,1, 5,1", "5.5,1, 5,1"), r"K\.mtx: 5\.5 is not a node id or component"),
        (ABAQUS + "5,1, 5,1, 2.5\n", "the entry of node 5 ux with node 5 ux is given twice"),
        (ABAQUS + "5,1, 5,2, -2.0\n", "not symmetric: the two entries of node 5"),
        (ABAQUS + "5,7, 5,7, 1.0\n", "component 7 of node 5; only 1 to 6"),
        (ABAQUS + "5,3, 5,3, nan\n", "an entry in the row of node 5 uz is not finite"),
        ("** nothing\n", r"K\.mtx: an empty file"),
        (b"\x00\x01\x02", r"K\.mtx: a binary file; write the matrices as text"),
        (
            "%%MatrixMarket matrix coordinate real general\n2 2 1\n",
            r"K\.mtx, line 1: '%%MatrixMarket.*is not node",
        ),
    ],
)
def test_abaqus_files_that_break_the_rules(files, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read_abaqus_matrix(files(K_mtx=text) / "K.mtx")


@pytest.mark.parametrize(
    ("entries", "freedoms", "message"),
    [
        (
            "1 1 1.0\n3 3 1.0\n",
            "5.1\n5.2\n",
            r"arm\.sti: an entry of row 3 and column 3, but .*arm\.dof names 2 freedoms",
        ),
        (
            "1 1 1.0\n",
            "5.1\n5.2\n",
            r"arm\.sti: 1 rows, but .*arm\.dof names 2 freedoms; is the file cut short",
        ),
        ("1 1 1.0\n2 2\n", "5.1\n5.2\n", r"arm\.sti, line 2: '2 2' is not row, column, value"),
        ("1 1 1.0\n2 2 1.0\n", "5.1\nfive\n", r"arm\.dof, line 2: 'five' is not NODE\.COMPONENT"),
        ("1 1 1.0\n2 2 1.0\n", "5.1\n5.1\n", r"arm\.sti: node 5 ux occurs twice in the map"),
    ],
)
def test_calculix_files_that_break_the_rules(files, entries, freedoms, message):
    folder = files(arm_sti=entries, arm_dof=freedoms)
    with pytest.raises(ImportFormatError, match=message):
        read_calculix_matrix(folder / "arm.sti")


def test_missing_files_are_named(tmp_path, files):
    with pytest.raises(ImportFormatError, match=r"K\.mtx: no such file"):
        read_abaqus_matrix(tmp_path / "K.mtx")
    with pytest.raises(ImportFormatError, match=r"arm\.dof: no such file"):
        read_calculix_matrix(files(arm_sti="1 1 1.0\n") / "arm.sti")
