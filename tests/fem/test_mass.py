"""Mass: rigid motions have the exact mass, first moments and inertia of the meshed volume."""

import numpy as np
import pytest

from supple.body import mesh_mass_properties, rigid_mass_properties
from supple.errors import ModelError
from supple.fem import (
    BeamSection,
    CellMass,
    HomogeneousSection,
    Isotropic,
    RodSection,
    Section,
    consistent_mass,
    finite_element_model,
    lumped_mass,
    shell_model,
    solid_model,
)
from supple.mesh import CellType, Mesh, block, box_beam, plate

SOLIDS = (CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20)


def rigid_mass(mass, centre, inertia_about_origin):
    """Mass matrix (6, 6) of a rigid body about the origin: translations, then rotations."""
    S = mass * np.cross(np.eye(3), centre)
    return np.block([[mass * np.eye(3), -S], [S, inertia_about_origin]])


def about_origin(mass, centre, second_moments):
    """Inertia from the central second moments of mass, integral of (x - c)(x - c)^T."""
    moments = second_moments + mass * np.outer(centre, centre)
    return np.trace(moments) * np.eye(3) - moments


@pytest.mark.parametrize("cell_type", SOLIDS, ids=lambda kind: kind.name)
def test_block(cell_type, material, rigid_modes):
    """Inner nodes may lie anywhere: the volume is the block."""
    mesh = block(2.0, 0.8, 0.5, 2, 2, 2, cell_type)
    nodes = mesh.nodes.copy()
    surface = (np.abs(nodes - [1.0, 0, 0]) > np.array([1.0, 0.4, 0.25]) - 1e-9).any(axis=1)
    if cell_type.n_corners == cell_type.n_nodes:
        nodes[~surface] += [0.1, -0.05, 0.03]
    shift = np.array([0.3, -1.0, 2.0])
    model = solid_model(Mesh(nodes + shift, mesh.cells), material)
    R = rigid_modes(model)
    mass = material.density * 2.0 * 0.8 * 0.5
    centre = shift + np.array([1.0, 0, 0])
    moments = mass / 12 * np.diag([2.0**2, 0.8**2, 0.5**2])
    exact = rigid_mass(mass, centre, about_origin(mass, centre, moments))
    np.testing.assert_allclose(R.T @ model.mass @ R, exact, rtol=1e-12, atol=1e-9)


def test_shell(material, rigid_modes):
    """A plate: the mid-surface, and on every rotation the rotary inertia t^2/12 of its mass."""
    flat = plate(1.4, 0.9, 3, 2)
    nodes = flat.nodes.copy()
    inner = np.setdiff1d(np.arange(len(nodes)), flat.nodes_of("boundary"))
    nodes[inner, :2] += 0.05
    shift, t = np.array([0.2, -0.3, 1.0]), 0.06
    model = shell_model(Mesh(nodes + shift, flat.cells), HomogeneousSection(material, t))
    R = rigid_modes(model)
    mass = material.density * 1.4 * 0.9 * t
    centre = shift + np.array([0.7, 0.45, 0])
    moments = mass / 12 * np.diag([1.4**2, 0.9**2, 0])
    rotary = mass * t**2 / 12 * np.eye(3)
    exact = rigid_mass(mass, centre, about_origin(mass, centre, moments) + rotary)
    np.testing.assert_allclose(R.T @ model.mass @ R, exact, rtol=1e-12, atol=1e-9)


def test_mass_of_a_closed_shell_is_the_same_in_all_directions(material, rigid_modes):
    """Translations carry the total mass; the first moments are those of the areas."""
    mesh = box_beam(2.0, 0.4, 0.3, 4, 2, 2)
    model = shell_model(mesh, HomogeneousSection(material, 0.02))
    R = rigid_modes(model)
    mass = material.density * 0.02 * 2.0 * 2 * (0.4 + 0.3)
    G = R.T @ model.mass @ R
    np.testing.assert_allclose(G[:3, :3], mass * np.eye(3), rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(G[:3, 3:], -mass * np.cross(np.eye(3), [1.0, 0, 0]), atol=1e-10 * mass)


@pytest.mark.parametrize("build", ["shell", *SOLIDS], ids=str)
def test_mass_is_positive_definite_and_lumping_keeps_the_total(build, material, distorted, rigid_modes):
    if build == "shell":
        model = shell_model(
            distorted(box_beam(1.0, 0.6, 0.4, 2, 1, 1), 0.05), HomogeneousSection(material, 0.02)
        )
    else:
        model = solid_model(distorted(block(1, 0.8, 0.6, 1, 1, 1, build), 0.05), material)
    assert np.linalg.eigvalsh(model.mass.toarray())[0] > 0
    lumped = lumped_mass(model)
    assert lumped.min() > 0
    R = rigid_modes(model)[:, :3]
    np.testing.assert_allclose(R.T @ (lumped[:, None] * R), R.T @ model.mass @ R, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("rule", [CellMass.lumped, consistent_mass])
def test_rods_vibrate_by_the_mass_of_their_model(rule):
    """omega = 2 c/h sin(k h/2) of beads; sqrt(6 (1 - cos k h) / (2 + cos k h)) c/h of linear functions."""
    n, length, c = 8, 2.0, np.sqrt(3.0 / 2.0)
    mesh = Mesh(
        np.linspace(0, length, n + 1)[:, None] * [1.0, 0, 0],
        {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])},
    )
    rod = Section(CellType.LINE2, np.arange(n), RodSection(Isotropic(3.0, 0.3, 2.0), 0.1))
    model = finite_element_model(mesh, (rod,), mass_of=rule)
    along = 3 * np.arange(1, n)
    K, M = (matrix.toarray()[np.ix_(along, along)] for matrix in (model.stiffness, model.mass))
    omega = np.sqrt(1 / np.linalg.eigvals(np.linalg.solve(K, M)).real.max())
    phase, h = np.pi / n, length / n
    beads = 2 * np.sin(phase / 2)
    linear = np.sqrt(6 * (1 - np.cos(phase)) / (2 + np.cos(phase)))
    assert omega == pytest.approx(c / h * (beads if rule is CellMass.lumped else linear), rel=1e-9)


def test_a_lumped_mass_beside_its_nodes_stays_where_it_is():
    wall = HomogeneousSection(Isotropic(1.0, 0.3, 7.0), 0.01, offset=0.05)
    mesh = plate(1.0, 0.5, 4, 2)
    section = Section(CellType.TRIANGLE3, np.arange(mesh.n_cells), wall)
    model = finite_element_model(mesh, (section,), mass_of=CellMass.lumped)
    centre = rigid_mass_properties(model.mass, mesh.nodes, 6).centre
    np.testing.assert_allclose(centre - mesh.nodes.mean(axis=0), [0, 0, 0.05], atol=1e-12)


def test_lumped_mass_of_a_beam_is_at_its_ends():
    """Half of the mass at each end, also where the offsets of the ends differ: one end may have none."""
    mesh = Mesh(np.array([[0.0, 0, 0], [2.0, 0, 0]]), {CellType.LINE2: np.array([[0, 1]])})
    arms = np.array([[[0.0, 0, 0], [0, 0.3, 0.4]]])
    bar = BeamSection(Isotropic(1.0, 0.3, 5.0), 1e-2, 1e-9, 1e-9, 1e-9, orientation=(0, 1, 0))
    model = finite_element_model(
        mesh, (Section(CellType.LINE2, np.arange(1), bar, offsets=arms),), mass_of=CellMass.lumped
    )
    assert np.linalg.eigvalsh(model.mass.toarray())[0] > 0
    half = 5.0 * 1e-2 * np.sqrt(4.25) / 2
    for node, arm in enumerate(arms[0]):
        expected = rigid_mass(half, arm, about_origin(half, arm, np.zeros((3, 3))))
        own = model.mass.toarray()[6 * node : 6 * node + 6, 6 * node : 6 * node + 6]
        np.testing.assert_allclose(own, expected, rtol=1e-9, atol=1e-7)


def test_a_lumped_mass_of_no_density_is_none():
    wall = HomogeneousSection(Isotropic(1.0, 0.3, 0.0), 0.01)
    mesh = plate(1.0, 0.5, 2, 1)
    section = Section(CellType.TRIANGLE3, np.arange(mesh.n_cells), wall)
    mass = finite_element_model(mesh, (section,), mass_of=CellMass.lumped).mass
    assert (mass.data == 0).all()


@pytest.mark.parametrize("rule", [CellMass.lumped, consistent_mass])
def test_a_share_of_the_mass_of_shells(rule):
    """Mass and first moments scale by cell; of the mesh they are those of the matrix."""
    wall = HomogeneousSection(Isotropic(1.0, 0.3, 7.0), 0.01, offset=0.05)
    mesh = plate(1.0, 0.5, 4, 2)
    cells = np.arange(mesh.n_cells)
    share = np.random.default_rng(0).uniform(0.5, 1.0, mesh.n_cells)
    section = Section(CellType.TRIANGLE3, cells, wall, mass_share=share)
    model = finite_element_model(mesh, (section,), mass_of=rule)
    x = section.corners(mesh)
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1) / 2
    centre = (share * area) @ x.mean(axis=1) / (share @ area) + [0, 0, 0.05]
    for found in (rigid_mass_properties(model.mass, mesh.nodes, 6), mesh_mass_properties(model)):
        assert found.mass == pytest.approx(0.07 * share @ area, rel=1e-12)
        np.testing.assert_allclose(found.centre, centre, atol=1e-12)
    np.testing.assert_array_equal(section.of(cells[3:5]).mass_share, share[3:5])
    with pytest.raises(ModelError, match="mass_share is for shells only"):
        Section(CellType.LINE2, cells[:1], RodSection(Isotropic(1.0, 0.3, 1.0), 1.0), mass_share=share[:1])
