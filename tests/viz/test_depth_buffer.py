"""Visibility against its definition: at each pixel centre the nearest triangle that holds it."""

import numpy as np

from supple.viz import depth_buffer
from supple.viz.depth_buffer import visible_triangles


def by_definition(corners, nearness, shape):
    row, column = np.indices(shape)
    points = np.stack([column.ravel() + 0.5, row.ravel() + 0.5], axis=-1)
    seen, nearest = np.full(len(points), -1), np.full(len(points), -np.inf)
    for t, (triangle, depth) in enumerate(zip(corners, nearness, strict=True)):
        edges = np.column_stack([triangle, np.ones(3)]).T
        weights = np.linalg.solve(edges, np.column_stack([points, np.ones(len(points))]).T)
        inside = weights.min(axis=0) >= 0.0
        here = depth @ weights
        nearer = inside & (here > nearest)
        seen[nearer], nearest[nearer] = t, here[nearer]
    return seen


def random_triangles(n=60, size=40.0, seed=3):
    rng = np.random.default_rng(seed)
    return rng.uniform(-0.2 * size, 1.2 * size, (n, 3, 2)), rng.normal(size=(n, 3))


def test_the_nearest_triangle_is_seen(monkeypatch):
    corners, nearness = random_triangles()
    expected = by_definition(corners, nearness, (30, 50))
    for batch in (2**20, 100):
        monkeypatch.setattr(depth_buffer, "_BATCH", batch)
        visible = visible_triangles(corners, nearness, (30, 50))
        seen = np.full(30 * 50, -1)
        seen[visible.pixel] = visible.triangle
        np.testing.assert_array_equal(seen, expected)


def test_weights_reproduce_the_pixel_centres():
    corners, nearness = random_triangles(n=5)
    visible = visible_triangles(corners, nearness, (30, 50))
    centres = np.einsum("pi,pij->pj", visible.weights, corners[visible.triangle])
    row, column = np.divmod(visible.pixel, 50)
    np.testing.assert_allclose(centres, np.stack([column + 0.5, row + 0.5], axis=-1), atol=1e-10)


def test_a_triangle_seen_edge_on_is_not_seen():
    corners = np.array([[[1.0, 1.0], [5.0, 5.0], [9.0, 9.0]]])
    assert not len(visible_triangles(corners, np.zeros((1, 3)), (10, 10)).pixel)
