"""Beams of any section: closed forms of tip flexibility, offsets, releases, taper, coupling, inertia."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.optimize import minimize

from supple.algebra.cross import cross_matrix
from supple.body import mesh_mass_properties, rigid_mass_properties
from supple.errors import ModelError
from supple.fem import (
    BeamSection,
    CoupledBeamSection,
    Isotropic,
    RodSection,
    Section,
    assemble,
    finite_element_model,
    lumped_mass,
    shell_model,
)
from supple.fem.beam2 import beam_line, beam_strain
from supple.fem.quadratic_strain import energy, internal_force
from supple.mesh import CellType, Mesh

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
LENGTH = 1.5
PLAIN = BeamSection(STEEL, 1.5e-3, 3e-7, 1e-7, 2e-7, 0.8, 0.7, orientation=(0, 1, 0))
GENERAL = replace(
    PLAIN,
    I12=-1e-7,
    neutral=(0.01, -0.02),
    mass_centre=(-0.015, 0.03),
    second=BeamSection(
        STEEL, 0.8e-3, 1e-7, 0.6e-7, 1e-7, 0.9, 0.6, I12=2e-8, neutral=(0.0, -0.01), mass_per_length=9.0
    ),
)


def random_spd(seed, scale):
    A = np.random.default_rng(seed).normal(size=(6, 6))
    return np.sqrt(np.outer(scale, scale)) * (A @ A.T / 6 + np.eye(6))


STIFF = np.array([3e8, 1e8, 8e7, 2e4, 3e4, 6e4])
COUPLED = CoupledBeamSection(random_spd(1, STIFF), np.diag([8.0, 8, 8, 3e-3, 1e-3, 2e-3]), (0, 1, 0))
TAPERED = replace(COUPLED, second=CoupledBeamSection(random_spd(2, 0.3 * STIFF), 0.5 * COUPLED.mass))
EVERY = pytest.mark.parametrize(
    "section", [PLAIN, GENERAL, COUPLED, TAPERED], ids=["plain", "general", "coupled", "tapered"]
)


def line(n=1, length=LENGTH):
    nodes = np.linspace(0, length, n + 1)[:, None] * np.array([1.0, 0, 0])
    return Mesh(nodes, {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])})


def element(section, released=None, offsets=None, kinematics=None):
    ends = np.array([[[0.0, 0, 0], [LENGTH, 0.2, -0.1]]])
    where = beam_line(ends, section, None, offsets)
    return beam_strain(where, np.arange(12)[None], section, released=released)


@EVERY
def test_the_tip_of_a_cantilever_follows_from_the_flexibility_of_its_sections(section):
    """int H^T S^-1 H dx, where H gives the section's forces from those of the tip."""

    def integrand(x):
        H = np.eye(6)
        H[3:, :3] = cross_matrix(np.array([LENGTH - x, 0, 0]))
        return H.T @ section.flexibility(np.array([x / LENGTH]))[0] @ H

    expected, _ = quad_vec(integrand, 0, LENGTH)
    K = shell_model(line(), section).stiffness.toarray()[6:, 6:]
    np.testing.assert_allclose(np.linalg.inv(K), expected, rtol=1e-7, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("section", [PLAIN, COUPLED])
def test_a_constant_section_needs_one_element(section):
    one, many = (
        np.linalg.inv(shell_model(line(n), section).stiffness.toarray()[6:, 6:])[-6:, -6:] for n in (1, 5)
    )
    np.testing.assert_allclose(many, one, rtol=1e-7, atol=1e-8 * np.abs(one).max())


def test_the_section_by_its_matrices_is_the_section_by_its_values():
    plain = replace(GENERAL, second=None)
    S = np.linalg.inv(plain.flexibility(np.zeros(1))[0])
    matrices = CoupledBeamSection(S, plain.inertia(np.zeros(1))[0], plain.orientation)
    first, second = (shell_model(line(3), each) for each in (plain, matrices))
    for name in ("stiffness", "mass"):
        a, b = (getattr(model, name).toarray() for model in (first, second))
        np.testing.assert_allclose(a, b, atol=1e-9 * np.abs(b).max())


def test_a_product_of_inertia_is_a_section_in_turned_axes():
    """I1, I2 about principal axes turned by beta: I1' + I2' = I1 + I2, I12' = (I1 - I2)/2 sin 2 beta."""
    beta = 0.4
    c, s = np.cos(beta), np.sin(beta)
    I1, I2 = PLAIN.I1, PLAIN.I2
    even = replace(PLAIN, K1=0.8, K2=0.8)
    # y = c Y - s Z, z = s Y + c Z of principal Y, Z, where I1 = int Y^2.
    turned = replace(even, I1=c * c * I1 + s * s * I2, I2=s * s * I1 + c * c * I2, I12=c * s * (I1 - I2))
    principal = replace(even, orientation=(0, c, s))
    for name in ("stiffness", "mass"):
        a, b = (getattr(shell_model(line(2), each), name).toarray() for each in (turned, principal))
        np.testing.assert_allclose(a, b, atol=1e-12 * np.abs(b).max())


def test_a_force_beside_the_neutral_axis_bends():
    """N at the shear centre: extension N L (1/EA + y^2/EI1 + z^2/EI2), turning by N z L/EI2, -N y L/EI1."""
    y, z = 0.02, -0.03
    section = replace(PLAIN, neutral=(y, z))
    E = STEEL.youngs_modulus
    flexibility = np.linalg.inv(shell_model(line(), section).stiffness.toarray()[6:, 6:])
    stretch = LENGTH / E * (1 / PLAIN.area + y**2 / PLAIN.I1 + z**2 / PLAIN.I2)
    assert flexibility[0, 0] == pytest.approx(stretch, rel=1e-9)
    assert flexibility[4, 0] == pytest.approx(-z * LENGTH / (E * PLAIN.I2), rel=1e-9)
    assert flexibility[5, 0] == pytest.approx(y * LENGTH / (E * PLAIN.I1), rel=1e-9)


OFFSETS = np.array([[[0.1, 0.2, -0.05], [-0.05, 0.1, 0.15]]])


@EVERY
def test_offsets_are_rigid_arms(section):
    """K and M of the nodes are A^T K A and A^T M A of a beam between the ends, u_end = u + theta x o."""
    mesh = line()
    own = Section(CellType.LINE2, np.arange(1), section, offsets=OFFSETS)
    with_arms = finite_element_model(mesh, (own,))
    between = shell_model(Mesh(mesh.nodes + OFFSETS[0], mesh.cells), section)
    A = np.eye(12)
    for end in range(2):
        A[6 * end : 6 * end + 3, 6 * end + 3 : 6 * end + 6] = -cross_matrix(OFFSETS[0, end])
    for name in ("stiffness", "mass"):
        expected = A.T @ getattr(between, name).toarray() @ A
        found = getattr(with_arms, name).toarray()
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(("offsets", "order"), [(None, 8), (OFFSETS, 6)])
def test_a_rigid_rotation_costs_energy_of_high_order(offsets, order):
    block = element(PLAIN, offsets=offsets)
    ends = np.array([[0.0, 0, 0], [LENGTH, 0.2, -0.1]])
    axis = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])

    def spent(angle):
        W = cross_matrix(axis)
        R = np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W
        q = np.hstack([ends @ R.T - ends, np.tile(angle * axis, (2, 1))])
        return energy(block, q.reshape(1, 12))[0]

    assert np.log2(spent(0.1) / spent(0.05)) == pytest.approx(order, abs=0.3)


RELEASES = {
    "hinge": [10, 11],
    "pinned bar": [4, 5, 10, 11],
    "sliding": [6],
    "in shear and bending": [1, 11],
    "all twist": [3, 9],
}


@pytest.mark.parametrize("freedoms", RELEASES.values(), ids=RELEASES)
@pytest.mark.parametrize("section", [PLAIN, COUPLED], ids=["plain", "coupled"])
def test_released_freedoms_are_condensed(section, freedoms):
    """K_kk - K_kr K_rr^-1 K_rk of the beam in its axes, which are those of the mesh here."""
    released = np.zeros((1, 12), dtype=bool)
    released[0, freedoms] = True
    K = shell_model(line(), section).stiffness.toarray()
    own = Section(CellType.LINE2, np.arange(1), section, released=released)
    found = finite_element_model(line(), (own,)).stiffness.toarray()
    r = released[0]
    expected = np.zeros((12, 12))
    expected[np.ix_(~r, ~r)] = (
        K[np.ix_(~r, ~r)] - K[np.ix_(~r, r)] @ np.linalg.pinv(K[np.ix_(r, r)], rcond=1e-9) @ K[np.ix_(r, ~r)]
    )
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(K).max())


def test_a_hinged_end_carries_no_moment():
    """3 E I / L^3 against a force across, no stiffness of the hinge's own rotation."""
    section = replace(PLAIN, K1=0.0, K2=0.0)
    released = np.zeros((1, 12), dtype=bool)
    released[0, 11] = True
    own = Section(CellType.LINE2, np.arange(1), section, released=released)
    K = finite_element_model(line(), (own,)).stiffness.toarray()
    assert K[7, 7] == pytest.approx(3 * STEEL.youngs_modulus * section.I1 / LENGTH**3, rel=1e-9)
    assert np.abs(K[11]).max() < 1e-9 * K[5, 5]


@pytest.mark.parametrize("offsets", [None, OFFSETS])
def test_the_energy_of_released_beams_is_least_up_to_its_third_order(offsets):
    """Against the minimum over the released freedoms of the unreleased beam: what differs falls as q^4."""
    released = np.zeros((1, 12), dtype=bool)
    released[0, [4, 5, 10, 11]] = True
    # Of one stiffness in all directions, so that a plain search finds the minimum.
    soft = CoupledBeamSection(np.diag([3.0, 2, 2.5, 1, 1.3, 0.8]), np.eye(6), (0, 1, 0))
    held, hinged = (element(soft, each, offsets) for each in (None, released))
    where = beam_line(np.array([[[0.0, 0, 0], [LENGTH, 0.2, -0.1]]]), soft, None, offsets)
    given = np.random.default_rng(5).normal(size=12)

    def lacking(scale):
        q = scale * given

        def spent(turns):
            # The ends turn against their nodes: of the arms, the nodes' rotation counts.
            beside = np.zeros((1, 12))
            beside[0, [4, 5, 10, 11]] = scale * turns
            moved = beside.reshape(2, 2, 3)[:, 1] @ where.axes[0]
            ends = q.reshape(2, 2, 3).copy()
            ends[:, 1] += moved
            if offsets is None:
                return energy(held, ends.reshape(1, 12))[0] / scale**2
            return _energy_of_ends(soft, where, q, moved) / scale**2

        least = minimize(spent, np.zeros(4), method="BFGS", options={"gtol": 1e-11}).fun
        return energy(hinged, q[None])[0] / scale**2 - least

    coarse, fine = lacking(0.1), lacking(0.05)
    assert 0 < abs(fine) < abs(coarse) / 3  # a quarter; half if the third order were wrong


def _energy_of_ends(section, where, q, moved):
    """Energy of a beam whose ends move by u + theta x o + 1/2 theta x (theta x o), and turn besides."""
    q = q.reshape(2, 2, 3)
    arms = where.arms[0] @ where.axes[0]
    u = q[:, 0] + np.cross(q[:, 1], arms) + 0.5 * np.cross(q[:, 1], np.cross(q[:, 1], arms))
    ends = np.array([[[0.0, 0, 0], [LENGTH, 0.2, -0.1]]]) + arms
    block = beam_strain(beam_line(ends, section), np.arange(12)[None], section)
    return energy(block, np.stack([u, q[:, 1] + moved], axis=1).reshape(1, 12))[0]


@pytest.mark.parametrize("released", [None, [4, 5, 11]])
def test_force_is_the_gradient_of_energy(released, rng):
    mask = None
    if released is not None:
        mask = np.zeros((1, 12), dtype=bool)
        mask[0, released] = True
    block = element(TAPERED, mask, OFFSETS)
    q = 0.1 * rng.normal(size=12)
    steps = q + 1e-30j * np.eye(12)
    gradient = [energy(block, step[None])[0].imag / 1e-30 for step in steps]
    np.testing.assert_allclose(internal_force(block, q[None])[0], gradient, rtol=1e-10, atol=1e-3)


@EVERY
@pytest.mark.parametrize("offsets", [None, OFFSETS], ids=["at the nodes", "offset"])
def test_mass_has_the_inertia_of_the_sections(section, offsets):
    own = Section(CellType.LINE2, np.arange(1), section, offsets=offsets)
    model = finite_element_model(line(), (own,))
    found, expected = rigid_mass_properties(model.mass, model.mesh.nodes, 6), mesh_mass_properties(model)
    assert found.mass == pytest.approx(expected.mass, rel=1e-12)
    np.testing.assert_allclose(found.centre, expected.centre, atol=1e-12)
    np.testing.assert_allclose(found.inertia, expected.inertia, atol=1e-10)


def test_a_mass_centre_beside_the_axis_is_where_it_is_said():
    y, z = 0.05, -0.07
    section = replace(PLAIN, mass_centre=(y, z), rotary=(1e-3, 4e-4, 6e-4), mass_per_length=12.0)
    found = rigid_mass_properties(shell_model(line(4), section).mass, line(4).nodes, 6)
    np.testing.assert_allclose(found.centre, [LENGTH / 2, y, z], atol=1e-12)
    bar = 12.0 * LENGTH**3 / 12
    np.testing.assert_allclose(
        np.diag(found.inertia), LENGTH * np.array([1e-3, 4e-4, 6e-4]) + [0, bar, bar], rtol=1e-9
    )
    diagonal = lumped_mass(shell_model(line(4), section)).reshape(-1, 6)
    assert diagonal[:, 0].sum() == pytest.approx(12.0 * LENGTH)
    assert diagonal[:, 3].sum() == pytest.approx(LENGTH * (1e-3 + 12.0 * (y**2 + z**2)))


def test_a_rod_stretches_twists_and_does_nothing_else():
    rod = RodSection(STEEL, 1e-3, 2e-7, mass_per_length=5.0)
    K = shell_model(line(), rod).stiffness.toarray()
    expected = np.zeros((12, 12))
    pattern = np.array([[1, -1], [-1, 1]])
    expected[np.ix_([0, 6], [0, 6])] = STEEL.youngs_modulus * 1e-3 / LENGTH * pattern
    expected[np.ix_([3, 9], [3, 9])] = STEEL.shear_modulus * 2e-7 / LENGTH * pattern
    np.testing.assert_allclose(K, expected, atol=1e-6)
    found = rigid_mass_properties(shell_model(line(), rod).mass, line().nodes, 6)
    assert found.mass == pytest.approx(5.0 * LENGTH)


def test_rods_without_torsion_leave_the_nodes_three_freedoms_and_hold_them_by_their_force():
    """A stretched string: N / L across; the strain of a turned rod is none whatever the angle."""
    rod = RodSection(STEEL, 1e-3)
    model = finite_element_model(line(), (Section(CellType.LINE2, np.arange(1), rod),))
    assert model.dofs_per_node == 3
    assembly = assemble(model)
    stretch = 1e-3
    q = np.array([0.0, 0, 0, stretch * LENGTH, 0, 0])
    force = STEEL.youngs_modulus * 1e-3 * (stretch + stretch**2 / 2)
    assert assembly.tangent(q)[4, 4] == pytest.approx(force / LENGTH, rel=1e-12)
    angle = 2.0
    turned = LENGTH * np.array([0.0, 0, 0, np.cos(angle) - 1, np.sin(angle), 0])
    assert assembly.energy(turned) < 1e-20 * STEEL.youngs_modulus


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffness": -np.eye(6)}, "the stiffness is not positive definite; check units and order"),
        ({"mass": -np.eye(6)}, "the mass matrix has a negative eigenvalue"),
        ({"mass": np.eye(5)}, r"beam section: mass has shape \(5, 5\)"),
    ],
)
def test_matrices_that_cannot_be(changes, message):
    with pytest.raises(ModelError, match=message):
        replace(COUPLED, **changes)


def test_rods_and_offsets_that_cannot_be():
    with pytest.raises(ModelError, match=r"rod: area is 0\.0"):
        RodSection(STEEL, 0.0)
    with pytest.raises(ModelError, match=r"rod: J is -1\.0"):
        RodSection(STEEL, 1.0, -1.0)
    with pytest.raises(ModelError, match="offsets are for beams only, not for RodSection"):
        Section(CellType.LINE2, np.arange(1), RodSection(STEEL, 1.0), offsets=OFFSETS)
    with pytest.raises(ModelError, match=r"offsets of LINE2 cells have shape \(1, 2\); expected \(1, 2, 3\)"):
        Section(CellType.LINE2, np.arange(1), PLAIN, offsets=OFFSETS[:, 0, :2])
    with pytest.raises(ModelError, match="directions of LINE2 cells are not all finite"):
        Section(CellType.LINE2, np.arange(1), PLAIN, directions=np.full((1, 3), np.nan))
    together = np.array([[[LENGTH / 2, 0, 0], [-LENGTH / 2, 0, 0]]])
    own = Section(CellType.LINE2, np.arange(1), PLAIN, offsets=together)
    with pytest.raises(ModelError, match="the offsets of beam 0 of its section make its ends coincide"):
        finite_element_model(line(), (own,))


def test_a_tapered_beam_has_one_elastic_material():
    """The modulus of the second end was ignored; a density of its own counts."""
    other = replace(GENERAL.material, density=2 * GENERAL.material.density)
    assert replace(GENERAL, second=replace(GENERAL, second=None, material=other)).second is not None
    softer = replace(GENERAL.material, youngs_modulus=0.5 * GENERAL.material.youngs_modulus)
    with pytest.raises(ModelError, match="its second end has other moduli"):
        replace(GENERAL, second=replace(GENERAL, second=None, material=softer))
