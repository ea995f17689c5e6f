"""Divided meshes: every cell once, shared sections, node sets counted once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from supple.errors import MeshError
from supple.mesh import AlongAxis, ByCellSets, CellType, Mesh, block, box_beam, divided, strip

T3 = CellType.TRIANGLE3


def test_parts_hold_every_cell_once_and_share_a_section():
    mesh = box_beam(length=10.0, width=1.0, height=0.5, n_length=12, n_width=2, n_height=2)
    whole = divided(mesh, AlongAxis(3))
    cells = np.concatenate([part.cells[T3] for part in whole.parts])
    assert sorted(cells) == list(range(mesh.n_cells))
    assert [(cut.first, cut.second) for cut in whole.cuts] == [(0, 1), (1, 2)]
    for cut, x in zip(whole.cuts, (10 / 3, 20 / 3), strict=True):
        assert len(cut.nodes) == 8
        assert np.allclose(mesh.nodes[cut.nodes][:, 0], x)
    for part in whole.parts:
        assert np.array_equal(part.mesh.nodes, mesh.nodes[part.nodes])
        back = part.nodes[part.mesh.cells[T3]]
        assert np.array_equal(back, mesh.cells[T3][part.cells[T3]])


def test_a_node_set_counts_each_node_once_and_stays_whole_where_a_part_has_all_of_it():
    mesh = strip(length=4.0, width=1.0, n_length=4, n_width=2)
    on_cut = np.flatnonzero(np.isclose(mesh.nodes[:, 0], 2.0))
    sets = {"all": np.arange(mesh.n_nodes), "middle": on_cut}
    whole = divided(Mesh(mesh.nodes, mesh.cells, sets), AlongAxis(2, (1, 0, 0)))
    first, second = whole.parts
    assert np.array_equal(np.sort(first.nodes[first.mesh.node_sets["middle"]]), on_cut)
    assert "middle" not in second.mesh.node_sets
    dealt = [part.nodes[part.mesh.node_sets["all"]] for part in whole.parts]
    assert sorted(np.concatenate(dealt)) == list(range(mesh.n_nodes))


@pytest.mark.parametrize("rows", [8, 9, 5])
@pytest.mark.parametrize("kind", [CellType.HEXA8, CellType.TETRA4, CellType.TETRA10, CellType.HEXA20])
def test_a_cut_is_the_nearest_section_of_nodes(kind, rows):
    """The middle of 9 or 5 rows lies inside a row, and a cut there would weld the row."""
    mesh = block(float(rows), 1.0, 1.0, rows, 2, 1, kind)
    (cut,) = divided(mesh, AlongAxis(2, (1, 0, 0))).cuts
    assert abs(mesh.nodes[cut.nodes, 0].mean() - mesh.nodes[:, 0].mean()) < 0.51
    assert np.ptp(mesh.nodes[cut.nodes, 0]) < 1e-12


@pytest.mark.parametrize("count", [2, 3, 4])
def test_cuts_of_an_arch_are_radial(count):
    """No plane across the axis but that of symmetry spares the cells of an arch; its rows do."""
    straight = block(1.0, 0.1, 0.1, 24, 2, 2, CellType.HEXA8)
    x, y, z = straight.nodes.T
    angle, radius = np.pi * x, 1 / np.pi + z
    nodes = np.column_stack([-radius * np.cos(angle), y, radius * np.sin(angle)])
    whole = divided(Mesh(nodes, straight.cells), AlongAxis(count, (1, 0, 0)))
    assert len(whole.cuts) == count - 1
    rows = [nodes[np.isclose(x, row / 24), 0].mean() for row in range(25)]
    ends = np.linspace(nodes[:, 0].min(), nodes[:, 0].max(), count + 1)
    for cut, wanted in zip(whole.cuts, ends[1:-1], strict=True):
        assert len(cut.nodes) == 9
        assert np.ptp(angle[cut.nodes]) < 1e-9
        assert abs(nodes[cut.nodes, 0].mean() - wanted) < abs(rows - wanted).min() + 1e-9


def test_a_mesh_without_sections_is_not_cut():
    """Triangles between random points have no straight line of edges across the strip."""
    points = np.random.default_rng(3).random((60, 2)) * [4.0, 1.0]
    corners = np.array([[0, 0], [4, 0], [4, 1], [0, 1]])
    points = np.vstack([points, corners])
    mesh = Mesh(
        np.column_stack([points, np.zeros(len(points))]), {T3: Delaunay(points).simplices.astype(np.int64)}
    )
    with pytest.raises(MeshError, match=r"cut 1 of 1, at 2 along \(1, 0, 0\): no section of nodes is near"):
        divided(mesh, AlongAxis(2, (1, 0, 0)))


def test_two_legs_make_two_cuts():
    mesh = block(
        length=4.0, width=3.0, height=1.0, n_length=4, n_width=3, n_height=1, cell_type=CellType.HEXA8
    )
    kind = next(iter(mesh.cells))
    centres = mesh.nodes[mesh.cells[kind]].mean(axis=1)
    hole = (abs(centres[:, 1]) < 0.5) & (centres[:, 0] > 1) & (centres[:, 0] < 3)
    kept = mesh.cells[kind][~hole]
    used, numbers = np.unique(kept, return_inverse=True)
    whole = divided(Mesh(mesh.nodes[used], {kind: numbers.reshape(kept.shape)}), AlongAxis(2, (1, 0, 0)))
    assert [(cut.first, cut.second) for cut in whole.cuts] == [(0, 1), (0, 1)]
    assert {len(cut.nodes) for cut in whole.cuts} == {4}


def test_cell_sets_say_the_parts_and_each_cell_is_in_just_one():
    mesh = strip(length=4.0, width=1.0, n_length=4, n_width=2)
    centres = mesh.nodes[mesh.cells[T3]].mean(axis=1)[:, 0]
    sets = {"IN": {T3: np.flatnonzero(centres < 1)}, "OUT": {T3: np.flatnonzero(centres > 1)}}
    whole = divided(Mesh(mesh.nodes, mesh.cells, {}, sets), ByCellSets(("IN", "OUT")))
    assert [part.mesh.n_cells for part in whole.parts] == [len(sets["IN"][T3]), len(sets["OUT"][T3])]
    assert list(whole.parts[0].mesh.cell_sets) == ["IN"]
    short = {"IN": sets["IN"], "OUT": {T3: sets["OUT"][T3][1:]}}
    with pytest.raises(MeshError, match=r"is in 0 of the cell sets IN, OUT"):
        divided(Mesh(mesh.nodes, mesh.cells, {}, short), ByCellSets(("IN", "OUT")))


def test_impossible_divisions_are_refused():
    mesh = strip(length=4.0, width=1.0, n_length=4, n_width=2)
    with pytest.raises(MeshError, match="at least 2 parts"):
        AlongAxis(1)
    with pytest.raises(MeshError, match="has no cell: the mesh is too coarse"):
        divided(mesh, AlongAxis(20))
    with pytest.raises(MeshError, match="three finite numbers"):
        divided(mesh, AlongAxis(2, (0, 0, 0)))
    with pytest.raises(MeshError, match="at least 2 cell sets"):
        ByCellSets("IN")


def test_parts_are_numbered_from_any_of_them():
    mesh = strip(length=4.0, width=1.0, n_length=8, n_width=2)
    whole = divided(mesh, AlongAxis(4))
    ways = [(part, {cut.first, cut.second}) for part, cut in whole.neighbours_from(2)]
    assert sorted(part for part, _ in ways) == [0, 1, 3]
    assert (0, {0, 1}) in ways
