"""Von Mises histories are the same by stress modes and by the recovery of full vectors."""

from dataclasses import replace

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, flexible_body
from supple.errors import ModelError
from supple.fem import (
    Attached,
    Isotropic,
    RigidPiece,
    finite_element_model,
    solid_model,
    stress_recovery,
    von_mises,
)
from supple.mesh import CellType, block
from supple.quantities import von_mises_history
from supple.quantities.stress_history import equivalent_stress
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce


@pytest.fixture
def model():
    return solid_model(block(1.0, 0.2, 0.1, 4, 1, 1, CellType.TETRA10), Isotropic(2.1e11, 0.3, 7800.0))


@pytest.fixture(params=["nonlinear", "linear"])
def bodies(request, model):
    """A body without interfaces, so that its coordinates are the nodal freedoms: full and reduced."""
    body = flexible_body("block", model)
    if request.param == "linear":
        body = body.linearized()
    frame = MeanAxisFrame()
    return FullBody(body, frame), reduce(
        body, frame, NormalModes(5), derivatives=NoDerivatives(), loads=NoLoads
    )


@pytest.mark.parametrize("nodes", [None, [11, 3]])
def test_full_and_reduced_bodies_agree(bodies, model, nodes):
    full, reduced = bodies[0], replace(bodies[1], condensed=None)  # the full body moves in the columns alone
    gamma = np.random.default_rng(0).normal(size=(4, 5)) / reduced.frequencies
    gamma *= 0.2 / np.abs(reduced.expand(gamma)).max()
    found = von_mises_history(reduced, model, gamma, nodes)
    assert found.shape == (4, model.mesh.n_nodes if nodes is None else 2)
    expected = von_mises_history(full, model, gamma @ reduced.nodal_basis.T, nodes)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_a_linear_full_body_has_the_stress_of_its_linear_strain(bodies, model):
    full, reduced = bodies
    q = (reduced.nodal_basis @ (10.0 / reduced.frequencies))[None]
    doubled = von_mises_history(full, model, 2 * q) / von_mises_history(full, model, q)
    if full.is_linear:
        np.testing.assert_allclose(doubled, 2.0, rtol=1e-9)
    else:
        assert np.abs(doubled - 2.0).max() > 1e-3
        expected = von_mises(stress_recovery(model).at_nodes(q[0])).max(axis=1)
        np.testing.assert_allclose(von_mises_history(full, model, q)[0], expected, rtol=1e-12)


def test_nodes_outside_the_body_are_refused(bodies, model):
    full, reduced = bodies
    for body, r in ((full, full.n_coordinates), (reduced, 5)):
        with pytest.raises(ModelError, match="node numbers 999 to 999; the body has 81 nodes"):
            von_mises_history(body, model, np.zeros((1, r)), [999])


def test_nodes_without_elements_have_no_stress(model):
    """A reference node of a tie: NaN in files of results, of full as of reduced bodies."""
    mesh = replace(
        model.mesh,
        nodes=np.vstack([model.mesh.nodes, [0.5, 0.1, 1.0]]),
        node_ids=np.arange(82),
        links=np.array([[81, 0]]),
    )
    with_node = finite_element_model(
        mesh,
        model.sections,
        attached=Attached(rigid=(RigidPiece("tie", np.array([0, 1, 2, 81]), mesh.nodes[81]),)),
    )
    body = flexible_body("block", with_node)
    frame = MeanAxisFrame()
    full = FullBody(body, frame)
    reduced = reduce(body, frame, NormalModes(5), derivatives=NoDerivatives(), loads=NoLoads)
    gamma = 1e-3 * np.eye(5)[:2] / reduced.frequencies
    own, *_ = np.linalg.lstsq(body.expansion.toarray(), reduced.nodal_basis, rcond=None)
    for form, q in ((full, gamma @ own.T), (reduced, gamma)):
        found = equivalent_stress(form, with_node)(q)
        assert np.isnan(found).nonzero()[1].tolist() == [81, 81]
        np.testing.assert_allclose(found[:, :81], von_mises_history(form, with_node, q, np.arange(81)))
