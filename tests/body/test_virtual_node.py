from __future__ import annotations

import numpy as np
import pytest

from supple.body import AveragingInterface, RigidInterface
from supple.body.virtual_node import virtual_nodes
from supple.errors import ModelError

NODES = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [3, 3, 3]])


def place(*interfaces, dofs_per_node=6):
    return virtual_nodes("arm", NODES, dofs_per_node, interfaces)


def test_positions_default_to_centroids():
    rigid, mean, weighted, given = place(
        RigidInterface("a", [0, 1]),
        AveragingInterface("b", [2, 3]),
        AveragingInterface("c", [2, 3], weights=[3, 1]),
        AveragingInterface("d", [5], position=[7, 8, 9]),
    )
    np.testing.assert_array_equal(rigid.position, [0.5, 0, 0])
    np.testing.assert_array_equal(mean.position, [1, 0.5, 0])
    np.testing.assert_array_equal(weighted.position, [1.5, 0.25, 0])
    np.testing.assert_array_equal(given.position, [7, 8, 9])
    assert rigid.is_rigid
    assert not mean.is_rigid


def test_a_node_may_be_rigid_in_one_interface_and_averaged_in_others():
    assert (
        len(place(RigidInterface("a", [0, 1]), AveragingInterface("b", [1, 2]), AveragingInterface("c", [1])))
        == 3
    )


@pytest.mark.parametrize("kind", [RigidInterface, AveragingInterface])
@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        ([], "body 'arm', interface 'tip': it has no nodes"),
        ([0, 6], "there is no node 6; the body's nodes are 0 to 5"),
        ([-1, 2], "there is no node -1"),
        ([0, 3, 0], "node 0 is listed 2 times"),
        ([0.5], "nodes must be a list of node numbers, not float64"),
        ([[0, 1], [2, 3]], r"nodes must be a list of node numbers, not int64 of shape \(2, 2\)"),
    ],
)
def test_nodes_that_cannot_be(kind, nodes, message):
    with pytest.raises(ModelError, match=message):
        place(kind("tip", nodes))


@pytest.mark.parametrize("kind", [RigidInterface, AveragingInterface])
@pytest.mark.parametrize("nodes", [[5], [0, 3], [0, 1, 2]])
def test_solid_nodes_on_a_line_cannot_carry_a_rotation(kind, nodes):
    with pytest.raises(
        ModelError, match=f"its {len(nodes)} nodes lie on one line or point.*cannot carry a rotation"
    ):
        place(kind("tip", nodes), dofs_per_node=3)
    place(kind("tip", nodes), dofs_per_node=6)
    place(kind("tip", [0, 1, 3]), dofs_per_node=3)


def test_a_node_cannot_be_rigid_twice():
    with pytest.raises(
        ModelError, match=r"interface 'b': node 1 \(one of 2\) is already rigid in interface 'a'"
    ):
        place(RigidInterface("a", [0, 1, 2]), RigidInterface("b", [4, 1, 2]))


def test_names_must_differ():
    with pytest.raises(ModelError, match="interface 'a': another interface has this name"):
        place(RigidInterface("a", [0]), AveragingInterface("a", [1]))


@pytest.mark.parametrize("kind", [RigidInterface, AveragingInterface])
@pytest.mark.parametrize("position", [[1, 2], [0, 0, np.nan]])
def test_a_position_is_three_numbers(kind, position):
    with pytest.raises(ModelError, match="interface 'a': position must be three finite numbers"):
        place(kind("a", [0], position=position))


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ([1, 2, 3], r"2 nodes but weights of shape \(3,\)"),
        ([1, 0], "weights must be positive numbers; the smallest is 0"),
        ([1, -2], "weights must be positive numbers; the smallest is -2"),
        ([1, np.nan], "weights must be positive numbers"),
    ],
)
def test_weights_that_cannot_be(weights, message):
    with pytest.raises(ModelError, match=message):
        place(AveragingInterface("a", [0, 1], weights=weights))
