"""Quadratic strain: force, tangent and higher derivatives against complex steps of the energy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.fem import (
    GREEN_LAGRANGE,
    VON_KARMAN,
    BeamSection,
    HomogeneousSection,
    LaminateSection,
    shell_model,
    solid_model,
)
from supple.fem.quadratic_strain import (
    energy,
    internal_force,
    pair_forces,
    stiffness,
    strain,
    strain_rate_force,
    strain_rate_tangent,
    tangent,
    tangent_derivative,
)
from supple.mesh import CellType, Mesh, block, box_beam

STEP = 1e-30


def coupled_wall(material):
    A, D = 0.02 * material.plane_stress, 0.02**3 / 12 * material.plane_stress
    return LaminateSection(A, 0.3 * np.sqrt(A * D), D, 156.0, 0.005, (0.3, 1.0, 0.2))


def shell(kinematics, coupled):
    def build(material, distorted):
        mesh = distorted(box_beam(1.0, 0.6, 0.4, 2, 1, 1), 0.05)
        wall = coupled_wall(material) if coupled else HomogeneousSection(material, 0.02)
        return shell_model(mesh, wall, kinematics=kinematics)

    return build


def solid(cell_type):
    return lambda material, distorted: solid_model(
        distorted(block(1, 0.8, 0.6, 2, 1, 1, cell_type), 0.05), material
    )


def beam(material, distorted):
    nodes = np.linspace(0, 1, 4)[:, None] * [1.0, 0.3, -0.2]
    mesh = distorted(Mesh(nodes, {CellType.LINE2: [[0, 1], [1, 2], [2, 3]]}), 0.05)
    return shell_model(mesh, BeamSection(material, 4e-4, 2e-8, 1e-8, 2.5e-8, 0.8, 0.7, (0.2, 1.0, 0.4)))


MODELS = {
    "beam": beam,
    "shell": shell(GREEN_LAGRANGE, False),
    "shell, von Karman": shell(VON_KARMAN, False),
    "shell, coupled laminate": shell(GREEN_LAGRANGE, True),
    "tetra4": solid(CellType.TETRA4),
    "tetra10": solid(CellType.TETRA10),
    "hexa8": solid(CellType.HEXA8),
    "hexa20": solid(CellType.HEXA20),
}


@pytest.fixture(params=MODELS)
def elements(request, material, distorted):
    return MODELS[request.param](material, distorted).blocks[0]


@pytest.fixture
def random(elements, rng):
    return lambda *more: 0.1 * rng.normal(size=(*elements.dofs.shape, *more))


def assert_close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_force_is_the_gradient_of_the_energy(elements, random):
    q, x = random(), random()
    assert_close(
        (internal_force(elements, q) * x).sum(axis=1), energy(elements, q + STEP * 1j * x).imag / STEP
    )


def test_energy_is_the_work_of_the_stress_on_the_strain(elements, random):
    """Half of it, point by point."""
    q = random()
    eps = strain(elements, q)
    D = np.broadcast_to(elements.D, (len(q), *elements.D.shape[-2:]))
    expected = 0.5 * np.einsum("eg,egs,est,egt->e", elements.w, eps, D, eps)
    assert_close(energy(elements, q), expected)


def test_tangent_is_the_gradient_of_the_force(elements, random):
    q, x = random(), random()
    K = tangent(elements, q)
    assert_close((K @ x[..., None])[..., 0], internal_force(elements, q + STEP * 1j * x).imag / STEP)
    assert_close(K, K.swapaxes(1, 2))


def test_strain_rate_force_is_the_power_of_the_stress_of_the_strain_rate(elements, random):
    """x . K_mat y is the work of D eps'(q) y on eps'(q) x, and K_mat the tangent without G^T sigma G."""
    q, x, y = random(), random(), random()
    rate_x, rate_y = (strain(elements, q + STEP * 1j * z).imag / STEP for z in (x, y))
    D = np.broadcast_to(elements.D, (len(q), *elements.D.shape[-2:]))
    expected = np.einsum("eg,egs,est,egt->e", elements.w, rate_x, D, rate_y)
    force = strain_rate_force(elements, q, y)
    assert_close((x * force).sum(axis=1), expected)
    material = tangent(elements, q, material=2.0) - tangent(elements, q)
    np.testing.assert_allclose(
        (material @ y[..., None])[..., 0], force, rtol=0, atol=1e-12 * np.abs(force).max()
    )


def test_strain_rate_tangent_is_the_gradient_of_the_strain_rate_force(elements, random):
    q, rates, x = random(), random(), random()
    K = strain_rate_tangent(elements, q, rates)
    exact = strain_rate_force(elements, q + STEP * 1j * x, rates).imag / STEP
    assert_close((K @ x[..., None])[..., 0], exact)


@pytest.mark.parametrize("cell_type", [CellType.TETRA10, CellType.HEXA8])
def test_a_turned_solid_that_turns_on_has_no_strain_rate(cell_type, material, distorted):
    """Turned by 1 rad, turning about another axis; the stiffness at rest resists as if it were stretched."""
    model = solid(cell_type)(material, distorted)
    (elements,) = model.blocks
    R = Rotation.from_rotvec([0.6, -0.64, 0.48]).as_matrix()
    place = model.mesh.nodes @ R.T
    q = (place - model.mesh.nodes).ravel()[elements.dofs]
    rates = np.cross([0.3, 1.0, -0.5], place).ravel()[elements.dofs]
    at_rest = strain_rate_force(elements, 0 * q, rates)
    assert np.abs(strain_rate_force(elements, q, rates)).max() < 1e-13 * np.abs(at_rest).max()


def test_stiffness_is_the_tangent_of_the_undeformed_element(elements, random):
    assert_close(stiffness(elements), tangent(elements, 0 * random()))


def test_tangent_derivative_is_that_of_the_tangent(elements, random):
    x = random()
    assert_close(tangent_derivative(elements, x), tangent(elements, STEP * 1j * x).imag / STEP)


def test_pair_forces_are_tangent_derivatives_times_directions(elements, random):
    X = random(3)
    pairs = pair_forces(elements, X)
    for column, (j, k) in enumerate(zip(*np.triu_indices(3), strict=True)):
        derivative = tangent_derivative(elements, X[..., j])
        assert_close(pairs[..., column], (derivative @ X[..., k, None])[..., 0])


def test_force_is_a_cubic_polynomial(elements, random):
    """Fourth differences of f(t q) over equal steps in t vanish."""
    q = random()
    forces = [internal_force(elements, t * q) for t in range(5)]
    fourth = forces[0] - 4 * forces[1] + 6 * forces[2] - 4 * forces[3] + forces[4]
    assert np.abs(fourth).max() < 1e-12 * np.abs(forces[4]).max()


def test_constitutive_matrix_may_differ_from_element_to_element(elements, random):
    """D of each element: the energy of element e scales with its own factor."""
    q = random()
    factor = np.linspace(1, 2, len(q))
    scaled = replace(elements, D=factor[:, None, None] * elements.D)
    if elements.enhanced is not None:  # their energy is 1
        enhanced = elements.enhanced / np.sqrt(factor)[:, None, None, None]
        scaled = replace(scaled, enhanced=enhanced)
    assert_close(energy(scaled, q), factor * energy(elements, q))
    assert_close(energy(scaled.of(slice(1, 2)), q[1:2]), (factor * energy(elements, q))[1:2])


def test_arrays_are_read_only(elements):
    with pytest.raises(ValueError, match="read-only"):
        elements.B[0] = 0
