"""Section tables in CSV: written and read, and the messages."""

import re
from dataclasses import replace

import numpy as np
import pytest
from fixtures.section_tables import helix_table, prismatic

from supple.errors import ImportFormatError, ModelError
from supple.importers import read_section_csv, read_section_table, write_section_csv


def test_a_table_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "beam.csv"
    table = helix_table(41)
    write_section_csv(table, path, about="a helix\nof no source")
    read = read_section_table(path)
    for name in ("positions", "stiffness", "inertia"):
        assert getattr(read, name) == pytest.approx(getattr(table, name), rel=1e-7, abs=1e-7)
    assert read.axes == pytest.approx(table.axes, abs=1e-3)  # its z is that of a parabola
    assert path.read_text().splitlines()[1] == "# of no source"


def test_a_table_without_rotary_inertia_is_read_as_it_was_written(tmp_path):
    path, table = tmp_path / "beam.csv", helix_table(5)
    points = replace(table, inertia=table.inertia * (np.arange(6) < 3) * (np.arange(6) < 3)[:, None])
    write_section_csv(points, path)
    assert read_section_csv(path).inertia == pytest.approx(points.inertia, rel=1e-7)


TEXT = """\
x,y,z,axis_x,axis_y,axis_z,k11,k22,k33,k44,k55,k66,k34,m11,m22,m33,m44,m55,m66
0,0,0,1,0,0.3,1e5,1e5,2e5,30,40,20,100,1,1,1,0.01,0.02,0.03
0,0,1,2,0,0.3,1e5,1e5,2e5,30,40,20,100,1,1,1,0.01,0.02,0.03
"""


def test_what_is_left_out_is_zero_and_axes_are_made_square(tmp_path):
    path = tmp_path / "beam.csv"
    path.write_text(TEXT)
    table = read_section_csv(path)
    assert table.axes == pytest.approx(np.tile(np.eye(3), (2, 1, 1)))
    assert table.stiffness[0, 2, 3] == table.stiffness[0, 3, 2] == 100
    assert table.stiffness[0, 3, 5] == 0


@pytest.mark.parametrize(
    ("old", "new", "error", "message"),
    [
        ("k66", "k65", ImportFormatError, "no column k66"),
        ("0,0,1,2,0,0.3", "0,0,1,0,0,0.3", ModelError, "line 3: its axis_x, axis_y, axis_z are along the"),
        ("0,0,1,2", "0,0,0,2", ModelError, "line 3: at the position of the section before it"),
        ("0,0,1,2", "0,0,1,nan", ImportFormatError, "line 3: a number is not finite"),
        ("0,0,1,2", "0,0,one,2", ImportFormatError, "line 3: z is 'one'; write a number"),
        (
            "20,100,1,1,1,0.01,0.02,0.03\n0",
            "20,1e4,1,1,1,0.01,0.02,0.03\n0",
            ModelError,
            "line 2: its stiffness",
        ),
        ("1,1,1,0.01,0.02,0.03\n0", "1,1,2,0.01,0.02,0.03\n0", ModelError, "line 2: its mass differs"),
        (TEXT[TEXT.index("0,0,1,2") :], "", ImportFormatError, "1 sections; give two at least"),
    ],
)
def test_mistakes_are_named_with_their_line(tmp_path, old, new, error, message):
    assert old in TEXT
    path = tmp_path / "beam.csv"
    path.write_text(TEXT.replace(old, new, 1))
    with pytest.raises(error, match=re.escape(message)):
        read_section_csv(path)


def test_a_file_of_another_kind(tmp_path):
    with pytest.raises(ImportFormatError, match=r"not a section table; give a file \.csv, \.yaml"):
        read_section_table(tmp_path / "beam.xlsx")
    assert prismatic().n == 2
