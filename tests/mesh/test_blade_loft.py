"""Blade loft: counts, topology, area of a tube, frame, the published blade, and the error messages."""

from pathlib import Path

import numpy as np
import pytest

from supple.errors import MeshError
from supple.importers import NREL5MW_WEBS, WU2019_GRID, nrel5mw_stations, read_abaqus
from supple.mesh import (
    AirfoilSection,
    BladeGrid,
    BladeStations,
    CellType,
    ShearWebs,
    TrailingEdge,
    loft_blade,
)

TRIANGLE = CellType.TRIANGLE3
BLADE_FILE = Path(__file__).parents[2] / "examples" / "blade.inp"
RADIUS, LENGTH = 1.5, 20.0
WEBS = ShearWebs(start=2.0, end=18.0, fore=-0.4, aft=0.5)
COARSE = BladeGrid(
    nose_panel=2, cap=1, aft_panel=3, web_depth=2, root_segments=1, web_segments=6, tip_segments=1
)


def tube(**changes):
    angle = np.linspace(0, 2 * np.pi, 801)
    outline = np.column_stack([(1 + np.cos(angle)) / 2, np.sin(angle) / 2])
    section = AirfoilSection("circle", outline, TrailingEdge.ROUND)
    given = {"chord": 2 * RADIUS * np.ones(2), "twist": np.zeros(2), "pitch_axis": [0.5, 0.5]}
    return BladeStations(span=[0, LENGTH], sections=(section, section), **{**given, **changes})


def area_vectors(mesh, name):
    a, b, c = np.moveaxis(mesh.nodes[mesh.cells[TRIANGLE][mesh.cell_sets[name][TRIANGLE]]], 1, 0)
    return np.cross(b - a, c - a) / 2


def area(mesh, name):
    return np.linalg.norm(area_vectors(mesh, name), axis=1).sum()


def edge_sharing(mesh):
    """How many edges have one triangle, two, three."""
    ends = np.sort(mesh.cells[TRIANGLE][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.bincount(np.unique(ends, axis=0, return_counts=True)[1])[1:]


@pytest.fixture(scope="module")
def blade():
    return loft_blade(nrel5mw_stations(), NREL5MW_WEBS, WU2019_GRID)


@pytest.mark.parametrize("grid", [COARSE, BladeGrid(web_segments=10), BladeGrid(web_depth=1, web_segments=4)])
def test_counts_follow_the_formulas(grid):
    mesh = loft_blade(tube(), WEBS, grid)
    s, n, w, d = grid.n_segments, grid.n_around, grid.web_segments, grid.web_depth
    assert (mesh.n_nodes, mesh.n_cells) == (n * (s + 1) + 2 * (w + 1) * (d - 1), 2 * n * s + 4 * w * d)
    boundary, _, seams = edge_sharing(mesh)
    assert (boundary, seams) == (2 * n + 4 * d, 4 * w)


def test_a_centre_split_adds_one_node_and_two_triangles():
    split = BladeGrid(**{**vars(COARSE), "centre_splits": ((3, 2), (0, 11))})
    plain, mesh = loft_blade(tube(), WEBS, COARSE), loft_blade(tube(), WEBS, split)
    assert (mesh.n_nodes, mesh.n_cells) == (plain.n_nodes + 2, plain.n_cells + 4)
    np.testing.assert_array_equal(edge_sharing(mesh)[[0, 2]], edge_sharing(plain)[[0, 2]])
    np.testing.assert_array_equal(mesh.nodes[: plain.n_nodes], plain.nodes)
    # Quadrilateral (3, 2) stands between rings 3 and 4 and nodes 2 and 3 of each.
    corners = np.array([3, 3, 4, 4]) * split.n_around + [2, 3, 3, 2]
    np.testing.assert_allclose(mesh.nodes[plain.n_nodes], mesh.nodes[corners].mean(axis=0))


def test_area_of_a_tube_converges_at_second_order():
    errors = []
    for fineness in (1, 2, 4):
        grid = BladeGrid(nose_panel=4 * fineness, cap=3 * fineness, aft_panel=4 * fineness, web_segments=4)
        errors.append(1 - area(loft_blade(tube(), WEBS, grid), "skin") / (2 * np.pi * RADIUS * LENGTH))
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.15)


def test_webs_of_a_tube_are_plane_rectangles():
    mesh = loft_blade(tube(), WEBS, COARSE)
    for name, place in (("web_fore", WEBS.fore), ("web_aft", WEBS.aft)):
        nodes = mesh.nodes[np.unique(mesh.cells[TRIANGLE][mesh.cell_sets[name][TRIANGLE]])]
        np.testing.assert_allclose(nodes[:, 1], place, atol=1e-12)
        depth = 2 * np.sqrt(RADIUS**2 - place**2)
        np.testing.assert_allclose(area(mesh, name), depth * (WEBS.end - WEBS.start), rtol=1e-4)


def test_normals_of_the_skin_point_outward():
    mesh = loft_blade(tube(), WEBS, COARSE)
    corners = mesh.nodes[mesh.cells[TRIANGLE][mesh.cell_sets["skin"][TRIANGLE]]]
    outward = corners.mean(axis=1) * [1, 1, 0]
    assert (np.einsum("ei,ei->e", area_vectors(mesh, "skin"), outward) > 0).all()


def test_twist_turns_the_nose_into_the_wind():
    twist = 0.3
    mesh = loft_blade(tube(twist=[twist, twist]), WEBS, COARSE)
    nose, tail = (mesh.nodes[mesh.nodes_of(name)] for name in ("leading_edge", "trailing_edge"))
    np.testing.assert_allclose(nose[:, 0], -RADIUS * np.sin(twist))
    np.testing.assert_allclose(nose[:, 1], -RADIUS * np.cos(twist))
    np.testing.assert_allclose(tail[:, :2], -nose[:, :2], atol=1e-12)


def test_prebend_and_sweep_move_the_sections():
    straight = loft_blade(tube(), WEBS, COARSE)
    bent = loft_blade(tube(prebend=[0, -2], sweep=0.5), WEBS, COARSE)
    shift = bent.nodes - straight.nodes
    np.testing.assert_allclose(shift[:, 0], -2 * straight.nodes[:, 2] / LENGTH, atol=1e-12)
    np.testing.assert_allclose(shift[:, 1:], np.broadcast_to([0.5, 0], (straight.n_nodes, 2)), atol=1e-12)


def test_size_of_the_published_blade(blade):
    """3989 nodes, 8394 triangles ([Wu2019], section 6.2): 480 edges with three triangles, 68 with one."""
    assert (blade.n_nodes, blade.n_cells) == (3989, 8394)
    np.testing.assert_array_equal(edge_sharing(blade), [68, 12385 - 68 - 480, 480])
    assert {name: len(nodes) for name, nodes in blade.node_sets.items()} == {
        "root": 28,
        "tip": 28,
        "leading_edge": 125,
        "trailing_edge": 125,
    }


def test_published_blade_is_the_mesh_file_of_the_examples(blade):
    """An independent script wrote the file, to 1e-5 m."""
    file = read_abaqus(BLADE_FILE)
    np.testing.assert_allclose(blade.nodes, file.nodes, rtol=0, atol=5.1e-6)
    for ours, theirs in (("skin", "SKIN"), ("web_fore", "WEBF"), ("web_aft", "WEBA")):
        cells = [
            np.unique(np.sort(mesh.cells[TRIANGLE][mesh.cell_sets[name][TRIANGLE]], axis=1), axis=0)
            for mesh, name in ((blade, ours), (file, theirs))
        ]
        np.testing.assert_array_equal(*cells)
    for ours, theirs in (("root", "ROOT"), ("tip", "TIP"), ("leading_edge", "LE"), ("trailing_edge", "TE")):
        np.testing.assert_array_equal(blade.nodes_of(ours), file.nodes_of(theirs))


def test_edges_of_the_published_blade_run_from_root_to_tip(blade):
    for name in ("leading_edge", "trailing_edge"):
        span = blade.nodes[blade.nodes_of(name), 2]
        assert (np.diff(span) > 0).all()
        np.testing.assert_allclose(span[[0, -1]], [0, 61.5])


def test_a_tip_may_be_narrower_than_the_webs_are_apart():
    section = tube().sections[0]
    slender = BladeStations(
        span=[0, 18, 20], sections=(section,) * 3, chord=[3, 2, 0.4], twist=0.0, pitch_axis=0.5
    )
    mesh = loft_blade(slender, WEBS, COARSE)
    tip = mesh.nodes[mesh.nodes_of("tip")]
    np.testing.assert_allclose(np.linalg.norm(tip[:, :2], axis=1), 0.2, rtol=1e-4)
    np.testing.assert_allclose(tip[[3, 4], 1], [0.45 * 0.4, -0.45 * 0.4], rtol=1e-9)


@pytest.mark.parametrize(
    ("webs", "message"),
    [
        (ShearWebs(start=0.0, end=18.0), "beyond the blade"),
        (ShearWebs(start=2.0, end=20.5), "beyond the blade, which runs from 0 to 20"),
        (ShearWebs(start=2.0, end=18.0, fore=-1.6), r"outside the section at span 2: x/c = -0\.033"),
        (ShearWebs(start=2.0, end=18.0, aft=1.5), "outside the section"),
    ],
)
def test_webs_that_miss_the_blade(webs, message):
    with pytest.raises(MeshError, match=message):
        loft_blade(tube(), webs, COARSE)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": np.nan}, "start is nan"),
        ({"start": 18.0}, "give an end beyond the start"),
        ({"fore": 0.5, "aft": 0.5}, "give fore nearer the nose"),
    ],
)
def test_contradictory_webs(changes, message):
    with pytest.raises(MeshError, match=message):
        ShearWebs(**{"start": 2.0, "end": 18.0, **changes})


def test_grid_errors():
    with pytest.raises(MeshError, match="cap = 0"):
        BladeGrid(cap=0)
    with pytest.raises(MeshError, match=r"centre split \(124, 3\) lies outside the grid of 124 segments"):
        BladeGrid(centre_splits=((124, 3),))
