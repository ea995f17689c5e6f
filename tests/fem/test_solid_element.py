"""Solid elements: patch test, rigid motions, exact bending of quadratic cells, convergence to beam theory."""

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import MeshError
from supple.fem import Isotropic, assemble, solid_model
from supple.fem.model import SOLID_ELEMENTS
from supple.fem.quadrature import conical_tetrahedron, gauss_cube
from supple.fem.solid_element import extrapolation, solid_mass, solid_strain
from supple.mesh import CellType, Mesh, block, to_quadratic
from supple.mesh.reference_cell import reference_nodes

LINEAR = (CellType.TETRA4, CellType.HEXA8)
QUADRATIC = (CellType.TETRA10, CellType.HEXA20)
every_solid = pytest.mark.parametrize("cell_type", LINEAR + QUADRATIC, ids=lambda kind: kind.name)


@every_solid
def test_six_zero_modes_and_no_more(cell_type, material, distorted, rigid_modes):
    """Also of a single cell, where too few integration points would show."""
    for cells in ((1, 1, 1), (2, 1, 1)):
        model = solid_model(distorted(block(1.0, 0.9, 0.8, *cells, cell_type), 0.06), material)
        K, R = model.stiffness.toarray(), rigid_modes(model)
        assert np.abs(K @ R).max() < 1e-12 * np.abs(K).max()
        values = np.linalg.eigvalsh(K)
        assert values[5] < 1e-13 * values[-1]
        assert values[6] > 1e-4 * values[-1]


@pytest.mark.parametrize("cell_type", QUADRATIC, ids=lambda kind: kind.name)
def test_single_quadratic_element_has_full_rank(cell_type, material):
    nodes = block(1.0, 1.0, 1.0, 1, 1, 1, cell_type)
    cell = nodes.cells[cell_type][0]
    mesh = Mesh(nodes.nodes[cell], {cell_type: np.arange(len(cell))[None]})
    values = np.linalg.eigvalsh(solid_model(mesh, material).stiffness.toarray())
    assert values[5] < 1e-13 * values[-1]
    assert values[6] > 1e-4 * values[-1]


@every_solid
def test_patch_of_constant_finite_strain(cell_type, material, distorted, rng):
    """u = H x on irregular straight cells: energy V E:C:E/2, E = (F^T F - 1)/2; inner nodes are free."""
    linear = CellType.TETRA4 if cell_type.n_corners == 4 else CellType.HEXA8
    regular = block(1.0, 1.0, 1.0, 2, 2, 2, linear)
    mesh = distorted(regular, 0.05)
    if cell_type is not linear:
        regular, mesh = to_quadratic(regular), to_quadratic(mesh)
    assembly = assemble(solid_model(mesh, material))
    H = 0.1 * rng.normal(size=(3, 3))
    q = (mesh.nodes @ H.T).ravel()
    F = np.eye(3) + H
    E = 0.5 * (F.T @ F - np.eye(3))
    voigt = np.array([E[0, 0], E[1, 1], E[2, 2], 2 * E[1, 2], 2 * E[0, 2], 2 * E[0, 1]])
    volume = assembly.blocks[0].w.sum()
    assert assembly.energy(q) == pytest.approx(0.5 * volume * voigt @ material.elasticity @ voigt, rel=1e-12)
    on_surface = (np.abs(regular.nodes - [0.5, 0, 0]) > 0.5 - 1e-9).any(axis=1)
    force = assembly.internal_force(q).reshape(-1, 3)
    assert (~on_surface).any()
    assert np.abs(force[~on_surface]).max() < 1e-12 * np.abs(force).max()


@every_solid
def test_a_rigid_rotation_by_any_angle_stores_no_energy(cell_type, material, distorted):
    mesh = distorted(block(1.0, 0.9, 0.8, 1, 1, 1, cell_type), 0.06)
    assembly = assemble(solid_model(mesh, material))
    R, _ = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))
    R = R * np.linalg.det(R)
    q = (mesh.nodes @ (R - np.eye(3)).T).ravel()
    assert assembly.energy(q) < 1e-25 * assembly.energy(1.1 * q) + 1e-14
    assert np.abs(assembly.internal_force(q)).max() < 1e-13 * np.abs(assembly.internal_force(1.1 * q)).max()


@pytest.mark.parametrize("cell_type", QUADRATIC, ids=lambda kind: kind.name)
def test_pure_bending_is_exact_on_quadratic_cells(cell_type):
    """u = -k x z, v = k nu y z, w = k (x^2 + nu (z^2 - y^2))/2 is quadratic: energy E I k^2 L/2 exactly."""
    E, nu = 3.0, 0.3
    mesh = block(2.0, 0.4, 0.5, 2, 1, 1, cell_type)
    model = solid_model(mesh, Isotropic(E, nu, 1.0))
    x, y, z = mesh.nodes.T
    q = np.column_stack([-x * z, nu * y * z, 0.5 * (x**2 + nu * (z**2 - y**2))]).ravel()
    assert 0.5 * q @ model.stiffness @ q == pytest.approx(0.5 * E * 0.4 * 0.5**3 / 12 * 2.0, rel=1e-12)


def cantilever_tip(cell_type, cells, held, solve_linear):
    """Tip deflection over Timoshenko's, F L^3/(3 E I) + 6/5 F L/(G A), for nu = 0."""
    L, b, h, E, F = 5.0, 0.5, 1.0, 1e6, 1.0
    mesh = block(L, b, h, *cells, cell_type)
    model = solid_model(mesh, Isotropic(E, 0.0, 1.0))
    T = held(model, (mesh.nodes_of("root"), range(3)))
    load = np.zeros((mesh.n_nodes, 3))
    tip = mesh.nodes_of("tip")
    load[tip, 2] = F / len(tip)
    exact = F * L**3 / (3 * E * b * h**3 / 12) + 1.2 * F * L / (E / 2 * b * h)
    return (load * solve_linear(model, T, load)).sum() / F / exact


@pytest.mark.parametrize(
    ("cell_type", "cells"), [(CellType.TETRA10, (10, 1, 3)), (CellType.HEXA20, (8, 1, 2))], ids=["t10", "h20"]
)
def test_quadratic_cantilever_follows_timoshenko(cell_type, cells, held, solve_linear):
    assert cantilever_tip(cell_type, cells, held, solve_linear) == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("cell_type", LINEAR, ids=lambda kind: kind.name)
def test_linear_cantilever_converges_at_second_order(cell_type, held, solve_linear):
    """From below: fully integrated linear cells are too stiff in bending."""
    coarse, fine = (1 - cantilever_tip(cell_type, (8 * k, k, 2 * k), held, solve_linear) for k in (2, 4))
    assert fine > 0
    assert np.log2(coarse / fine) > 1.7


def test_a_cell_that_turns_over_is_refused(material):
    """Curved sides can fold a cell whose corners are in order; here it is turned inside out."""
    mesh = block(1.0, 1.0, 1.0, 1, 1, 1, CellType.HEXA20)
    mirrored = mesh.nodes[mesh.cells[CellType.HEXA20]] * [1, 1, -1]
    with pytest.raises(MeshError, match=r"HEXA20 cell 0, centred at .* turns over at an integration point"):
        solid_strain(SOLID_ELEMENTS[CellType.HEXA20], mirrored, np.arange(60)[None], material)


@every_solid
def test_mass_rule_is_exact_for_curved_cells(cell_type, distorted):
    """More points change neither mass nor inertia: sums of x_a m_ab x_b over nodes."""
    mesh = distorted(block(1.0, 0.9, 0.8, 1, 1, 1, cell_type), 0.1)
    corners = mesh.nodes[mesh.cells[cell_type]]
    element = SOLID_ELEMENTS[cell_type]
    finer = conical_tetrahedron(7) if cell_type.n_corners == 4 else gauss_cube(7)

    def inertia(mass):
        return np.einsum("eai,eab,ebj->ij", corners, mass, corners), mass.sum()

    stated = inertia(solid_mass(element, corners, 2.0))
    exact = inertia(solid_mass(replace(element, mass_rule=finer), corners, 2.0))
    np.testing.assert_allclose(stated[0], exact[0], rtol=1e-12)
    assert stated[1] == pytest.approx(exact[1], rel=1e-13)


@every_solid
def test_extrapolation_to_nodes_is_exact_for_linear_fields(cell_type):
    """Or constant ones from a single point."""
    element = SOLID_ELEMENTS[cell_type]
    slope = np.array([1.0, -2.0, 0.5]) if len(element.strain_rule.points) > 1 else np.zeros(3)
    at_nodes = extrapolation(element) @ (element.strain_rule.points @ slope + 3)
    np.testing.assert_allclose(at_nodes, reference_nodes(cell_type) @ slope + 3, rtol=1e-12, atol=1e-12)
