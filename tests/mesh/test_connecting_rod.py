"""The connecting rod fills its outline: exact volume as the cells shrink, round bores, fair cells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import MeshError
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, Eye, RodCells, RodOutline, connecting_rod

OUTLINE = RodOutline(0.14, 0.012, Eye(0.015, 0.022, 0.018), Eye(0.008, 0.013, 0.014))
COARSE = RodCells(around=9, ring=1, shank=8, width=3, thickness=1)
FINE = RodCells(around=18, ring=2, shank=16, width=6, thickness=2)


def volumes(mesh):
    corners = mesh.nodes[mesh.cells[mesh.only_cell_type()][:, :4]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6


def test_volume_of_the_outline_against_counting_points():
    # Monte Carlo over the bounding box, with the outline's own definition: rings and trapezoid less bores.
    big, small = OUTLINE.big, OUTLINE.small
    low, high = np.array([-big.rim, -big.rim]), np.array([OUTLINE.length + small.rim, big.rim])
    x, y = (low + (high - low) * np.random.default_rng(0).random((400_000, 2))).T
    from_big, from_small = np.hypot(x, y), np.hypot(x - OUTLINE.length, y)
    start, end = big.chord, OUTLINE.length - small.chord
    share = (x - start) / (end - start)
    half = 0.5 * ((1 - share) * big.shank_width + share * small.shank_width)
    shank = (share > 0) & (share < 1) & (abs(y) < half)
    inside = (from_big < big.rim) | (from_small < small.rim) | shank
    inside &= (from_big > big.bore) & (from_small > small.bore)
    area = np.prod(high - low) * inside.mean()
    deviation = np.prod(high - low) * np.sqrt(inside.mean() * (1 - inside.mean()) / len(x))
    assert abs(OUTLINE.volume - OUTLINE.thickness * area) < 4 * OUTLINE.thickness * deviation


def test_volume_converges_at_second_order_in_linear_cells_and_faster_in_quadratic_ones():
    def missing(cells, cell_type):
        model = solid_model(connecting_rod(OUTLINE, cells, cell_type), Isotropic(7e10, 0.33, 2710.0))
        along_x = np.zeros(model.n_dofs)
        along_x[::3] = 1.0
        return abs(1 - along_x @ (model.mass @ along_x) / (2710.0 * OUTLINE.volume))

    linear = [missing(cells, CellType.TETRA4) for cells in (COARSE, FINE)]
    quadratic = [missing(cells, CellType.TETRA10) for cells in (COARSE, FINE)]
    assert np.log2(linear[0] / linear[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(quadratic[0] / quadratic[1]) > 3.0
    assert quadratic[1] < 2e-4


def test_rod_of_the_benchmark_has_the_papers_cells():
    mesh = connecting_rod(OUTLINE, RodCells(), CellType.TETRA4)
    assert mesh.n_cells == 4374
    volume = volumes(mesh)
    corners = mesh.nodes[mesh.cells[CellType.TETRA4]]
    pairs = np.triu_indices(4, 1)
    edges = np.linalg.norm(corners[:, pairs[0]] - corners[:, pairs[1]], axis=2)
    # [Han2020]: 3.6 mm on average, 1 mm at least; here the edge of a regular tetrahedron of like volume.
    assert np.cbrt(6 * np.sqrt(2) * volume).mean() == pytest.approx(3.6e-3, rel=0.15)
    assert edges.min() > 1e-3
    # Mean-ratio quality, 1 for a regular tetrahedron.
    quality = 12 * np.cbrt(3 * volume) ** 2 / (edges**2).sum(axis=1)
    assert quality.min() > 0.45
    assert np.median(quality) > 0.7


@pytest.mark.parametrize("cell_type", [CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20])
def test_bores_and_rims_are_round_and_named(cell_type):
    mesh = connecting_rod(OUTLINE, COARSE, cell_type)
    circles = {
        "big_bore": (0.0, OUTLINE.big.bore),
        "big_rim": (0.0, OUTLINE.big.rim),
        "small_bore": (OUTLINE.length, OUTLINE.small.bore),
        "small_rim": (OUTLINE.length, OUTLINE.small.rim),
    }
    for name, (centre, radius) in circles.items():
        nodes = mesh.nodes[mesh.nodes_of(name)]
        np.testing.assert_allclose(np.hypot(nodes[:, 0] - centre, nodes[:, 1]), radius, rtol=1e-12)
    for name, z in (("z_min", -0.006), ("z_max", 0.006)):
        np.testing.assert_array_equal(np.sort(mesh.nodes_of(name)), np.flatnonzero(mesh.nodes[:, 2] == z))


def test_bores_hold_all_nodes_on_them():
    mesh = connecting_rod(OUTLINE, FINE, CellType.TETRA4)
    at_bore = np.isclose(np.hypot(mesh.nodes[:, 0], mesh.nodes[:, 1]), OUTLINE.big.bore, rtol=1e-9)
    np.testing.assert_array_equal(np.sort(mesh.nodes_of("big_bore")), np.flatnonzero(at_bore))


def test_nodes_lie_symmetrically_about_the_rods_plane():
    nodes = connecting_rod(OUTLINE, FINE, CellType.HEXA8).nodes
    mirrored = nodes * [1.0, -1.0, 1.0]
    order, image = np.lexsort(np.round(nodes, 9).T), np.lexsort(np.round(mirrored, 9).T)
    np.testing.assert_allclose(nodes[order], mirrored[image], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bore": 0.03}, "leaves no ring"),
        ({"shank_width": 0.05}, "does not meet an eye"),
        ({"rim": -1.0}, "rim = -1.0; give a finite size above zero"),
    ],
)
def test_impossible_eyes_are_refused(change, message):
    with pytest.raises(MeshError, match=message):
        replace(OUTLINE.big, **change)


def test_overlapping_eyes_are_refused():
    with pytest.raises(MeshError, match=r"overlap at a distance of 0\.03"):
        replace(OUTLINE, length=0.03)


@pytest.mark.parametrize(("name", "least"), [("around", 3), ("ring", 1), ("thickness", 1)])
def test_too_few_cells_are_refused(name, least):
    with pytest.raises(MeshError, match=f"{name} = 0; give a whole number of cells, at least {least}"):
        RodCells(**{name: 0})
