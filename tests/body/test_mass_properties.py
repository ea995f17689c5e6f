"""Mass, centre and inertia: of mass matrices and of meshes, against each other and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import mesh_mass_properties, rigid_mass_properties
from supple.fem import HomogeneousWall, Isotropic, shell_model, solid_model
from supple.mesh import CellType, Mesh, block, cylinder_shell

MATERIAL = Isotropic(1e9, 0.2, 1000.0)


def moved(mesh):
    """The mesh away from the origin and turned, so that nothing is zero by symmetry."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3))).Q
    turn *= np.linalg.det(turn)
    return Mesh(mesh.nodes @ turn.T + [5.0, -3.0, 2.0], mesh.cells), turn


@pytest.mark.parametrize("kind", [kind for kind in CellType if kind.dimension == 3])
def test_a_block_has_the_inertia_of_the_formula(kind):
    a, b, c = 2.0, 1.0, 0.5
    mesh, turn = moved(block(a, b, c, 2, 2, 1, kind))
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


def test_a_shell_agrees_with_its_mesh_up_to_its_rotary_inertia():
    mesh, _ = moved(cylinder_shell(1.0, 0.4, 6, 12))
    wall = HomogeneousWall(MATERIAL, 0.01)
    model = shell_model(mesh, wall)
    sheet, matrix = mesh_mass_properties(model), rigid_mass_properties(model.mass, mesh.nodes, 6)
    assert matrix.mass == pytest.approx(sheet.mass, rel=1e-12)
    np.testing.assert_allclose(matrix.centre, sheet.centre, rtol=1e-12)
    rotary = wall.rotary_inertia_per_area / wall.mass_per_area * sheet.mass
    np.testing.assert_allclose(matrix.inertia - sheet.inertia, rotary * np.eye(3), atol=1e-10 * sheet.mass)


def test_no_mass_has_no_centre():
    found = rigid_mass_properties(np.zeros((6, 6)), np.eye(2, 3), 3)
    assert found.mass == 0
    np.testing.assert_array_equal(found.inertia, 0)
