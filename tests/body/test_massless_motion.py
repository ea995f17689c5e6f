"""The mass that four points of a ten-node tetrahedron see is singular; its motions are condensed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from supple.algebra import lowest_modes
from supple.body import (
    AveragingInterface,
    NodalFixedFrame,
    RigidInterface,
    Verdict,
    check_model,
    rigid_mass_properties,
    superelement,
)
from supple.errors import ModelError
from supple.fem import CellMass, Isotropic, solid_model
from supple.fem.mass import nodal_mass_matrix
from supple.fem.solid_element import SolidElement, solid_mass
from supple.mesh import CellType, block
from supple.mesh.quadrature import four_point_tetrahedron
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce

STEEL = Isotropic(2.1e11, 0.3, 7850.0)


@pytest.fixture(scope="module")
def bar():
    """A bar of ten-node tetrahedra whose mass CalculiX would integrate with four points."""
    mesh = block(1.0, 0.1, 0.1, 3, 1, 1, CellType.TETRA10)
    model = solid_model(mesh, STEEL)
    element = SolidElement(CellType.TETRA10, four_point_tetrahedron(), four_point_tetrahedron())
    cells = mesh.cells[CellType.TETRA10]
    mass = CellMass(cells, solid_mass(element, mesh.nodes[cells], STEEL.density))
    return mesh, model.stiffness, nodal_mass_matrix((mass,), mesh.n_nodes, 3)


def pencil_frequencies(K, M, count):
    """Of K x = omega^2 M x from M x = mu (K + s M) x, which takes a singular M as it is."""
    shift = 1e6
    mu = linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1]
    return np.sqrt(1 / mu[6 : 6 + count] - shift)


def test_the_mass_is_singular(bar):
    mesh, _, M = bar
    scale = 1 / np.sqrt(M.diagonal())
    assert (np.linalg.eigvalsh(M.toarray() * np.outer(scale, scale)) < 1e-9).sum() > 3
    assert rigid_mass_properties(M, mesh.nodes, 3).mass == pytest.approx(78.5)


def test_a_body_of_it_vibrates_as_the_pencil(bar):
    mesh, K, M = bar
    body = superelement("bar", mesh.nodes, K, M, dofs_per_node=3)
    assert np.linalg.eigvalsh(body.mass.toarray())[0] > 0
    assert body.n < 3 * mesh.n_nodes
    found = np.sqrt(lowest_modes(body.stiffness, body.mass, 14).values[6:])
    np.testing.assert_allclose(found, pencil_frequencies(K.toarray(), M.toarray(), 8), rtol=1e-8)
    np.testing.assert_allclose(
        rigid_mass_properties(body.nodal_mass, body.nodes, 3).inertia,
        rigid_mass_properties(M, mesh.nodes, 3).inertia,
    )
    # Rigid motions of the coordinates are rigid motions of all nodes.
    moved = (body.expansion @ body.rigid_modes[:, :3]).reshape(-1, 3, 3)
    np.testing.assert_allclose(moved, np.broadcast_to(np.eye(3), moved.shape), atol=1e-9)


@pytest.mark.parametrize("interface", [RigidInterface, AveragingInterface])
def test_it_is_reduced_as_any_other(bar, interface):
    mesh, K, M = bar
    ends = [interface(name, mesh.nodes_of(name)) for name in ("root", "tip")]
    body = superelement("bar", mesh.nodes, K, M, dofs_per_node=3, interfaces=ends)
    reduced = reduce(
        body, NodalFixedFrame("root"), CraigBampton(8), derivatives=NoDerivatives(), loads=NoLoads
    )
    held = body.interface("root").motion.toarray()
    exact = np.sqrt(body.lowest_modes(3, held).values)
    np.testing.assert_allclose(reduced.frequencies[:3], exact, rtol=1e-3)


def test_the_check_names_nodes_and_counts(bar):
    mesh, K, M = bar
    check = check_model(mesh.nodes, K, M, dofs_per_node=3, node_ids=100 + np.arange(mesh.n_nodes))
    assert check.is_accepted
    (found,) = [each for each in check.findings if each.what == "positive mass"]
    assert found.verdict is Verdict.OK
    assert "motions without mass, at nodes 1" in found.seen
    expected = pencil_frequencies(K.toarray(), M.toarray(), 6) / (2 * np.pi)
    np.testing.assert_allclose(check.frequencies, expected, rtol=1e-7)


def test_entries_of_six_digits_are_condensed_as_well(bar):
    mesh, K, M = bar
    rounded = M.copy()
    rounded.data = np.array([float(f"{value:.6e}") for value in M.data])
    body = superelement("bar", mesh.nodes, K, rounded, dofs_per_node=3, rigid_tolerance=1e-5)
    found = np.sqrt(lowest_modes(body.stiffness, body.mass, 10).values[6:])
    np.testing.assert_allclose(found, pencil_frequencies(K.toarray(), M.toarray(), 4), rtol=1e-4)


def test_without_stiffness_there_it_is_refused(bar):
    """A motion without mass that costs no energy either: the stiffness of the pencil is not regular."""
    mesh, K, M = bar
    scale = 1 / np.sqrt(M.diagonal())
    kernel = scale * np.linalg.eigh(M.toarray() * np.outer(scale, scale))[1][:, 0]
    force = K @ kernel
    loose = K.toarray() - np.outer(force, force) / (kernel @ force)
    with pytest.raises(ModelError, match=r"motions without mass have no stiffness either"):
        superelement("bar", mesh.nodes, loose, M, dofs_per_node=3)
    check = check_model(mesh.nodes, loose, M, dofs_per_node=3, n_frequencies=0)
    assert not check.is_accepted
