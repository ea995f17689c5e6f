"""Solid elements: patch test, rigid motions, exact bending of quadratic cells, convergence to beam theory."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.solid_blocks import LINEAR, QUADRATIC, solid_block

from supple.errors import ModelError
from supple.fem import Anisotropic, Isotropic, assemble, finite_element_model, solid_model
from supple.fem.model import SOLID_ELEMENTS
from supple.fem.solid_element import extrapolation, solid_mass, turned_elasticity
from supple.fem.stress import strain_recovery, stress_recovery
from supple.mesh import CellType, Mesh, block, to_quadratic
from supple.mesh.quadrature import product_rule
from supple.mesh.reference_cell import reference_nodes

every_solid = pytest.mark.parametrize("cell_type", LINEAR + QUADRATIC, ids=lambda kind: kind.name)


@every_solid
def test_six_zero_modes_and_no_more(cell_type, material, distorted, rigid_modes):
    """Also of a single cell, where too few integration points would show."""
    for cells in ((1, 1, 1), (2, 1, 1)):
        model = solid_model(distorted(solid_block(1.0, 0.9, 0.8, *cells, cell_type), 0.06), material)
        K, R = model.stiffness.toarray(), rigid_modes(model)
        assert np.abs(K @ R).max() < 1e-12 * np.abs(K).max()
        values = np.linalg.eigvalsh(K)
        assert values[5] < 1e-13 * values[-1]
        assert values[6] > 1e-4 * values[-1]


@pytest.mark.parametrize("cell_type", QUADRATIC, ids=lambda kind: kind.name)
def test_single_quadratic_element_has_full_rank(cell_type, material):
    nodes = reference_nodes(cell_type)
    mesh = Mesh(nodes, {cell_type: np.arange(len(nodes))[None]})
    values = np.linalg.eigvalsh(solid_model(mesh, material).stiffness.toarray())
    assert values[5] < 1e-13 * values[-1]
    assert values[6] > 1e-4 * values[-1]


@every_solid
def test_patch_of_constant_finite_strain(cell_type, material, distorted, rng):
    """u = H x on irregular straight cells: energy V E:C:E/2, E = (F^T F - 1)/2; inner nodes are free."""
    linear = next(kind for kind in LINEAR if kind.n_corners == cell_type.n_corners)
    regular = solid_block(1.0, 1.0, 1.0, 2, 2, 2, linear)
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
    mesh = distorted(solid_block(1.0, 0.9, 0.8, 1, 1, 1, cell_type), 0.06)
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
    mesh = solid_block(2.0, 0.4, 0.5, 2, 1, 1, cell_type)
    model = solid_model(mesh, Isotropic(E, nu, 1.0))
    x, y, z = mesh.nodes.T
    q = np.column_stack([-x * z, nu * y * z, 0.5 * (x**2 + nu * (z**2 - y**2))]).ravel()
    assert 0.5 * q @ model.stiffness @ q == pytest.approx(0.5 * E * 0.4 * 0.5**3 / 12 * 2.0, rel=1e-12)


def cantilever_tip(cell_type, cells, held, solve_linear):
    """Tip deflection over Timoshenko's, F L^3/(3 E I) + 6/5 F L/(G A), for nu = 0."""
    L, b, h, E, F = 5.0, 0.5, 1.0, 1e6, 1.0
    mesh = solid_block(L, b, h, *cells, cell_type)
    model = solid_model(mesh, Isotropic(E, 0.0, 1.0))
    T = held(model, (mesh.nodes_of("root"), range(3)))
    load = np.zeros((mesh.n_nodes, 3))
    tip = mesh.nodes_of("tip")
    load[tip, 2] = F / len(tip)
    exact = F * L**3 / (3 * E * b * h**3 / 12) + 1.2 * F * L / (E / 2 * b * h)
    return (load * solve_linear(model, T, load)).sum() / F / exact


@pytest.mark.parametrize(
    ("cell_type", "cells"),
    [
        (CellType.TETRA10, (10, 1, 3)),
        (CellType.PYRAMID13, (8, 1, 2)),
        (CellType.WEDGE15, (8, 1, 2)),
        (CellType.HEXA20, (8, 1, 2)),
    ],
    ids=["t10", "p13", "w15", "h20"],
)
def test_quadratic_cantilever_follows_timoshenko(cell_type, cells, held, solve_linear):
    assert cantilever_tip(cell_type, cells, held, solve_linear) == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("cell_type", LINEAR, ids=lambda kind: kind.name)
def test_linear_cantilever_converges_at_second_order(cell_type, held, solve_linear):
    """From below: fully integrated linear cells are too stiff in bending."""
    coarse, fine = (1 - cantilever_tip(cell_type, (8 * k, k, 2 * k), held, solve_linear) for k in (2, 4))
    assert fine > 0
    assert np.log2(coarse / fine) > 1.7


@every_solid
def test_mass_rule_is_exact_for_curved_cells(cell_type, distorted):
    """More points change neither mass nor inertia: sums of x_a m_ab x_b over nodes."""
    mesh = distorted(solid_block(1.0, 0.9, 0.8, 1, 1, 1, cell_type), 0.1)
    corners = mesh.nodes[mesh.cells[cell_type]]
    element = SOLID_ELEMENTS[cell_type]
    finer = product_rule(cell_type, 8)

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


def test_pyramids_join_hexahedra_and_tetrahedra(material, rng):
    """Two hexahedra, of which one is split: constant strain has no force on the nodes of the cut."""
    bricks = block(2.0, 1.0, 1.0, 2, 1, 1, CellType.HEXA8)
    first, second = bricks.cells[CellType.HEXA8]
    nodes = np.vstack(
        [bricks.nodes + 0.05 * rng.normal(size=bricks.nodes.shape), bricks.nodes[second].mean(axis=0)]
    )
    middle = len(bricks.nodes)
    sides = [second[list(face[::-1])] for face in CellType.HEXA8.faces]
    pyramids = [[*side, middle] for side in sides[:5]]
    a, b, c, d = sides[5]
    tetrahedra = [[a, b, c, middle], [a, c, d, middle]]
    mesh = Mesh(
        nodes,
        {CellType.HEXA8: [first], CellType.PYRAMID5: pyramids, CellType.TETRA4: tetrahedra},
    )
    for each in (mesh, to_quadratic(mesh)):
        model = solid_model(each, material)
        H = rng.normal(size=(3, 3))
        force = (model.stiffness @ (each.nodes @ H.T).ravel()).reshape(-1, 3)
        inside = [middle]
        assert np.abs(force[inside]).max() < 1e-12 * np.abs(force).max()


def orthotropic():
    compliance = np.diag([1 / 40e9, 1 / 10e9, 1 / 8e9, 1 / 3e9, 1 / 4e9, 1 / 5e9])
    compliance[0, 1] = compliance[1, 0] = -0.3 / 40e9
    compliance[0, 2] = compliance[2, 0] = -0.25 / 40e9
    compliance[1, 2] = compliance[2, 1] = -0.35 / 10e9
    return Anisotropic(np.linalg.inv(compliance), 1600.0)


def axes_at_random(rng):
    R = np.linalg.qr(rng.normal(size=(3, 3))).Q
    return R * np.linalg.det(R)


def test_elasticity_turns_as_a_tensor_does(rng):
    """C_ijkl = R_ia R_jb R_kc R_ld C'_abcd, with R's columns the material's axes."""
    material, R = orthotropic(), axes_at_random(rng)
    pairs = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    place = np.zeros((3, 3), dtype=int)
    for row, (i, j) in enumerate(pairs):
        place[i, j] = place[j, i] = row
    tensor = material.elasticity[place[:, :, None, None], place]
    turned = np.einsum("ia,jb,kc,ld,abcd->ijkl", R, R, R, R, tensor)
    i, j = np.array(pairs).T
    found = turned_elasticity(material.elasticity, R[None])[0]
    np.testing.assert_allclose(found, turned[i[:, None], j[:, None], i, j], atol=1e-3)


def test_a_turned_body_with_turned_axes_is_the_same_body(rng):
    """Stiffness, stress and strain: u = R v in axes of material R, on a mesh turned by R."""
    mesh, R = solid_block(1.0, 0.5, 0.4, 2, 1, 1, CellType.WEDGE15), axes_at_random(rng)
    turned = Mesh(mesh.nodes @ R.T, mesh.cells)
    plain = solid_model(mesh, orthotropic())
    given = solid_model(turned, orthotropic())
    section = given.sections[0]
    axes = np.broadcast_to(R, (len(section.cells), 3, 3))
    given = finite_element_model(turned, (replace(section, directions=axes),))
    u = 1e-3 * rng.normal(size=mesh.nodes.shape)
    v = u @ R.T
    energies = [q.ravel() @ model.stiffness @ q.ravel() for model, q in ((given, v), (plain, u))]
    assert energies[0] == pytest.approx(energies[1], rel=1e-10)
    for recovery in (stress_recovery, strain_recovery):
        scale = [1, 1, 1, 0.5, 0.5, 0.5] if recovery is strain_recovery else np.ones(6)
        before, after = (recovery(m).at_nodes(q.ravel())[:, 0] * scale for m, q in ((plain, u), (given, v)))
        np.testing.assert_allclose(
            tensors(after), R @ tensors(before) @ R.T, atol=1e-9 * np.abs(before).max()
        )


def tensors(voigt):
    xx, yy, zz, yz, xz, xy = voigt.T
    return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)


def test_axes_that_are_not_square_are_refused():
    with pytest.raises(ModelError, match="material axes of 1 solid cells, first number 0"):
        turned_elasticity(np.eye(6), np.array([[[1.0, 0.1, 0], [0, 1, 0], [0, 0, 1]]]))
