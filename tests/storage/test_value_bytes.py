"""Bytes of values tell apart what sums do not."""

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar
from scipy import sparse

from supple.body import FullBody, MeanAxisFrame, RigidBody, flexible_body
from supple.fem import solid_model
from supple.integrate import Run
from supple.machine import Placed, SampledController, System, TorqueBetween
from supple.mesh import CellType, Mesh
from supple.simulation.description import inputs_of
from supple.storage.run_inputs import ORDER_OF_CONTROLLERS, changes
from supple.storage.value_bytes import bytes_of, digest_of_parts


def digest(value):
    return digest_of_parts(bytes_of(value))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (np.array([1.0, -1.0]), np.array([-1.0, 1.0])),
        (np.array([1.0, 2.0]), np.array([2.0, 1.0])),
        (sparse.csr_array(np.diag([1.0, 2.0])), sparse.csr_array(np.diag([2.0, 1.0]))),
        (CellType.TETRA4, CellType.HEXA8),
        ({"a": 1.0}, {"b": 1.0}),
        (["a", "b"], ["ab"]),
    ],
)
def test_values_that_differ_have_other_digests(one, other):
    assert digest(one) == digest(one)
    assert digest(one) != digest(other)


def test_a_full_body_with_one_node_elsewhere_is_another():
    """Its matrices differ in a few places only, which a product with a vector hardly sees."""
    model = bar(CellType.TETRA4)
    nodes = model.mesh.nodes.copy()
    nodes[5, 1] += 1e-9
    other = solid_model(Mesh(nodes, model.mesh.cells, model.mesh.node_sets), SOFT)

    def body_inputs(model):
        full = FullBody(flexible_body("bar", model), MeanAxisFrame())
        return inputs_of(System([Placed(full)]), Run(1.0, 1.0), "case")["body 'bar'"]

    assert body_inputs(model) == body_inputs(model)
    assert body_inputs(model) != body_inputs(other)


def test_the_order_of_controllers_is_an_input_that_older_files_lack():
    """States of controllers are stored by number."""
    stone = RigidBody("stone", 1.0, np.zeros(3), np.eye(3), {"end": np.zeros(3)})
    both = [
        SampledController(
            name=name,
            reads={},
            drives={name: TorqueBetween(first="ground", second="stone.end", axis=(0, 0, 1), torque=0.0)},
            law=print,
            every=0.1,
        )
        for name in "ab"
    ]
    here, there = (
        inputs_of(System([stone], controllers=own), Run(1.0, 1.0), "case") for own in (both, both[::-1])
    )
    assert changes(there, here) == "the order of the controllers was b, a and is a, b"
    assert not changes({name: own for name, own in there.items() if name != ORDER_OF_CONTROLLERS}, here)
