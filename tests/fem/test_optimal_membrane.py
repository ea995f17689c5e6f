"""Optimal membrane triangle: Felippa (2003) section 6 and the definitions it starts from."""

import numpy as np
import pytest

from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.fem.optimal_membrane import (
    drilling_stiffness,
    drilling_strain,
    higher_order_weight,
    linear_gradients,
    triangle_area,
)
from supple.mesh import CellType, Mesh, plate

TRIANGLE = np.array([[[0.1, -0.2], [2.0, 0.3], [0.7, 1.4]]])


def in_axes_turned_by(E, angle):
    c, s = np.cos(angle), np.sin(angle)
    T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    return T.T @ E @ T


def test_linear_fields_with_their_own_rotation_are_exact(material, rng):
    """Patch test of one element: u = H x, drilling (v,x - u,y)/2, has the energy of sym(H) and no other."""
    H = rng.normal(size=(2, 2))
    mesh = Mesh(np.column_stack([TRIANGLE[0], np.zeros(3)]), {CellType.TRIANGLE3: np.array([[0, 1, 2]])})
    wall = HomogeneousSection(material, 0.1)
    q = np.zeros((3, 6))
    q[:, :2], q[:, 5] = TRIANGLE[0] @ H.T, (H[1, 0] - H[0, 1]) / 2
    eps = np.array([H[0, 0], H[1, 1], H[0, 1] + H[1, 0]])
    expected = 0.5 * eps @ wall.membrane @ eps * triangle_area(TRIANGLE)[0]
    assert 0.5 * q.ravel() @ shell_model(mesh, wall).stiffness @ q.ravel() == pytest.approx(
        expected, rel=1e-12
    )


def test_uniform_drilling_does_not_strain_the_middle():
    """The constant strain ignores a common rotation of the nodes: what a finite rigid rotation needs."""
    np.testing.assert_allclose(drilling_strain(TRIANGLE)[0].sum(axis=1), 0, atol=1e-14)


def test_linear_gradients_and_area():
    """grad(x) = 1, and the gradients of a partition of unity cancel."""
    gradients = linear_gradients(TRIANGLE)[0]
    np.testing.assert_allclose(TRIANGLE[0].T @ gradients, np.eye(2), atol=1e-14)
    np.testing.assert_allclose(gradients.sum(axis=0), 0, atol=1e-14)
    assert triangle_area(TRIANGLE)[0] == pytest.approx(0.5 * (1.9 * 1.6 - 0.5 * 0.6))


def test_drilling_stiffness_has_rank_three(material):
    """Three deviations of the corner rotations; with the basic rank of three, six of nine freedoms."""
    values = np.linalg.eigvalsh(drilling_stiffness(TRIANGLE, material.plane_stress)[0])
    assert values[0] > 1e-3 * values[-1]


def test_drilling_stiffness_does_not_depend_on_the_first_corner(material):
    """Turning the corner numbers turns the rotations with them."""
    K = drilling_stiffness(TRIANGLE, material.plane_stress)[0]
    order = [1, 2, 0]
    turned = drilling_stiffness(TRIANGLE[:, order], material.plane_stress)[0]
    np.testing.assert_allclose(turned, K[np.ix_(order, order)], rtol=1e-10)


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.45, -0.3])
def test_weight_of_an_isotropic_material(nu):
    """beta_0 = (1 - 4 nu^2)/2."""
    E = Isotropic(3.0, nu, 1.0).plane_stress
    assert higher_order_weight(E) == pytest.approx(max(0.5 * (1 - 4 * nu**2), 0.01), rel=1e-12)


def test_weight_is_the_same_in_all_axes():
    E = np.array([[10.0, 0.8, 0.1], [0.8, 6.0, -0.2], [0.1, -0.2, 2.5]])
    weights = [higher_order_weight(in_axes_turned_by(E, angle)) for angle in (0.0, 0.4, 1.3)]
    assert weights[0] > 0.02
    np.testing.assert_allclose(weights, weights[0], rtol=1e-12)


@pytest.mark.parametrize("aspect", [1.0, 4.0, 16.0, 64.0])
def test_pure_bending_of_a_rectangle_is_exact_at_any_aspect_ratio(aspect):
    """Felippa (2003) section 6.2: the energy ratio of a two-triangle rectangle in pure bending is one.

    u = k x y, v = -k x^2/2, so U = E t h^3/12 k^2 L / 2.
    """
    E, t = 3.0, 0.01
    mesh = plate(aspect, 1.0, 1, 1)
    model = shell_model(mesh, HomogeneousSection(Isotropic(E, 0.3, 1.0), t))
    x, y, _ = (mesh.nodes - mesh.nodes.mean(axis=0)).T
    q = np.zeros((4, 6))
    q[:, 0], q[:, 1], q[:, 5] = x * y, -(x**2) / 2, -x
    energy = 0.5 * q.ravel() @ model.stiffness @ q.ravel()
    assert energy == pytest.approx(0.5 * E * t / 12 * aspect, rel=1e-9)


def cooks_tip(n, held, solve_linear):
    """Vertical displacement of the middle of the free edge of Cook's membrane."""
    grid = plate(1.0, 1.0, n, n)
    s, t, _ = grid.nodes.T
    nodes = np.column_stack([48 * s, 44 * s + t * (44 - 28 * s), 0 * s])
    mesh = Mesh(nodes, {CellType.TRIANGLE3: grid.cells[CellType.TRIANGLE3]}, grid.node_sets)
    model = shell_model(mesh, HomogeneousSection(Isotropic(1.0, 1 / 3, 1.0), 1.0))
    T = held(model, (mesh.nodes_of("x_min"), range(6)), (np.arange(mesh.n_nodes), [2, 3, 4]))
    load = np.zeros((mesh.n_nodes, 6))
    edge = mesh.nodes_of("x_max")
    load[edge, 1] = 1 / n
    load[edge[[0, -1]], 1] = 0.5 / n
    middle = edge[np.argmin(np.abs(nodes[edge, 1] - 52))]
    return solve_linear(model, T, load)[middle, 1]


def test_cooks_membrane_converges(held, solve_linear):
    """To 23.964 (refined meshes; Felippa 2003 has 23.96), at order 1.4: its upper root corner is singular."""
    tips = np.array([cooks_tip(n, held, solve_linear) for n in (4, 8, 16, 32)])
    errors = 1 - tips / 23.9642
    assert errors[-1] < 6e-3
    np.testing.assert_array_less(1.3, np.log2(errors[:-1] / errors[1:]))
    first, second = np.diff(tips[1:])
    assert tips[-1] + second**2 / (first - second) == pytest.approx(23.9642, rel=5e-4)
