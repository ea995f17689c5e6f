"""Quadrilaterals are cut along their shorter diagonal and keep their sense."""

import numpy as np

from supple.importers.quadrilateral import split_quadrilaterals

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
