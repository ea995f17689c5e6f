"""Cameras keep lengths and hands."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.viz import Camera


def test_axes_are_right_up_and_towards():
    camera = Camera.looking(along=[0.0, 1.0, 0.0], up=[0.0, 0.0, 1.0])
    page, nearness = camera.project(np.eye(3))
    np.testing.assert_allclose(page, [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]], atol=1e-15)
    np.testing.assert_allclose(nearness, [0.0, -1.0, 0.0], atol=1e-15)


def test_projection_keeps_lengths_across_the_line_of_sight():
    camera = Camera.looking(along=[1.0, 2.0, -0.5], up=[0.0, 0.2, 1.0])
    points = np.random.default_rng(0).normal(size=(9, 3))
    page, nearness = camera.project(points)
    np.testing.assert_allclose(np.sum(page**2, axis=1) + nearness**2, np.sum(points**2, axis=1))


def test_three_quarter_view_lays_the_longest_extent_to_the_right_and_the_thinnest_up():
    corners = np.array(np.meshgrid([0.0, 1.0], [0.0, 0.1], [0.0, 10.0])).reshape(3, -1).T
    page, _ = Camera.three_quarter(corners).project(np.eye(3))
    assert page[2, 0] > 0.8
    assert page[1, 1] > 0.8
    assert abs(page[1, 0]) < 1e-12


def test_impossible_directions_are_refused():
    with pytest.raises(ModelError, match="not parallel"):
        Camera.looking(along=[0.0, 0.0, 1.0], up=[0.0, 0.0, -2.0])
    with pytest.raises(ModelError, match="orthonormal and right-handed"):
        Camera(np.diag([1.0, 1.0, -1.0]))
