"""Grids in nested coordinate systems, against closed forms and against another program (pyyeti)."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ImportFormatError
from supple.importers.nastran.bulk_data import read_bulk_data
from supple.importers.nastran.grids import CoordinateKind, read_grids, through_points

NESTED = """\
CORD2C,1,0,1.,0.,0.,1.,0.,1.
,2.,0.,0.
CORD2S,2,1,2.,90.,0.,2.,90.,1.
,3.,90.,0.
GRID,10,1,2.,90.,3.,1
GRID,11,2,1.,90.,90.,2
GRID,12,,1.,2.,3.
GRID,13,4,1.,1.,1.,4
CORD1R,4,12,10,11
"""


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / "grids.bdf"
        path.write_text(text)
        return read_grids(read_bulk_data(path))

    return read_text


def test_points_of_nested_systems(read):
    grids = read(NESTED)
    # System 1: cylindrical about z through (1, 0, 0). System 2: spherical, at r = 2, theta = 90 there.
    np.testing.assert_allclose(grids.positions[0], [1, 2, 3], atol=1e-15)
    np.testing.assert_allclose(grids.axes[0], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    # The x axis of system 2 points from (1, 2, 0) along y, so phi = 90 is -x.
    np.testing.assert_allclose(grids.positions[1], [0, 2, 0], atol=1e-15)
    np.testing.assert_allclose(grids.axes[1] @ [1, 0, 0], [-1, 0, 0], atol=1e-15)
    np.testing.assert_array_equal(grids.axes[2], np.eye(3))
    np.testing.assert_allclose(np.linalg.det(grids.axes), 1)


@pytest.mark.slow
def test_the_same_grids_as_another_program(tmp_path):
    """Positions and displacement axes of pyyeti, on random systems."""
    bulk = pytest.importorskip("pyyeti.nastran.bulk")
    rng = np.random.default_rng(0)
    rows = []
    for system, kind in enumerate("RCSRCS", 1):
        a, b, c = rng.normal(size=(3, 3))
        words = ",".join(f"{x:.6f}" for x in (*a, *b))
        rows += [f"CORD2{kind},{system},{system - 1},{words}", "," + ",".join(f"{x:.6f}" for x in c)]
    for grid in range(1, 13):
        r, theta, phi = rng.uniform(0.5, 2.0), rng.uniform(20, 80), rng.uniform(-80, 80)
        rows.append(f"GRID,{grid},{grid % 7},{r:.6f},{theta:.6f},{phi:.6f},{(grid * 3) % 7}")
    path = tmp_path / "grids.bdf"
    path.write_text("\n".join(rows) + "\n")
    grids = read_grids(read_bulk_data(path))
    uset, _ = bulk.bulk2uset(str(path))
    table = np.asarray(uset.loc[:, "x":"z"]).reshape(12, 6, 3)
    np.testing.assert_allclose(grids.positions, table[:, 0], atol=1e-9)
    theirs = bulk.rdcord2cards(str(path))
    for number in range(12):
        system = (int(grids.ids[number]) * 3) % 7
        if system in (0, 1, 4):  # rectangular: T is the same for every grid
            expected = np.eye(3) if system == 0 else theirs[system][2:]
            np.testing.assert_allclose(grids.axes[number], expected, atol=1e-9)


def test_directions_are_those_of_growing_coordinates():
    """Each column is the unit tangent of its coordinate line, by central differences."""
    rng = np.random.default_rng(1)
    for kind in CoordinateKind:
        system = through_points(kind, *rng.normal(size=(3, 3)))
        assert system is not None
        local = np.array([[1.3, 40.0, 25.0]])
        axes = system.directions(system.basic(local))[0]
        for i in range(3):
            step = 1e-5 * np.eye(3)[i]
            tangent = (system.basic(local + step) - system.basic(local - step))[0]
            np.testing.assert_allclose(axes[:, i], tangent / np.linalg.norm(tangent), atol=1e-8)


def test_what_grids_leave_blank_is_that_of_grdset(read):
    system = "CORD2R,3,,1.,0.,0.,1.,0.,1.\n,1.,1.,0.\n"
    short = read(system + "GRDSET,,3,,,,3,345\nGRID,1,,1.,2.,3.\nGRID,2,0,1.,2.,3.,0,6\nGRID,2,0,1,2,3,0,6\n")
    long = read(system + "GRID,1,3,1.,2.,3.,3,345\nGRID,2,0,1.,2.,3.,0,6\n")
    for name in ("ids", "positions", "axes", "supports"):
        np.testing.assert_array_equal(getattr(short, name)[:2], getattr(long, name))


@pytest.mark.parametrize("kind", list(CoordinateKind))
def test_on_the_axis_directions_are_those_of_the_rectangular_system(kind):
    """Nastran takes "the defining rectangular system" there [MSC Quick Reference Guide, CORD2C, CORD2S]."""
    system = through_points(kind, np.zeros(3), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]))
    assert system is not None
    for z in (5.0, -5.0, 0.0):
        np.testing.assert_array_equal(system.directions(np.array([[0.0, 0.0, z]]))[0], np.eye(3))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("MAT1,5\n", r"grids\.bdf: no GRID card"),
        ("GRID,1\nGRID,1,,1.\n", r"line 2: GRID: grid 1 is defined a second time and differs from.*line 1"),
        ("GRDSET,,3\nGRDSET,,3\nGRID,1\n", r"line 2: GRDSET: occurs a second time"),
        ("GRID,1,9\n", r"line 1: GRID: names coordinate system 9.*add its CORD card"),
        ("GRID,1,,0.,0.,0.,9\n", r"line 1: GRID: names coordinate system 9"),
        (
            "GRID,1\nCORD2R,3,3,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            r"line 2: CORD2R: coordinate system 3 refers to",
        ),
        (
            "GRID,1\nCORD2R,3,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n",
            r"line 2: CORD2R: its three points lie on one line",
        ),
        ("GRID,1\nCORD1R,3,1,2,4\n", r"line 2: CORD1R: coordinate system 3 refers to a system or grid"),
        (
            "GRID,1\n" + 2 * "CORD2R,3,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            r"line 4: CORD2R: coordinate system 3 is def",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_line(read, text, message):
    with pytest.raises(ImportFormatError, match=message):
        read(text)
