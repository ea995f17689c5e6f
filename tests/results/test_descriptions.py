"""A mesh in rows of words."""

from __future__ import annotations

from supple.mesh import strip
from supple.results.descriptions import describe_mesh


def test_a_mesh_is_described_by_its_nodes_cells_extent_and_sets():
    rows = dict(describe_mesh(strip(1.0, 0.1, 8, 2)))
    assert rows["what"] == "27 nodes"
    assert rows["x"] == "0 to 1"
    assert rows["node set root"].startswith("3 nodes, centroid (0, ")
