"""Timoshenko beams: static closed forms in any direction, frequencies and their order, inertia, prestress."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import mesh_mass_properties, rigid_mass_properties
from supple.errors import MeshError, ModelError
from supple.fem import (
    BeamSection,
    HomogeneousSection,
    Isotropic,
    assemble,
    lumped_mass,
    shell_model,
    stress_recovery,
)
from supple.mesh import CellType, Mesh, skin_of, strip

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
LENGTH = 2.0
WIDTH, HEIGHT = 0.03, 0.05
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3))).Q
TURN *= np.linalg.det(TURN)


def section(**changes):
    """A rectangle, higher along y, in axes turned at random; its y axis is not square to the orientation."""
    values = {
        "area": WIDTH * HEIGHT,
        "I1": WIDTH * HEIGHT**3 / 12,
        "I2": HEIGHT * WIDTH**3 / 12,
        "J": 2e-7,
        "K1": 5 / 6,
        "K2": 5 / 6,
        "orientation": TURN @ [0.4, 1.0, 0.0],
    }
    return BeamSection(STEEL, **values | changes)


def beam(n, length=LENGTH):
    nodes = np.linspace(0, length, n + 1)[:, None] * TURN[:, 0]
    return Mesh(nodes, {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])})


def test_a_cantilever_deflects_as_the_formulas_say():
    """Exact at the tip with any number of elements: P L^3 / 3 E I + P L / (k G A), T L / G J, N L / E A."""
    of = section()
    model = shell_model(beam(3), of)
    K = model.stiffness.toarray()[6:, 6:]
    E, G = STEEL.youngs_modulus, STEEL.shear_modulus
    shear = LENGTH / (5 / 6 * G * of.area)
    bend = [LENGTH**3 / (3 * E * moment) + shear for moment in (of.I1, of.I2)]
    expected = [
        LENGTH / (E * of.area),
        *bend,
        LENGTH / (G * of.J),
        LENGTH / (E * of.I2),
        LENGTH / (E * of.I1),
    ]
    turn = np.kron(np.eye(2), TURN)
    flexibility = turn.T @ np.linalg.inv(K)[-6:, -6:] @ turn
    np.testing.assert_allclose(np.diag(flexibility), expected, rtol=1e-9)
    # A tip force along y turns the tip about +z, one along z about -y.
    assert flexibility[5, 1] == pytest.approx(LENGTH**2 / (2 * E * of.I1), rel=1e-9)
    assert flexibility[4, 2] == pytest.approx(-(LENGTH**2) / (2 * E * of.I2), rel=1e-9)


def test_rigid_motion_costs_nothing():
    model = shell_model(beam(4), section())
    R = np.zeros((5, 6, 6))
    R[:, :3, :3], R[:, 3:, 3:] = np.eye(3), np.eye(3)
    for i, axis in enumerate(np.eye(3)):
        R[:, :3, 3 + i] = np.cross(axis, model.mesh.nodes)
    force = model.stiffness @ R.reshape(-1, 6)
    assert np.abs(force).max() <= 1e-9 * model.stiffness.diagonal().max()


def clamped_frequencies(n, n_modes, **changes):
    model = shell_model(beam(n), section(**changes))
    K, M = model.stiffness[6:][:, 6:], model.mass[6:][:, 6:]
    return np.sqrt(lowest_modes(K, M, n_modes).values)


def test_frequencies_of_a_slender_cantilever_and_their_order():
    """(beta L)^2 sqrt(E I / (rho A L^4)) in both planes; the linear mass converges at second order."""
    of = section(K1=0.0, K2=0.0)
    unit = np.sqrt(STEEL.youngs_modulus / (STEEL.density * of.area * LENGTH**4))
    expected = unit * 1.8751041**2 * np.sqrt([of.I2, of.I1])
    # Richardson: rotary inertia leaves a constant difference of some 1e-4.
    coarse, middle, fine = (clamped_frequencies(n, 2, K1=0.0, K2=0.0) for n in (5, 10, 20))
    np.testing.assert_allclose(fine, expected, rtol=2e-3)
    np.testing.assert_allclose(np.log2((coarse - middle) / (middle - fine)), 2, atol=0.1)
    np.testing.assert_allclose(fine + (fine - middle) / 3, expected, rtol=6e-4)


def test_torsion_and_stretch_of_a_free_beam():
    """omega = pi sqrt(G J / (rho I_p)) / L and pi c / L."""
    of = section()
    model = shell_model(beam(40), of)
    values = np.sqrt(lowest_modes(model.stiffness, model.mass, 40).values[6:])
    torsion = np.pi / LENGTH * np.sqrt(STEEL.shear_modulus * of.J / (STEEL.density * (of.I1 + of.I2)))
    stretch = np.pi / LENGTH * np.sqrt(STEEL.youngs_modulus / STEEL.density)
    for expected in (torsion, stretch):
        assert np.abs(values / expected - 1).min() < 4e-4  # (pi / 40)^2 / 24 of the linear mass, and no more


def test_mass_has_the_inertia_of_a_bar():
    of = section(mass_per_length=15.0)
    model = shell_model(beam(5), of)
    found = rigid_mass_properties(model.mass, model.mesh.nodes, 6)
    assert found.mass == pytest.approx(15.0 * LENGTH, rel=1e-12)
    rotary = STEEL.density * LENGTH * np.array([of.I1 + of.I2, of.I2, of.I1])
    bar = 15.0 * LENGTH**3 / 12 * np.array([0, 1, 1])
    inertia = TURN @ np.diag(rotary + bar) @ TURN.T
    np.testing.assert_allclose(found.inertia, inertia, atol=1e-9)
    # What the mesh and the sections say, without the mass matrix.
    np.testing.assert_allclose(mesh_mass_properties(model).inertia, inertia, atol=1e-9)
    assert lumped_mass(model).reshape(-1, 6)[:, 0].sum() == pytest.approx(15.0 * LENGTH)


def test_tension_stiffens_across_the_beam():
    """The tangent of a stretched element gains N / L across, N being the force of its Green strain."""
    mesh = beam(1)
    assembly = assemble(shell_model(mesh, section()))
    stretch = 1e-3
    q = np.zeros((2, 6))
    q[1, :3] = stretch * LENGTH * TURN[:, 0]
    gained = (assembly.tangent(q.ravel()) - assembly.tangent(np.zeros(12))).toarray()[6:9, 6:9]
    force = STEEL.youngs_modulus * WIDTH * HEIGHT * (stretch + stretch**2 / 2)
    across = TURN.T @ gained @ TURN
    np.testing.assert_allclose(np.diag(across)[1:], force / LENGTH, rtol=1e-9)


def test_a_shell_stiffened_by_a_beam_is_the_sum_of_both():
    plate = strip(1.0, 0.2, 4, 2)
    centre = np.flatnonzero(plate.nodes[:, 1] == 0)
    lines = np.column_stack([centre[:-1], centre[1:]])
    triangles = plate.cells[CellType.TRIANGLE3]
    both = Mesh(
        plate.nodes,
        {CellType.TRIANGLE3: triangles, CellType.LINE2: lines},
        cell_sets={
            "skin": {CellType.TRIANGLE3: np.arange(len(triangles))},
            "rib": {CellType.LINE2: np.arange(len(lines))},
        },
    )
    wall, of = HomogeneousSection(STEEL, 0.01), section(orientation=(0, 0, 1))
    model = shell_model(both, {"skin": wall, "rib": of})
    alone = shell_model(plate, wall)
    beams = shell_model(
        Mesh(plate.nodes[centre], {CellType.LINE2: np.column_stack([np.arange(4), np.arange(1, 5)])}), of
    )
    rows = (6 * centre[:, None] + np.arange(6)).ravel()
    for name in ("stiffness", "mass"):
        expected = getattr(alone, name).toarray()
        expected[np.ix_(rows, rows)] += getattr(beams, name).toarray()
        np.testing.assert_allclose(getattr(model, name).toarray(), expected, atol=1e-12 * abs(expected).max())
    assert len(skin_of(both).triangles) == len(triangles)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"area": 0.0}, "beam section: area is 0.0; it must be positive"),
        ({"J": float("nan")}, "beam section: J is nan"),
        ({"I12": 1.0}, "beam section: I12 is 1.0; its square must be below"),
        ({"neutral": (0.0, float("inf"))}, "beam section: neutral is"),
        ({"rotary": (1.0, -1.0, 0.0)}, "beam section: rotary is"),
        ({"K1": -1.0}, "the shear factor K1 is -1.0; give a positive one, or 0"),
        ({"orientation": (0, 0, 0)}, r"orientation is \(0, 0, 0\); give three finite numbers, not all zero"),
    ],
)
def test_sections_that_cannot_be(changes, message):
    with pytest.raises(ModelError, match=message):
        section(**changes)


def test_beams_that_cannot_be():
    with pytest.raises(ModelError, match="beam 0 of its section lies along the section's orientation"):
        shell_model(beam(2), section(orientation=TURN[:, 0]))
    with pytest.raises(ModelError, match="lines need a BeamSection, not HomogeneousSection"):
        shell_model(beam(2), HomogeneousSection(STEEL, 0.01))
    with pytest.raises(ModelError, match="a shell needs a wall, not BeamSection"):
        shell_model(strip(1.0, 0.2, 4, 2), section())
    with pytest.raises(ModelError, match="no stress recovery for beams"):
        stress_recovery(shell_model(beam(2), section()))
    with pytest.raises(ModelError, match="a mesh of beams alone has no skin"):
        skin_of(beam(2))
    with pytest.raises(MeshError, match=r"1 degenerate LINE2 cell \(1\), with \(almost\) no length"):
        Mesh([[0, 0, 0], [1, 0, 0], [1, 0, 0]], {CellType.LINE2: [[0, 1], [1, 2]]})
