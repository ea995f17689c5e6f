"""Station tables of one's own, the shipped blade, and the error messages."""

import numpy as np
import pytest

from supple.errors import ImportFormatError, MeshError
from supple.importers import nrel5mw_stations, read_stations
from supple.mesh import TrailingEdge

HEAD = "span_m,section,chord_m,twist_deg,pitch_axis_x_over_c"


@pytest.fixture
def read(tmp_path):
    (tmp_path / "sections").mkdir()
    (tmp_path / "sections" / "diamond.csv").write_text(
        "x_over_c,y_over_c\n1,0\n0.5,-0.1\n0,0\n0.5,0.1\n1,0\n"
    )
    (tmp_path / "sections" / "eight.csv").write_text("x_over_c,y_over_c\n1,0.1\n.7,-.1\n0,0\n.7,.1\n1,-0.1\n")

    def of(text):
        (tmp_path / "blade.csv").write_text(text)
        return read_stations(tmp_path / "blade.csv", sections=tmp_path / "sections")

    return of


def test_a_table_of_ones_own(read):
    blade = read(
        f"{HEAD},trailing_edge,prebend_m\n0,diamond,2,9,0.5,round,0\n10,diamond,1,0,0.4,sharp,-0.5\n"
    )
    np.testing.assert_array_equal(blade.span, [0, 10])
    np.testing.assert_allclose(blade.twist, [np.pi / 20, 0])
    np.testing.assert_array_equal(blade.prebend, [0, -0.5])
    np.testing.assert_array_equal(blade.sweep, [0, 0])
    assert [s.trailing_edge for s in blade.sections] == [TrailingEdge.ROUND, TrailingEdge.AIRFOIL]


def test_the_shipped_blade():
    """Length, root and largest chord of [Resor2013]; the largest lies at a span of 14.35 m."""
    blade = nrel5mw_stations()
    assert len(blade.sections) == 38
    assert blade.span[-1] == 61.5
    assert (blade.chord[0], blade.chord.max(), blade.span[blade.chord.argmax()]) == (3.386, 4.652, 14.35)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (
            "0,diamond,2,9,0.5\n10,disc,1,0,0.4\n",
            "line 3: unknown section 'disc'; .*sections has diamond, eight",
        ),
        ("0,diamond,2,9,0.5\n10,diamond,1,zero,0.4\n", "line 3: twist_deg is 'zero'"),
    ],
)
def test_file_errors(read, rows, message):
    with pytest.raises(ImportFormatError, match=message):
        read(f"{HEAD}\n{rows}")


def test_a_missing_folder(read, tmp_path):
    read(f"{HEAD}\n0,diamond,2,9,0.5\n10,diamond,1,0,0.4\n")
    with pytest.raises(ImportFormatError, match=r"unknown section 'diamond'; there is no folder .*gone"):
        read_stations(tmp_path / "blade.csv", sections=tmp_path / "gone")


def test_unknown_trailing_edge(read):
    with pytest.raises(
        ImportFormatError, match="line 2: trailing edge 'torn'; write one of round, flat, sharp"
    ):
        read(f"{HEAD},trailing_edge\n0,diamond,2,9,0.5,torn\n")


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("10,diamond,2,9,0.5\n0,diamond,1,0,0.4\n", "blade.csv: stations out of order"),
        ("0,eight,2,9,0.5\n10,diamond,1,0,0.4\n", "section 'eight': the outline crosses itself"),
        ("0,diamond,nan,9,0.5\n10,diamond,1,0,0.4\n", "station 0: chord is nan"),
    ],
)
def test_tables_that_describe_no_blade(read, rows, message):
    with pytest.raises(MeshError, match=message):
        read(f"{HEAD}\n{rows}")
