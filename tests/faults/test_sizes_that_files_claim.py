"""A few bytes that ask for terabytes are refused before memory is taken, with the limit in the message."""

from __future__ import annotations

import struct
import time

import numpy as np
import pytest

import supple as sp
from supple.errors import CaseError, ImportFormatError, MeshError
from supple.importers import MatrixRole, NodeTable, read_labelled_matrix, read_matrix, read_nodes

HEAD = "%%MatrixMarket matrix "


@pytest.fixture(autouse=True)
def soon():
    began = time.process_time()
    yield
    assert time.process_time() - began < 10.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("coordinate real general\n2000000000 2000000000 0\n", "at most 100000 rows or columns more than"),
        (
            "coordinate real general\n2 2 9000000000000000000\n1 1 1\n",
            "entries are stated, but 1 lines follow",
        ),
        ("array real general\n1000000 1000000\n", "1000000000000 entries are stated, but 0 lines follow"),
        ("coordinate real general\n-1 2 1\n1 1 1\n", "is not the number of rows, columns and entries"),
        ("coordinate real symmetric\n2 3 1\n1 1 1\n", "a symmetric matrix of 2 rows and 3 columns"),
        ("coordinate real general\n2 2 1\n1 1\n", "line 3: .*'1 1' is not row, column, value"),
        ("coordinate real general\n2 2 1\n0 1 1\n", "line 3: .*0 is no row or column of 2"),
        ("coordinate real general\n2 2 1\n1.5 1 1\n", "line 3: .*1.5 is no row or column of 2"),
        ("coordinate pattern general\n2 2 1\n1 1\n", "'pattern' in the first line is not read"),
        ("coordinate real general\n", "no line states the size"),
        ("coordinate real\n1 1 1\n1 1 1\n", "the first line is no %%MatrixMarket"),
    ],
)
def test_matrix_market_is_checked_before_it_is_read(text, message, tmp_path):
    path = tmp_path / "k.mtx"
    path.write_text(HEAD + text)
    with pytest.raises(ImportFormatError, match=message):
        read_matrix(path)


def test_matrix_market_fills_in_what_symmetry_leaves_out(tmp_path):
    path = tmp_path / "k.mtx"
    for text, expected in (
        ("coordinate real symmetric\n2 2 2\n1 1 3\n2 1 4\n", [[3, 4], [4, 0]]),
        ("coordinate integer skew-symmetric\n2 2 1\n2 1 4\n", [[0, -4], [4, 0]]),
        ("array real symmetric\n2 2\n1\n2\n3\n", [[1, 2], [2, 3]]),
        ("array real skew-symmetric\n3 3\n1\n2\n3\n", [[0, -1, -2], [1, 0, -3], [2, 3, 0]]),
        ("array real general\n2 3\n1\n2\n3\n4\n5\n6\n", [[1, 3, 5], [2, 4, 6]]),
    ):
        path.write_text(HEAD + text)
        np.testing.assert_array_equal(read_matrix(path).toarray(), expected)


@pytest.mark.parametrize("suffix", [".inp", ".bdf"])
def test_an_include_bomb(suffix, tmp_path):
    """Twenty files that each include the next one three times, and one line: 3^20 lines."""
    include = "*INCLUDE, INPUT={}\n" if suffix == ".inp" else "INCLUDE '{}'\n"
    for i in range(20):
        (tmp_path / f"f{i}{suffix}").write_text(3 * include.format(f"f{i + 1}{suffix}"))
    (tmp_path / f"f20{suffix}").write_text("*NODE\n1,0,0,0\n" if suffix == ".inp" else "GRID,1,,0.,0.,0.\n")
    with pytest.raises(ImportFormatError, match="more than 1000 inclusions in one model"):
        read_nodes(tmp_path / f"f0{suffix}")


def test_a_large_file_included_over_and_over(tmp_path, monkeypatch):
    monkeypatch.setattr("supple.importers.inclusion.MOST_INCLUDED_CHARACTERS", 100)
    (tmp_path / "a.inp").write_text(3 * "*INCLUDE, INPUT=b.inp\n")
    (tmp_path / "b.inp").write_text("** " + 47 * "x" + "\n")
    with pytest.raises(ImportFormatError, match=r"a\.inp, line 3: .*hold more than 100 characters"):
        read_nodes(tmp_path / "a.inp")


@pytest.mark.parametrize(("keyword", "member"), [("NSET", "node"), ("ELSET", "element")])
@pytest.mark.parametrize("last", ["1000000000", "9223372036854775807"])
def test_a_generated_set_of_a_thousand_million(keyword, member, last, tmp_path):
    path = tmp_path / "m.inp"
    nodes = "*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n1000000000,0.,1.,0.\n"
    elements = "*ELEMENT, TYPE=S3\n1, 1, 2, 1000000000\n"
    path.write_text(f"{nodes}{elements}*{keyword}, {keyword}=S, GENERATE\n1, {last}\n")
    with pytest.raises(
        ImportFormatError, match=f"set 'S' names {member} [23], which the file does not define"
    ):
        sp.read_abaqus(path)


def test_a_generated_set_with_a_large_step_is_read(tmp_path):
    path = tmp_path / "m.inp"
    path.write_text(
        "*NODE\n1,0.,0.,0.\n1000000000,0.,1.,0.\n*NSET, NSET=S, GENERATE\n1, 1000000000, 999999999\n"
    )
    assert read_nodes(path).node_sets["S"].tolist() == [0, 1]


def test_a_range_of_grids_names_those_there_are(tmp_path):
    path = tmp_path / "m.bdf"
    path.write_text("GRID,1,,0.,0.,0.\nGRID,7,,1.,0.,0.\nSPC1,1,123,1,THRU,9223372036854775807\n")
    assert read_nodes(path).node_sets["spc1_123"].tolist() == [0, 1]


@pytest.mark.parametrize("tag", [10**12, 2**63 - 1])
def test_a_gmsh_tag_is_no_size(tag, tmp_path):
    """Nodes may have any tags; they are looked up, not counted up to."""
    path = tmp_path / "m.msh"
    nodes = f"1 0 0 0\n2 1 0 0\n{tag} 0 1 0"
    path.write_text(
        f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n{nodes}\n$EndNodes\n"
        f"$Elements\n1\n1 2 2 0 1 1 2 {tag}\n$EndElements\n"
    )
    assert sp.read_gmsh(path).n_nodes == 3


def test_gmsh_counts_are_held_against_the_file(tmp_path):
    path = tmp_path / "m.msh"
    head = b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n"
    sizes = struct.pack("<4Q3iQ", 1, 10**15, 1, 10**15, 2, 1, 0, 10**15)
    path.write_bytes(
        head + sizes + b"\n$EndNodes\n$Elements\n" + struct.pack("<4Q", 0, 0, 0, 0) + b"\n$EndElements\n"
    )
    with pytest.raises(
        ImportFormatError, match=r"\$Nodes: 10{15} entries of 8 bytes are declared, and \d+ bytes"
    ):
        sp.read_gmsh(path)


def test_output4_columns_are_held_against_their_records(tmp_path):
    header = struct.pack("<6i", 24, 1, 1, 2, 2, 0)[:20] + b"KGG     " + struct.pack("<i", 24)
    column = struct.pack("<4i", 20, 1, 1, 10**9) + struct.pack("<d", 1.0) + struct.pack("<i", 20)
    path = tmp_path / "k.op4"
    path.write_bytes(header + column)
    with pytest.raises(ImportFormatError, match="column 1 states 1000000000 words in a record of 20 bytes"):
        read_labelled_matrix(path, MatrixRole.STIFFNESS, NodeTable("m", np.array([1]), np.zeros((1, 3))))


def test_output_times_are_counted_before_they_are_made(tmp_path):
    with pytest.raises(ValueError, match=r"2e\+09 output times; at most 10000000 are stored"):
        sp.Run(2e9, 1.0)
    assert len(sp.Run(1e4, 1.0).times) == 10_001
    path = tmp_path / "case.toml"
    for duration in ("2e9", "1e50", "inf"):
        path.write_text(
            f'title = "t"\nbody = []\n[simulation]\nduration = {duration}\noutput_step = 1.0\nstep = 1.0\n'
        )
        with pytest.raises(
            CaseError, match=r"simulation\.output_step: .*more than the 10000000 output times"
        ):
            sp.read_case(path)


def test_cells_are_counted_before_they_are_made():
    with pytest.raises(MeshError, match=r"n_length = 1000000000 .* at most 20000000 are made"):
        sp.block(1.0, 1.0, 1.0, 10**9, 1, 1, sp.CellType.TETRA4)
    with pytest.raises(MeshError, match="at most 20000000 are made"):
        sp.strip(1.0, 1.0, 10**6, 10**6)
