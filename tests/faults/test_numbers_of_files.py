"""What only Python takes for a number is none in a file, in any reader: 1_000, other digits, 400 of them."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.bar_case import bar_case

from supple.cases import read_case
from supple.errors import CaseError, ImportFormatError
from supple.importers import MatrixRole, read_labelled_matrix, read_matrix, read_mesh, read_nodes, read_polar
from supple.importers.time_table import read_time_table
from supple.machine.joints.joint import axes_along

WRONG = ["1_000", "١٢", "2" * 400, "99999999999999999999"]
READERS = {
    "mesh.inp": (read_nodes, "*NODE\n{}, 0., 0., 0.\n"),
    "mesh.bdf": (read_nodes, "GRID,{},,0.,0.,0.\n"),
    "k.mtx": (lambda path: read_labelled_matrix(path, MatrixRole.STIFFNESS, None), "{},1,1,1,2.0\n"),
    "m.mtx": (read_matrix, "%%MatrixMarket matrix coordinate real general\n1 1 1\n{} 1 2.0\n"),
    "mesh.msh": (
        read_mesh,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n{} 0 0 0\n$EndNodes\n$Elements\n0\n$EndElements\n",
    ),
}


@pytest.mark.parametrize("word", WRONG)
@pytest.mark.parametrize("name", READERS)
def test_ids_are_plain_numbers_of_64_bits(name, word, tmp_path):
    reader, text = READERS[name]
    path = tmp_path / name
    path.write_text(text.format(word), encoding="utf-8")
    with pytest.raises(ImportFormatError, match=name):
        reader(path)


@pytest.mark.parametrize("word", ["1_000", "١٢"])
def test_values_of_tables_are_plain_numbers(word, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(f"alpha_deg,cl,cd\n-180,0,0\n180,{word},0\n", encoding="utf-8")
    with pytest.raises(ImportFormatError, match=rf"t\.csv, line 3: cl is '{word}'; write a number"):
        read_polar(path, name="t")
    path.write_text(f"0,0\n1,{word}\n", encoding="utf-8")
    with pytest.raises(ImportFormatError, match=r"t\.csv, line 2: .*write rows of two numbers"):
        read_time_table(path)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32", "latin-1"])
def test_every_text_is_read_in_its_encoding(encoding, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("# größe, °\n0,0\n1,2.5\n", encoding=encoding)
    np.testing.assert_array_equal(read_time_table(path)[1], [0.0, 2.5])
    mesh = tmp_path / "mesh.inp"
    mesh.write_text("*NODE, NSET=Spitze\n** °\n7, 0., 1., 2.\n", encoding=encoding)
    assert read_nodes(mesh).ids.tolist() == [7]
    bulk = tmp_path / "mesh.bdf"
    bulk.write_text("GRID,7,,0.,1.,2. $ °\n", encoding=encoding)
    assert read_nodes(bulk).ids.tolist() == [7]


def test_a_case_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('\ufefftitle = "t"\n', encoding="utf-8")
    with pytest.raises(CaseError, match=r"line 1, body: this key is missing"):
        read_case(path)


@pytest.mark.parametrize("number", ["9223372036854775808", "-9223372036854775809", "1" * 400])
def test_whole_numbers_of_a_case_have_64_bits(number, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(f'title = "t"\n[simulation]\nduration = {number}\n', encoding="utf-8")
    with pytest.raises(CaseError, match=r"line 3, simulation\.duration: a whole number has at most 64 bits"):
        read_case(path)


@pytest.mark.parametrize("axis", [(0.0, 1e300, 0.0), (0.0, 1e-300, 0.0), (0.0, 5e-324, 0.0)])
def test_the_length_of_an_axis_does_not_matter(axis):
    """A square of these is infinite or zero; a hinge whose axis was none let its body fall."""
    np.testing.assert_array_equal(axes_along(axis), axes_along((0.0, 1.0, 0.0)))
    np.testing.assert_array_equal(axes_along((1.0, 0.0, 0.0), axis), axes_along((1.0, 0.0, 0.0), (0, 1, 0)))


@pytest.mark.parametrize(
    ("old", "new"),
    [("axis = [0, 1, 0]", "axis = [0, 1e300, 0]"), ("mass = 1.0", "mass = 1e61"), ("-9.81", "-1e200")],
)
def test_numbers_whose_products_overflow_are_mistakes_of_a_case(tmp_path, old, new):
    path = tmp_path / "bar.toml"
    path.write_text(bar_case(0.1, 0.05, 0.05).replace(old, new), encoding="utf-8")
    with pytest.raises(
        CaseError, match=r"line \d+, .*: -?1e\+\d+ exceeds the largest usable magnitude, 1e\+60"
    ):
        read_case(path)
