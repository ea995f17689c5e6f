"""Stress: Hooke's law on uniform fields, bending through the thickness, rotation of the axes."""

import numpy as np
import pytest

from supple.errors import MeshError, ModelError
from supple.fem import (
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    RodSection,
    Section,
    cells_without_stress,
    finite_element_model,
    has_stress,
    has_stress_on_faces,
    model_of_cells,
    node_of_several_walls,
    shell_model,
    solid_model,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)
from supple.mesh import CellType, Mesh, block, plate
from supple.mesh.facet_curvature import turned_over

SOLIDS = (CellType.TETRA4, CellType.TETRA10, CellType.HEXA8, CellType.HEXA20)


def tensor(stress):
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))


def test_von_mises_of_simple_states():
    """Tension: its stress. Pure shear: sqrt(3) of it. Pressure: none."""
    stress = np.array([[-5.0, 0, 0, 0, 0, 0], [0, 0, 0, 2, 0, 0], [0, 0, 0, 0, 0, -2], [7, 7, 7, 0, 0, 0]])
    np.testing.assert_allclose(von_mises(stress), [5, 2 * 3**0.5, 2 * 3**0.5, 0], atol=1e-14)


def test_von_mises_does_not_depend_on_the_axes(rng):
    s = rng.normal(size=6)
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    S = Q @ tensor(s) @ Q.T
    turned = np.array([S[0, 0], S[1, 1], S[2, 2], S[1, 2], S[0, 2], S[0, 1]])
    assert von_mises(turned) == pytest.approx(von_mises(s), rel=1e-13)


@pytest.mark.parametrize("cell_type", SOLIDS, ids=lambda kind: kind.name)
def test_finite_uniform_strain_of_a_solid(cell_type, material, distorted, rng):
    """S = C : E at every point and node, with the Green-Lagrange strain E."""
    model = solid_model(distorted(block(1.0, 0.9, 0.8, 2, 1, 1, cell_type), 0.05), material)
    H = 0.1 * rng.normal(size=(3, 3))
    E = 0.5 * (H + H.T + H.T @ H)
    lame = material.elasticity[0, 1]
    S = 2 * material.shear_modulus * E + lame * np.trace(E) * np.eye(3)
    recovery = stress_recovery(model)
    u = (model.mesh.nodes @ H.T).ravel()
    (points,) = recovery.at_points(u)
    atol = 1e-11 * np.abs(S).max()
    np.testing.assert_allclose(tensor(points), np.broadcast_to(S, (*points.shape[:2], 3, 3)), atol=atol)
    nodes = recovery.at_nodes(u)
    assert nodes.shape == (model.mesh.n_nodes, 1, 6)
    np.testing.assert_allclose(tensor(nodes[:, 0]), np.broadcast_to(S, (len(nodes), 3, 3)), atol=atol)


def test_recovered_strain_is_the_green_lagrange_strain(material, rng):
    model = solid_model(block(1.0, 0.9, 0.8, 2, 1, 1, CellType.TETRA10), material)
    H = 0.1 * rng.normal(size=(3, 3))
    E = 0.5 * (H + H.T + H.T @ H)
    nodes = strain_recovery(model).at_nodes((model.mesh.nodes @ H.T).ravel())
    halved = nodes[:, 0] * [1, 1, 1, 0.5, 0.5, 0.5]
    np.testing.assert_allclose(tensor(halved), np.broadcast_to(E, (len(nodes), 3, 3)), atol=1e-14)


def test_strain_of_a_wall_whose_material_states_another_shear_modulus(rng):
    """The strain of the field in any axes of the elements; sigma_zz = 0 gives that of the thickness."""
    soft = Isotropic(2.0, 0.3, 1.0, stated_shear_modulus=0.5)
    model = shell_model(plate(1.3, 1.0, 3, 2), HomogeneousSection(soft, 0.04))
    H = 1e-8 * rng.normal(size=(2, 2))
    q = np.zeros((model.mesh.n_nodes, 6))
    q[:, :2], q[:, 5] = model.mesh.nodes[:, :2] @ H.T, 0.5 * (H[1, 0] - H[0, 1])
    expected = [H[0, 0], H[1, 1], -0.3 / 0.7 * np.trace(H), 0.0, 0.0, H[0, 1] + H[1, 0]]
    found = strain_recovery(model).at_nodes(q.ravel())
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-6 * np.abs(H).max())


def test_strain_of_an_oblique_rod_whose_material_states_another_shear_modulus():
    """e along it and -nu e across it."""
    along, e = np.array([0.6, 0.8, 0.0]), 1e-8
    mesh = Mesh(np.array([np.zeros(3), along]), {CellType.LINE2: np.array([[0, 1]])})
    soft = Isotropic(2.0, 0.3, 1.0, stated_shear_modulus=0.5)
    recovery = strain_recovery(shell_model(mesh, RodSection(soft, area=0.01)))
    q = np.zeros((2, 6))
    q[1, :3] = e * along
    points = recovery.at_nodes(q.ravel()) * [1, 1, 1, 0.5, 0.5, 0.5]
    expected = e * (1.3 * np.outer(along, along) - 0.3 * np.eye(3))
    np.testing.assert_allclose(tensor(points), np.broadcast_to(expected, (2, 1, 3, 3)), atol=1e-6 * e)


def test_von_mises_strain_is_von_mises_stress_over_three_shear_moduli(material, rng):
    strain = rng.normal(size=(7, 6))
    stress = strain @ material.elasticity
    expected = von_mises(stress) / (3 * material.shear_modulus)
    np.testing.assert_allclose(von_mises_strain(strain), expected, rtol=1e-12)


@pytest.mark.parametrize("cell_type", [CellType.TETRA10, CellType.HEXA20], ids=lambda kind: kind.name)
def test_bending_stress_of_a_solid_is_exact_at_nodes(cell_type, material):
    """sigma_xx = -E k z for the small rotation-free part; the quadratic strain is of order k^2."""
    mesh = block(2.0, 0.4, 0.5, 2, 1, 1, cell_type)
    k, nu, E = 1e-9, material.poissons_ratio, material.youngs_modulus
    x, y, z = mesh.nodes.T
    u = k * np.column_stack([-x * z, nu * y * z, 0.5 * (x**2 + nu * (z**2 - y**2))])
    stress = stress_recovery(solid_model(mesh, material)).at_nodes(u.ravel())[:, 0]
    np.testing.assert_allclose(stress[:, 0], -E * k * z, atol=1e-7 * E * k)
    np.testing.assert_allclose(stress[:, 1:], 0, atol=1e-7 * E * k)


def test_stretch_and_bending_of_a_shell_in_any_attitude(material, rng):
    """sigma = C (eps + z kappa) at bottom, middle, top; turning the plate turns the tensor."""
    flat = plate(1.3, 1.0, 3, 2)
    t, scale = 0.04, 1e-8
    H, C = scale * rng.normal(size=(2, 2)), scale * rng.normal(size=(2, 2))
    C = C + C.T
    x = flat.nodes[:, :2]
    q = np.zeros((flat.n_nodes, 6))
    q[:, :2], q[:, 2] = x @ H.T, 0.5 * np.einsum("ai,ij,aj->a", x, C, x)
    q[:, 3], q[:, 4], q[:, 5] = (x @ C)[:, 1], -(x @ C)[:, 0], 0.5 * (H[1, 0] - H[0, 1])
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    Q = Q * np.linalg.det(Q)
    model = shell_model(Mesh(flat.nodes @ Q.T, flat.cells), HomogeneousSection(material, t))
    u = (q.reshape(-1, 3) @ Q.T).ravel()

    recovery = stress_recovery(model)
    (points,) = recovery.at_points(u)
    nodes = recovery.at_nodes(u)
    assert points.shape == (12, 3, 6)
    assert nodes.shape == (flat.n_nodes, 3, 6)
    for layer, z in enumerate([-t / 2, 0, t / 2]):
        eps = H - z * C
        s = material.plane_stress @ [eps[0, 0], eps[1, 1], eps[0, 1] + eps[1, 0]]
        S = Q[:, :2] @ np.array([[s[0], s[2]], [s[2], s[1]]]) @ Q[:, :2].T
        for found in (points[:, layer], nodes[:, layer]):
            expected = np.broadcast_to(S, (len(found), 3, 3))
            np.testing.assert_allclose(tensor(found), expected, atol=1e-6 * np.abs(S).max())


def reversed_triangles(mesh, which):
    triangles = mesh.cells[CellType.TRIANGLE3].copy()
    triangles[which] = triangles[which][:, [0, 2, 1]]
    return Mesh(mesh.nodes, {CellType.TRIANGLE3: triangles})


@pytest.mark.parametrize("which", [slice(5, None, 3), slice(None, 18), slice(1, None, 2)])
def test_stress_at_nodes_of_a_bent_plate_whose_normals_point_to_both_sides(which, material):
    """-E z k / (1 - nu^2) on the side to which most normals point, else the normal of the first triangle."""
    flat = plate(1.3, 1.0, 5, 3)
    t, k = 0.04, 1e-8
    q = np.zeros((flat.n_nodes, 6))
    q[:, 2], q[:, 4] = 0.5 * k * flat.nodes[:, 0] ** 2, -k * flat.nodes[:, 0]
    up = 30 - len(range(30)[which])
    side = 1 if up > 15 or (up == 15 and 0 not in range(30)[which]) else -1
    stretch = material.plane_stress[0, 0]
    for recovery, factor in ((stress_recovery, stretch), (strain_recovery, 1.0)):
        recovered = recovery(shell_model(reversed_triangles(flat, which), HomogeneousSection(material, t)))
        found = recovered.at_nodes(q.ravel())[:, :, 0]
        expected = side * factor * k * t / 2 * np.array([1.0, 0.0, -1.0])
        np.testing.assert_allclose(found, np.tile(expected, (len(found), 1)), atol=1e-6 * factor * k * t)


def test_plates_at_a_right_angle_keep_the_sides_of_their_own_normals():
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]])
    floor, wall = [[0, 1, 2], [0, 2, 3]], [[0, 3, 5], [0, 5, 4]]
    for turned in (wall, np.array(wall)[:, ::-1]):
        assert not turned_over(nodes, np.concatenate([floor, turned])).any()
    assert turned_over(nodes, np.array([*floor, [0, 3, 5], [0, 4, 5]])).sum() == 1


def test_the_stress_of_one_of_two_walls_that_meet_is_that_of_its_cell_set():
    """A skin is stretched by 0.1 % along x, and a rib across it is not: E / 1000 and 0."""
    nodes = np.array([[x, y, 0.0] for x in (0, 1, 2) for y in (0, 1)] + [[1, 0, -1], [1, 1, -1]], dtype=float)
    skin = [[0, 2, 1], [2, 3, 1], [2, 4, 3], [4, 5, 3]]
    walls = Mesh(
        nodes,
        {CellType.TRIANGLE3: np.array([*skin, [2, 3, 6], [3, 7, 6]])},
        cell_sets={"skin": {CellType.TRIANGLE3: range(4)}, "rib": {CellType.TRIANGLE3: [4, 5]}},
    )
    model = shell_model(walls, HomogeneousSection(Isotropic(7e10, 0.0, 2700.0), 0.01))
    displacement = np.zeros((8, 6))
    displacement[:, 0] = 1e-3 * nodes[:, 0]
    own = stress_recovery(model_of_cells(model, "skin")).at_nodes(displacement.ravel())
    assert own[[0, 2, 3], 1, 0] == pytest.approx(7e7, rel=1e-3)
    rib = stress_recovery(model_of_cells(model, "rib")).at_nodes(displacement.ravel())
    assert rib[2, 1, 0] == pytest.approx(0.0, abs=1e3)
    assert node_of_several_walls(model, np.array([0, 3, 7])) == 3
    assert node_of_several_walls(model, np.array([0, 7])) is None
    with pytest.raises(MeshError, match="no cell set 'spar'"):
        model_of_cells(model, "spar")


def test_a_laminate_has_no_stress_of_its_own():
    wall = LaminateSection(np.eye(3), np.zeros((3, 3)), np.eye(3), 1.0, 1.0)
    with pytest.raises(ModelError, match="stress needs a HomogeneousSection"):
        stress_recovery(shell_model(plate(1.0, 1.0, 1, 1), wall))


def test_a_laminate_on_a_solid_is_left_out_and_the_solid_keeps_its_stress(material):
    """A membrane on a block, as PSHELL with MID1 alone: one corner of it belongs to no solid."""
    solid = block(2.0, 0.4, 0.5, 2, 1, 1, CellType.HEXA20)
    edge = np.flatnonzero((solid.nodes[:, 2] == 0.25) & (solid.nodes[:, 0] == 0.0))
    nodes = np.vstack([solid.nodes, [[-1.0, 0.0, 0.25]]])
    flange = [edge[0], edge[-1], solid.n_nodes]
    mesh = Mesh(nodes, {**solid.cells, CellType.TRIANGLE3: np.array([flange])})
    skin = LaminateSection(1e5 * np.eye(3), np.zeros((3, 3)), np.zeros((3, 3)), 0.0, 0.0)
    sections = (
        Section(CellType.HEXA20, np.arange(2), material),
        Section(CellType.TRIANGLE3, np.array([0]), skin),
    )
    model = finite_element_model(mesh, sections)
    assert has_stress(model)
    assert cells_without_stress(model) == 1
    assert has_stress_on_faces(model).tolist() == [True] * solid.n_nodes + [False]
    k, E = 1e-9, material.youngs_modulus
    u = np.zeros((mesh.n_nodes, model.dofs_per_node))
    u[:, 0] = k * nodes[:, 0]
    u[:, 1:3] = -k * material.poissons_ratio * nodes[:, 1:]
    recovery = stress_recovery(model)
    stress = recovery.at_nodes(u.ravel())[: solid.n_nodes, 0]
    np.testing.assert_allclose(stress, np.tile([E * k, 0, 0, 0, 0, 0], (solid.n_nodes, 1)), atol=1e-6 * E * k)
    with pytest.raises(ModelError, match=rf"node {solid.n_nodes} .* belongs to no element with stress"):
        recovery.around(np.array([solid.n_nodes]))
