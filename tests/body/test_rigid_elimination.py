from __future__ import annotations

import numpy as np
import pytest

from supple.body.coordinates import rigid_elimination

NODES = np.random.default_rng(0).standard_normal((9, 3))
SETS = [(np.array([7, 2, 3]), np.array([1.0, 2, 3])), (np.array([0, 5, 8]), np.zeros(3))]


@pytest.mark.parametrize("dofs_per_node", [3, 6])
def test_the_nodes_of_a_set_follow_their_virtual_node(dofs_per_node):
    T = rigid_elimination(NODES, dofs_per_node, SETS)
    assert T.shape == (9 * dofs_per_node, 3 * dofs_per_node + 12)
    q = np.random.default_rng(1).standard_normal(T.shape[1])
    nodal = (T @ q).reshape(9, dofs_per_node)
    np.testing.assert_array_equal(nodal[[1, 4, 6]].ravel(), q[: 3 * dofs_per_node])
    for (node_ids, position), virtual in zip(SETS, (q[-12:-6], q[-6:]), strict=True):
        u, theta = virtual[:3], virtual[3:]
        np.testing.assert_allclose(
            nodal[node_ids, :3], u + np.cross(theta, NODES[node_ids] - position), atol=1e-14
        )
        if dofs_per_node == 6:
            np.testing.assert_array_equal(nodal[node_ids, 3:], np.tile(theta, (3, 1)))


def test_without_sets_it_is_the_identity():
    np.testing.assert_array_equal(rigid_elimination(NODES, 3, []).toarray(), np.eye(27))


def test_it_is_sparse():
    T = rigid_elimination(NODES, 6, SETS)
    per_node = 6 + 6  # identity blocks and the cross product of the arm
    assert T.nnz == 18 + per_node * 6
