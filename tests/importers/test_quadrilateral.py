"""Quadrilaterals are cut along their shorter diagonal and keep their sense."""

import numpy as np

from supple.importers.quadrilateral import crossed_quadrilaterals, split_quadrilaterals

NODES = np.array([[0.0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 1, 0]])


def test_the_shorter_diagonal_is_cut():
    np.testing.assert_array_equal(
        split_quadrilaterals(NODES, np.array([[0, 1, 2, 3]])), [[0, 1, 3], [1, 2, 3]]
    )
    np.testing.assert_array_equal(
        split_quadrilaterals(NODES, np.array([[1, 2, 3, 0]])), [[1, 2, 3], [1, 3, 0]]
    )


def test_area_vectors_add_up():
    """A warped quadrilateral's triangles share its boundary, so its area vector (1/2) d_02 x d_13."""
    rng = np.random.default_rng(3)
    nodes = NODES + 0.3 * rng.standard_normal(NODES.shape)
    a, b, c = np.moveaxis(nodes[split_quadrilaterals(nodes, np.array([[0, 1, 2, 3]]))], 1, 0)
    total = np.cross(b - a, c - a).sum(axis=0) / 2
    np.testing.assert_allclose(total, np.cross(nodes[2] - nodes[0], nodes[3] - nodes[1]) / 2, atol=1e-14)


def test_the_diagonal_lies_inside_where_a_corner_points_inwards():
    """An arrow: its shorter diagonal runs outside, and would count the notch twice."""
    nodes = np.array([[0.0, 0, 0], [4, 1, 0], [0, 2, 0], [3, 1, 0]])
    for turn in range(4):
        quad = np.roll([0, 1, 2, 3], turn)[None]
        a, b, c = np.moveaxis(nodes[split_quadrilaterals(nodes, quad)], 1, 0)
        np.testing.assert_allclose(np.cross(b - a, c - a)[:, 2] / 2, [0.5, 0.5], atol=1e-15)
    assert not crossed_quadrilaterals(nodes, np.array([[0, 1, 2, 3]])).size


def test_nodes_that_do_not_go_round_are_found():
    quads = np.array([[0, 1, 2, 3], [0, 2, 1, 3], [1, 2, 3, 0], [0, 1, 3, 2]])
    np.testing.assert_array_equal(crossed_quadrilaterals(NODES, quads), [1, 3])
