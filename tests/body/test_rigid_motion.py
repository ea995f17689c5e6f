from __future__ import annotations

import numpy as np
import pytest

from supple.body.rigid_motion import are_collinear, cross_of_axes, nodal_rigid_modes


@pytest.mark.parametrize("dofs_per_node", [3, 6])
def test_rigid_modes_are_translations_and_rotations_about_the_origin(dofs_per_node, rigid_field):
    nodes = np.random.default_rng(0).standard_normal((5, 3))
    modes = nodal_rigid_modes(nodes, dofs_per_node)
    for i, axis in enumerate(np.eye(3)):
        np.testing.assert_array_equal(modes[:, i], rigid_field(nodes, dofs_per_node, axis, np.zeros(3)))
        np.testing.assert_array_equal(modes[:, 3 + i], rigid_field(nodes, dofs_per_node, np.zeros(3), axis))


def test_cross_of_axes_is_a_cross_product_either_way():
    v, w = np.random.default_rng(1).standard_normal((2, 4, 3))
    np.testing.assert_allclose(np.einsum("aij,aj->ai", cross_of_axes(v), w), np.cross(w, v))
    np.testing.assert_allclose(np.einsum("aji,aj->ai", cross_of_axes(v), w), np.cross(v, w))


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_collinear_points(size):
    line = size * (np.array([3.0, 1, 2]) + np.outer([0, 1, 2.5, 4], [1, -2, 0.3]))
    assert are_collinear(line)
    assert are_collinear(line[:1])
    assert are_collinear(line[:2])
    assert not are_collinear(line + size * 1e-3 * np.random.default_rng(2).standard_normal(line.shape))
