"""Models: which meshes, walls and materials go together."""

import numpy as np
import pytest

from supple.errors import MeshError, ModelError, SuppleWarning
from supple.fem import (
    Anisotropic,
    BeamSection,
    HomogeneousSection,
    Isotropic,
    Section,
    finite_element_model,
    parts_of_model,
    shell_model,
    solid_model,
)
from supple.mesh import CellType, DividedMesh, Mesh, block, mesh_part, plate


@pytest.fixture
def halves():
    mesh = plate(2.0, 1.0, 4, 2)
    triangles = mesh.cells[CellType.TRIANGLE3]
    left = mesh.nodes[triangles].mean(axis=1)[:, 0] < 1
    sets = {"left": left, "right": ~left, "most": mesh.nodes[triangles].mean(axis=1)[:, 0] < 1.5}
    sets = {name: {CellType.TRIANGLE3: np.flatnonzero(where)} for name, where in sets.items()}
    return Mesh(mesh.nodes, mesh.cells, mesh.node_sets, sets)


def test_walls_of_cell_sets_add_up(halves, material):
    """Mass of the halves in proportion to their thickness; the same walls give the same model."""
    thin, thick = HomogeneousSection(material, 0.01), HomogeneousSection(material, 0.03)
    along_x = np.tile([1.0, 0, 0, 0, 0, 0], halves.n_nodes)
    mixed = shell_model(halves, {"left": thin, "right": thick})
    assert along_x @ mixed.mass @ along_x == pytest.approx(material.density * (0.01 + 0.03))
    split, whole = shell_model(halves, {"left": thin, "right": thin}), shell_model(halves, thin)
    np.testing.assert_allclose(
        split.stiffness.toarray(), whole.stiffness.toarray(), rtol=0, atol=1e-13 * whole.stiffness.max()
    )


def test_the_model_says_how_far_it_may_turn(material):
    shell = shell_model(plate(1.0, 1.0, 1, 1), HomogeneousSection(material, 0.01))
    solid = solid_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.TETRA4), material)
    assert (shell.rotation_limit, solid.rotation_limit) == (0.5, np.inf)
    assert (shell.n_dofs, solid.n_dofs) == (24, 24)


def test_unknown_cell_set(halves, material):
    with pytest.raises(MeshError, match="no cell set 'centre' in this mesh; it has 'left', 'right', 'most'"):
        shell_model(halves, {"centre": HomogeneousSection(material, 0.01)})


def test_cells_without_a_wall(halves, material):
    with pytest.raises(ModelError, match="8 of 16 TRIANGLE3 cells, first 8, are in none of the cell sets"):
        shell_model(halves, {"left": HomogeneousSection(material, 0.01)})


def test_cells_with_two_walls(halves, material):
    wall = HomogeneousSection(material, 0.01)
    with pytest.raises(
        ModelError, match="12 TRIANGLE3 cells, first 0, are in more than one of the cell sets"
    ):
        shell_model(halves, dict.fromkeys(("left", "right", "most"), wall))


def test_a_shell_of_solid_cells(material):
    with pytest.raises(ModelError, match="a shell model takes TRIANGLE3 cells; the mesh has HEXA8"):
        shell_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA8), HomogeneousSection(material, 0.01))


def test_a_solid_of_triangles(material):
    with pytest.raises(ModelError, match=r"a solid model takes .* cells; the mesh has TRIANGLE3"):
        solid_model(plate(1.0, 1.0, 1, 1), material)


def test_a_shell_of_a_bare_material(material):
    with pytest.raises(ModelError, match="a shell needs a wall, not Isotropic"):
        shell_model(plate(1.0, 1.0, 1, 1), material)


def test_a_solid_of_a_wall(material):
    with pytest.raises(ModelError, match="or Anisotropic material, not HomogeneousSection"):
        solid_model(block(1.0, 1.0, 1.0, 1, 1, 1, CellType.TETRA4), HomogeneousSection(material, 0.01))


def test_a_wall_thicker_than_the_mesh(material):
    """20 mm given as 20 on a plate of 1 m."""
    with pytest.raises(ModelError, match=r"wall thickness 20 exceeds the size of the whole mesh, 1\.41421"):
        shell_model(plate(1.0, 1.0, 2, 2), HomogeneousSection(material, 20.0))


def test_a_wall_thicker_than_its_elements(material):
    with pytest.warns(
        SuppleWarning, match=r"wall thickness 0\.5 is 10 times the size of its elements, 0\.05"
    ):
        shell_model(plate(1.0, 1.0, 20, 20), HomogeneousSection(material, 0.5))


def test_parts_of_a_model_keep_what_each_cell_has(rng):
    """Solids with axes and beams with offsets in one model: the stiffness of the parts adds up to its own."""
    bricks = block(3.0, 1.0, 1.0, 3, 1, 1, CellType.HEXA8)
    edge = np.flatnonzero((bricks.nodes[:, 1] < -0.4) & (bricks.nodes[:, 2] < -0.4))
    lines = np.column_stack([edge[:-1], edge[1:]])
    mesh = Mesh(bricks.nodes, {CellType.HEXA8: bricks.cells[CellType.HEXA8], CellType.LINE2: lines})
    axes = np.array([np.linalg.qr(rng.normal(size=(3, 3))).Q for _ in range(3)])
    stiff = Anisotropic(np.diag([5.0, 2, 1, 0.3, 0.4, 0.5]), 1.0)
    stringer = BeamSection(Isotropic(1.0, 0.3, 1.0), 1e-2, 1e-5, 1e-5, 1e-5)
    order = np.array([2, 0, 1])
    model = finite_element_model(
        mesh,
        (
            Section(CellType.HEXA8, order, stiff, directions=axes),
            Section(CellType.LINE2, order, stringer, offsets=0.1 * rng.normal(size=(3, 2, 3))),
        ),
    )
    total = np.zeros((model.n_dofs, model.n_dofs))
    parts = tuple(mesh_part(mesh, {kind: np.array(cells) for kind in mesh.cells}) for cells in ([0, 1], [2]))
    for part, own in zip(parts, parts_of_model(model, DividedMesh(mesh, parts, ())), strict=True):
        rows = (6 * part.nodes[:, None] + np.arange(6)).ravel()
        total[np.ix_(rows, rows)] += own.stiffness.toarray()
    np.testing.assert_allclose(total, model.stiffness.toarray(), atol=1e-12)
