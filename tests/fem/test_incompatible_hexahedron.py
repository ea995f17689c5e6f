"""Eight-node hexahedra with incompatible motions: patch test, rigid rotation, bending without locking."""

import numpy as np
import pytest
from fixtures.solid_blocks import solid_block
from scipy.spatial.transform import Rotation

from supple.fem import Isotropic, Section, assemble, finite_element_model
from supple.fem.strain_operator import strain_operator
from supple.mesh import CellType


def bending_model(mesh, material):
    cells = np.arange(len(mesh.cells[CellType.HEXA8]))
    return finite_element_model(mesh, (Section(CellType.HEXA8, cells, material, incompatible=True),))


def test_six_zero_modes_and_no_more(material, distorted, rigid_modes):
    model = bending_model(distorted(solid_block(1.0, 0.9, 0.8, 1, 1, 1, CellType.HEXA8), 0.06), material)
    K, R = model.stiffness.toarray(), rigid_modes(model)
    assert np.abs(K @ R).max() < 1e-12 * np.abs(K).max()
    values = np.linalg.eigvalsh(K)
    assert values[5] < 1e-13 * values[-1]
    assert values[6] > 1e-4 * values[-1]


def test_patch_of_constant_finite_strain(material, distorted, rng):
    """u = H x on irregular cells: energy V E:C:E/2, E = (F^T F - 1)/2, and no force on the inner node."""
    regular = solid_block(1.0, 1.0, 1.0, 2, 2, 2, CellType.HEXA8)
    mesh = distorted(regular, 0.05)
    assembly = assemble(bending_model(mesh, material))
    H = 0.1 * rng.normal(size=(3, 3))
    q = (mesh.nodes @ H.T).ravel()
    E = 0.5 * (H + H.T + H.T @ H)
    voigt = np.array([E[0, 0], E[1, 1], E[2, 2], 2 * E[1, 2], 2 * E[0, 2], 2 * E[0, 1]])
    volume = assembly.blocks[0].w.sum()
    assert assembly.energy(q) == pytest.approx(0.5 * volume * voigt @ material.elasticity @ voigt, rel=1e-12)
    inside = (np.abs(regular.nodes - [0.5, 0, 0]) < 0.5 - 1e-9).all(axis=1)
    assert inside.sum() == 1
    force = assembly.internal_force(q).reshape(-1, 3)
    assert np.abs(force[inside]).max() < 1e-12 * np.abs(force).max()


def test_a_rigid_rotation_by_any_angle_stores_no_energy(material, distorted):
    mesh = distorted(solid_block(1.0, 0.9, 0.8, 1, 1, 1, CellType.HEXA8), 0.06)
    assembly = assemble(bending_model(mesh, material))
    R, _ = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))
    R = R * np.linalg.det(R)
    q = (mesh.nodes @ (R - np.eye(3)).T).ravel()
    assert assembly.energy(q) < 1e-25 * assembly.energy(1.1 * q) + 1e-14
    assert np.abs(assembly.internal_force(q)).max() < 1e-13 * np.abs(assembly.internal_force(1.1 * q)).max()


def test_a_rotation_of_the_deformed_cell_changes_no_energy(material, distorted, rng):
    """U(R (X + u) - X) = U(u) at strains of about 0.2, and the forces turn with it."""
    mesh = distorted(solid_block(1.0, 0.9, 0.8, 1, 1, 1, CellType.HEXA8), 0.06)
    assembly = assemble(bending_model(mesh, material))
    R = Rotation.from_rotvec([1.0, -0.7, 2.0]).as_matrix()
    places = mesh.nodes + 0.1 * rng.normal(size=mesh.nodes.shape)
    moved, turned = (places - mesh.nodes).ravel(), (places @ R.T - mesh.nodes).ravel()
    assert assembly.energy(turned) == pytest.approx(assembly.energy(moved), rel=1e-12)
    rotated = assembly.internal_force(moved).reshape(-1, 3) @ R.T
    assert np.allclose(
        assembly.internal_force(turned).reshape(-1, 3), rotated, rtol=0, atol=1e-12 * np.abs(rotated).max()
    )


def test_force_tangent_and_their_derivatives_are_those_of_the_energy(material, distorted, rng):
    """Each against complex differences of the one before; the polynomial terms sum to the force."""
    mesh = distorted(solid_block(1.0, 0.9, 0.8, 2, 1, 1, CellType.HEXA8), 0.06)
    assembly = assemble(bending_model(mesh, material))
    q, x, rates = 0.1 * rng.normal(size=(3, 3 * mesh.n_nodes))
    step = 1e-30j
    force = assembly.internal_force(q)
    scale = np.abs(force).max()

    def derivative(function, at):
        return function(at + step * x).imag / step.imag

    assert derivative(assembly.energy, q) == pytest.approx(force @ x, rel=1e-12)
    assert np.abs(derivative(assembly.internal_force, q) - assembly.tangent(q) @ x).max() < 1e-12 * scale
    moved = derivative(lambda at: assembly.tangent(at) @ rates, np.zeros_like(q))
    assert np.abs(moved - assembly.tangent_derivative(x) @ rates).max() < 1e-12 * scale
    damped = derivative(lambda at: assembly.strain_rate_force(at, rates), q)
    assert np.abs(damped - assembly.strain_rate_tangent(q, rates) @ x).max() < 1e-12 * scale
    operator = strain_operator(assembly)
    assert np.abs(operator.force(q, rates, 0.0) - force).max() < 1e-12 * scale
    both = force + 0.3 * assembly.strain_rate_force(q, rates)
    assert np.abs(operator.force(q, rates, 0.3) - both).max() < 1e-12 * np.abs(both).max()
    pairs = assembly.pair_forces(x[:, None])[:, 0]
    assert np.abs(pairs - assembly.tangent_derivative(x) @ x).max() < 1e-12 * np.abs(pairs).max()
    works = assembly.works(q[:, None], x[:, None])
    powers = works.linear[0, 0] * 0.5 + works.turned[0, 0, 0] + 0.5 * works.cubic[0, 0, 0]
    assert force @ x == pytest.approx(x @ assembly.tangent(0 * q) @ q + powers, rel=1e-12)


def test_pure_bending_is_exact_on_one_row_of_boxes():
    """Nodes of boxes of 10 : 1 that lie on a curvature k store E I k^2 L / 2."""
    E, nu, k, L, b, h = 3.0, 0.3, 0.1, 10.0, 1.0, 0.5
    mesh = solid_block(L, b, h, 2, 1, 1, CellType.HEXA8)
    x, y, z = mesh.nodes.T
    u = np.column_stack([-k * x * z, k * nu * y * z, 0.5 * k * (x**2 + nu * (z**2 - y**2))])
    K = bending_model(mesh, Isotropic(E, nu, 1.0)).stiffness
    assert u.ravel() @ K @ u.ravel() == pytest.approx(E * b * h**3 / 12 * k**2 * L, rel=1e-12)


def test_slender_cantilever_of_one_row(held, solve_linear):
    """Tip deflection F L^3 / (3 E I) of 200 : 1 with one row of elements, each 10 : 1, within 1 %."""
    L, b, h, E, F = 200.0, 1.0, 1.0, 1e6, 1e-3
    mesh = solid_block(L, b, h, 20, 1, 1, CellType.HEXA8)
    model = bending_model(mesh, Isotropic(E, 0.0, 1.0))
    T = held(model, (mesh.nodes_of("root"), range(3)))
    load = np.zeros((mesh.n_nodes, 3))
    load[mesh.nodes_of("tip"), 2] = F / 4
    tip = (load * solve_linear(model, T, load)).sum() / F
    assert tip == pytest.approx(F * L**3 / (3 * E * b * h**3 / 12), rel=0.01)
