"""Mass, centre and inertia: of mass matrices and of meshes, against each other and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.solid_blocks import solid_block

from supple.body import check_elements, mesh_mass_properties, rigid_mass_properties
from supple.fem import BeamSection, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.mesh import CellType, Mesh, block, cylinder, cylinder_shell

MATERIAL = Isotropic(1e9, 0.2, 1000.0)


def moved(mesh):
    """The mesh away from the origin and turned, so that nothing is zero by symmetry."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3))).Q
    turn *= np.linalg.det(turn)
    return Mesh(mesh.nodes @ turn.T + [5.0, -3.0, 2.0], mesh.cells), turn


@pytest.mark.parametrize("kind", [kind for kind in CellType if kind.dimension == 3])
def test_a_block_has_the_inertia_of_the_formula(kind):
    a, b, c = 2.0, 1.0, 0.5
    mesh, turn = moved(solid_block(a, b, c, 2, 2, 1, kind))
    model = solid_model(mesh, MATERIAL)
    mass = 1000 * a * b * c
    inertia = turn @ np.diag([b**2 + c**2, a**2 + c**2, a**2 + b**2]) @ turn.T * mass / 12
    middle = (mesh.nodes.min(axis=0) + mesh.nodes.max(axis=0)) / 2
    for found in (mesh_mass_properties(model), rigid_mass_properties(model.mass, mesh.nodes, 3)):
        assert found.mass == pytest.approx(mass, rel=1e-12)
        np.testing.assert_allclose(found.centre, middle, rtol=1e-12)
        np.testing.assert_allclose(found.inertia, inertia, rtol=1e-9, atol=1e-9 * mass)


def test_the_centre_of_nodes_is_not_the_centre_of_mass():
    """Cells of growing length: a block has its centre in the middle, its nodes have theirs near an end."""
    even = block(2.0, 1.0, 0.5, 8, 2, 2, CellType.HEXA8)
    nodes = even.nodes - even.nodes.min(axis=0)
    nodes[:, 0] = nodes[:, 0] ** 3 / 4
    mesh = Mesh(nodes, even.cells)
    model = solid_model(mesh, MATERIAL)
    assert abs(nodes[:, 0].mean() - 1.0) > 0.3
    for found in (mesh_mass_properties(model), rigid_mass_properties(model.mass, mesh.nodes, 3)):
        np.testing.assert_allclose(found.centre, [1.0, 0.5, 0.25], rtol=1e-12)
        np.testing.assert_allclose(
            np.diag(found.inertia), [1.25 / 12 * 1000, 4.25 / 12 * 1000, 5 / 12 * 1000]
        )


def assert_agree(matrix, mesh):
    assert matrix.mass == pytest.approx(mesh.mass, rel=1e-12)
    np.testing.assert_allclose(matrix.centre, mesh.centre, rtol=1e-12)
    np.testing.assert_allclose(matrix.inertia, mesh.inertia, atol=1e-10 * abs(mesh.inertia).max())


def test_a_shell_agrees_with_its_mesh():
    mesh, _ = moved(cylinder_shell(1.0, 0.4, 6, 12))
    model = shell_model(mesh, HomogeneousSection(MATERIAL, 0.1))
    assert_agree(rigid_mass_properties(model.mass, mesh.nodes, 6), mesh_mass_properties(model))


def test_a_stubby_beam_has_the_inertia_of_a_bar():
    """A bar of a x b x c as one line of beams: m (b^2 + c^2) / 12 about itself, as a block has it."""
    a, b, c = 1.0, 0.4, 0.3
    line = np.column_stack([np.linspace(0, a, 5), np.zeros(5), np.zeros(5)])
    cells = np.column_stack([np.arange(4), np.arange(1, 5)])
    mesh, turn = moved(Mesh(line, {CellType.LINE2: cells}))
    section = BeamSection(
        MATERIAL, b * c, c * b**3 / 12, b * c**3 / 12, 1e-3, orientation=turn @ [0.0, 1.0, 0.0]
    )
    model = shell_model(mesh, section)
    expected = turn @ np.diag([b**2 + c**2, a**2 + c**2, a**2 + b**2]) @ turn.T * 1000 * a * b * c / 12
    found = mesh_mass_properties(model)
    np.testing.assert_allclose(found.inertia, expected, atol=1e-9 * expected.max())
    assert_agree(rigid_mass_properties(model.mass, mesh.nodes, 6), found)


@pytest.mark.parametrize("kind", [CellType.TETRA10, CellType.HEXA20])
def test_curved_cells_have_the_volume_of_their_own_map(kind):
    """Eight cells around a cylinder: their chords enclose a tenth less than it, their arcs 0.3 %."""
    radius, length = 1.0, 3.0
    mesh, _ = moved(cylinder(radius, length, 2, 1, 3, kind))
    model = solid_model(mesh, MATERIAL)
    found, matrix = mesh_mass_properties(model), rigid_mass_properties(model.mass, mesh.nodes, 3)
    assert found.mass == pytest.approx(1000 * np.pi * radius**2 * length, rel=3e-3)
    assert_agree(matrix, found)
    check = check_elements(model, n_frequencies=0)
    assert check.is_accepted


def test_no_mass_has_no_centre():
    found = rigid_mass_properties(np.zeros((6, 6)), np.eye(2, 3), 3)
    assert found.mass == 0
    np.testing.assert_array_equal(found.inertia, 0)
