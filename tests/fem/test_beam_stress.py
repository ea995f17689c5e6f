"""Section forces and stress of beams and rods: equilibrium, closed forms, method against method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.errors import ModelError
from supple.fem import (
    BeamSection,
    CoupledBeamSection,
    HomogeneousSection,
    Isotropic,
    RodSection,
    Section,
    beam_force_recovery,
    beam_forces,
    finite_element_model,
    has_stress,
    shell_model,
    strain_recovery,
    stress_recovery,
    von_mises,
)
from supple.fem.model import line_of
from supple.fem.quadratic_strain import internal_force
from supple.importers.nastran.section_shapes import SHAPES
from supple.mesh import CellType, Mesh, SectionGeometry, circular_section, plate, rectangular_section

STEEL = Isotropic(2.1e11, 0.3, 7850.0)
H, W = 0.06, 0.02
I1, I2 = W * H**3 / 12, H * W**3 / 12
RECTANGLE = BeamSection(
    STEEL, H * W, I1, I2, 2.1e-7, 5 / 6, 5 / 6, (0, 1, 0), geometry=rectangular_section(H, W)
)
ECCENTRIC = replace(
    RECTANGLE,
    I12=3e-8,
    neutral=(0.01, -0.02),
    second=replace(RECTANGLE, area=0.5 * H * W, I1=0.4 * I1, neutral=(-0.005, 0.0)),
)


def spd(seed):
    A = np.random.default_rng(seed).normal(size=(6, 6))
    scale = np.sqrt([3e8, 1e8, 8e7, 2e4, 3e4, 6e4])
    return np.outer(scale, scale) * (A @ A.T / 6 + np.eye(6))


COUPLED = CoupledBeamSection(spd(1), np.eye(6), (0, 1, 0), CoupledBeamSection(spd(2), np.eye(6)))


def chain(nodes):
    nodes = np.asarray(nodes, dtype=float)
    n = len(nodes) - 1
    return Mesh(nodes, {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])})


def straight(n=3, length=1.5):
    return chain(np.linspace(0, length, n + 1)[:, None] * np.eye(3)[0])


def clamped(model, load):
    """Linear displacements (n,) of a model clamped at node 0."""
    free = np.arange(6, model.n_dofs)
    u = np.zeros(model.n_dofs)
    u[free] = np.linalg.solve(model.stiffness.toarray()[np.ix_(free, free)], load[free])
    return u


def at_tip(model, wrench):
    load = np.zeros(model.n_dofs)
    load[-6:] = wrench
    return load


# --- section forces


@pytest.mark.parametrize("section", [RECTANGLE, ECCENTRIC, COUPLED], ids=["plain", "eccentric", "coupled"])
@pytest.mark.parametrize("offset", [False, True], ids=["on the nodes", "offset"])
def test_section_forces_carry_the_load_beyond(section, offset, rng):
    """A chain in space clamped at one end: F = P, M = M_P + (tip - x) x P at every end, along its axes."""
    mesh = chain([[0, 0, 0], [0.7, 0.1, 0], [1.3, 0.5, 0.2], [1.5, 1.1, 0.6]])
    offsets = 0.05 * rng.normal(size=(3, 2, 3)) if offset else None
    given = Section(CellType.LINE2, np.arange(3), section, rng.normal(size=(3, 3)), offsets)
    model = finite_element_model(mesh, (given,))
    wrench = 1e-9 * rng.normal(size=6)  # small: forces are linear then
    found = beam_forces(model, clamped(model, at_tip(model, wrench)))
    line = line_of(mesh, given)
    ends = given.corners(mesh) + (0 if offsets is None else offsets)
    moments = wrench[3:] + np.cross(mesh.nodes[-1] - ends, wrench[:3])
    in_space = np.concatenate([np.broadcast_to(wrench[:3], (3, 2, 3)), moments], axis=2).reshape(3, 2, 2, 3)
    expected = np.einsum("eij,eakj->eaki", line.axes, in_space).reshape(3, 2, 6)
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(wrench).max())


def test_a_pinned_end_carries_no_moment(rng):
    released = np.zeros((1, 12), dtype=bool)
    released[0, [3, 4, 5]] = True
    given = Section(CellType.LINE2, np.arange(1), RECTANGLE, released=released)
    model = finite_element_model(straight(1), (given,))
    u = 1e-4 * rng.normal(size=12)
    first, second = beam_forces(model, u)[0]
    assert np.abs(first[3:]).max() < 1e-9 * np.abs(second[3:]).max()
    assert second[3] == pytest.approx(0, abs=1e-9 * np.abs(second).max())


@pytest.mark.parametrize("section", [RECTANGLE, COUPLED], ids=["plain", "coupled"])
def test_section_forces_are_the_internal_forces_of_the_ends(section, rng):
    """At finite displacements the nodes feel them, up to what the chord has turned: second order of it."""
    model = shell_model(straight(1), section)
    (block,) = model.blocks
    q = rng.normal(size=12)
    differences = []
    for size in (1e-3, 5e-4):
        force = internal_force(block, size * q[None])[0].reshape(2, 6)
        first, second = beam_forces(model, size * q)[0]
        differences.append([np.linalg.norm(force[1] - second), np.linalg.norm(force[0] + first)])
    ratio = np.divide(*differences)
    assert ratio == pytest.approx(4.0, rel=0.1)


def test_the_second_order_of_a_cable(rng):
    """A chord that turns by w / L without rotation of its ends is stretched: N = E A / 2 (w / L)^2."""
    model = shell_model(straight(1, 2.0), RECTANGLE)
    u = np.zeros(12)
    u[7] = w = 1e-2
    N = beam_forces(model, u)[0, :, 0]
    assert N == pytest.approx(2.1e11 * H * W / 2 * (w / 2.0) ** 2, rel=1e-12)
    difference = (beam_forces(model, 2 * u) - 2 * beam_forces(model, u))[0, :, 0]
    assert difference == pytest.approx(2 * N, rel=1e-9)


def test_a_rigid_rotation_leaves_the_chain_without_force():
    """0.3 rad about any axis: the strain is of fourth order, against 4.5 % of a linear one."""
    mesh = chain([[0, 0, 0], [0.5, 0, 0], [1.0, 0.2, 0.1]])
    model = shell_model(mesh, RECTANGLE)
    theta = 0.3 * np.array([0.3, -0.5, 0.81])
    R = Rotation.from_rotvec(theta).as_matrix()
    u = np.column_stack([mesh.nodes @ (R - np.eye(3)).T, np.tile(theta, (3, 1))]).ravel()
    stress = np.abs(stress_recovery(model).at_nodes(u)).max()
    linear = np.abs(stress_recovery(model).linearized().at_nodes(u)).max()
    assert linear > 0.03 * 2.1e11
    assert stress < 2e-3 * linear


def test_the_centrifugal_force_of_a_rotating_beam():
    """N(x) = m w^2 (L^2 - x^2) / 2 in the middle of elements, where the mean of the ends is exact."""
    n, length, speed = 6, 1.5, 0.04
    model = shell_model(straight(n, length), RECTANGLE)
    field = np.zeros((n + 1, 6))
    field[:, 0] = speed**2 * model.mesh.nodes[:, 0]
    u = clamped(model, model.mass @ field.ravel())
    N = beam_forces(model, u)[:, :, 0].mean(axis=1)
    x = (np.arange(n) + 0.5) * length / n
    m, h = 7850 * H * W, length / n
    exact = m * speed**2 * (length**2 - x**2) / 2
    np.testing.assert_allclose(N, exact - m * speed**2 * h**2 / 24, rtol=1e-9)


def test_a_distributed_load_converges():
    """Clamped at both ends: M = q L^2 / 12 with the square of an element's length, V = q L / 2 linearly."""
    errors = []
    for n in (4, 8, 16):
        model = shell_model(straight(n, 1.0), RECTANGLE)
        load, u = np.zeros(model.n_dofs), np.zeros(model.n_dofs)
        load[2::6] = 1e-3 / n
        free = np.arange(6, model.n_dofs - 6)
        u[free] = np.linalg.solve(model.stiffness.toarray()[np.ix_(free, free)], load[free])
        first = beam_forces(model, u)[0, 0]
        errors.append([first[4] / (1e-3 / 12) + 1, first[2] / (1e-3 / 2) - 1])
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(rates, [[2, 1]] * 2, atol=1e-3)


def test_rods_carry_tension_and_torsion():
    rod = RodSection(STEEL, 3e-4, 2e-8, torsion_arm=0.01)
    model = shell_model(chain([[0, 0, 0], [0.6, 0, 0.8]]), rod)
    axis = np.array([0.6, 0, 0.8])
    u = np.concatenate([np.zeros(6), 1e-6 * axis, 2e-4 * axis])
    N, T = 2.1e11 * 3e-4 * 1e-6, STEEL.shear_modulus * 2e-8 * 2e-4
    found = beam_forces(model, u)
    np.testing.assert_allclose(found[0], [[N, 0, 0, T, 0, 0]] * 2, rtol=1e-5, atol=1e-9)
    stress = stress_recovery(model).at_nodes(u)
    assert stress.shape == (2, 1, 6)
    assert von_mises(stress) == pytest.approx(np.hypot(N / 3e-4, np.sqrt(3) * 0.01 * T / 2e-8), rel=1e-5)
    full = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    assert axis @ stress[0, 0][full] @ axis == pytest.approx(N / 3e-4, rel=1e-5)


def test_forces_of_one_beam_alone():
    model = shell_model(straight(3), RECTANGLE)
    u = clamped(model, at_tip(model, [0, 0, 1.0, 0, 0, 0]))
    alone = beam_force_recovery(model, 1).at_nodes(u)[[1, 2], 0]
    np.testing.assert_allclose(alone, beam_forces(model, u)[1], atol=1e-12)
    with pytest.raises(ModelError, match="no beam or rod number 7; the mesh has 3"):
        beam_force_recovery(model, 7)


# --- stress


def test_bending_of_a_cantilever_at_the_points_of_its_section():
    """sigma = N / A - M y / I about both axes, to rounding; nothing across the beam."""
    n, length = 3, 1.5
    model = shell_model(straight(n, length), RECTANGLE)
    N, Vy, Vz = 1.0, 0.3, -0.2
    u = clamped(model, at_tip(model, [N, Vy, Vz, 0, 0, 0]))
    stress = stress_recovery(model).linearized().at_nodes(u)
    layers = stress_recovery(model).layers
    assert (layers.walls, layers.points, layers.ends) == (0, 8, 2)
    y, z = np.array(RECTANGLE.geometry.points).T
    x = np.linspace(0, length, n + 1)[:, None]
    Mz, My = Vy * (length - x), -Vz * (length - x)
    expected = N / (H * W) - Mz * y / I1 + My * z / I2
    np.testing.assert_allclose(stress[:, :8, 0], expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(stress[1:-1, 8:, 0], expected[1:-1], atol=1e-9 * np.abs(expected).max())
    assert not stress[[0, -1], 8:].any()
    assert np.abs(stress[..., 1:]).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("shape", ["I", "L", "T", "CHAN", "Z", "HAT", "BOX1"])
def test_the_stress_of_a_shape_has_the_resultants_of_its_section(shape):
    """The linear field through the points of stress recovery, integrated over the walls, gives N, My, Mz."""
    sizes = {"I": (6, 3, 4, 0.4, 0.5, 0.7), "L": (4, 5, 0.6, 0.4), "T": (4, 5, 0.6, 0.4)}
    sizes |= {"CHAN": (3, 5, 0.4, 0.6), "Z": (2, 0.5, 4, 5), "HAT": (4, 0.5, 3, 1)}
    sizes |= {"BOX1": (4, 5, 0.4, 0.5, 0.6, 0.7)}
    s = SHAPES[shape](*sizes[shape])
    neutral = (-s.shear_centre[0], -s.shear_centre[1])
    geometry = s.geometry.moved(*neutral)
    section = BeamSection(
        STEEL, s.area, s.I1, s.I2, s.J, I12=s.I12, neutral=neutral, orientation=(0, 1, 0), geometry=geometry
    )
    model = shell_model(straight(1), section)
    wrench = np.array([5.0, 0, 0, 0, 0.7, -0.4])
    stress = stress_recovery(model).linearized().at_nodes(clamped(model, at_tip(model, wrench)))[0, :, 0]
    points = np.array(geometry.points)
    rows = np.column_stack([np.ones(len(points)), points])
    field, _, rank, _ = np.linalg.lstsq(rows, stress, rcond=None)
    assert rank == 3
    np.testing.assert_allclose(rows @ field, stress, atol=1e-10 * np.abs(stress).max())
    resultants = np.zeros(3)
    for loop in geometry.loops:
        corners = np.array(loop)
        area = np.prod(np.ptp(corners, axis=0))
        # Simpson's rule of a rectangle integrates the squares.
        places = np.concatenate([[corners.mean(axis=0)] * 2, (corners + np.roll(corners, 1, axis=0)) / 2])
        weights = np.array([0.0, 1 / 3, 1 / 6, 1 / 6, 1 / 6, 1 / 6])
        sigma = np.column_stack([np.ones(6), places]) @ field
        y, z = places.T
        resultants += area * np.array([weights @ sigma, weights @ (z * sigma), -weights @ (y * sigma)])
    np.testing.assert_allclose(resultants, wrench[[0, 4, 5]], rtol=1e-9)


def test_torsion_of_a_closed_cell_and_of_a_round_bar():
    """Bredt: tau = M / (2 A t). A shaft: tau = M r / J."""
    box = SHAPES["BOX"](0.3, 0.2, 0.01, 0.02)
    shaft = circular_section(0.05, 0.04)
    J = np.pi / 2 * (0.05**4 - 0.04**4)
    np.testing.assert_allclose(np.linalg.norm(shaft.torsion_shear, axis=1), 0.05 / J)
    # At corners the thinner wall counts.
    cell = 0.28 * 0.19
    np.testing.assert_allclose(np.linalg.norm(box.geometry.torsion_shear, axis=1), 1 / (2 * cell * 0.01))


def test_torsion_of_a_rectangle():
    """The coefficients of Timoshenko and Goodier's table: 4.808 of a square, 1 / 0.312 of a strip 10 : 1."""
    square = np.linalg.norm(rectangular_section(1.0, 1.0).torsion_shear, axis=1)
    assert square == pytest.approx([0, 0, 0, 0, *[4.8038] * 4], abs=1e-3)
    strip = rectangular_section(1.0, 0.1)
    assert strip.torsion_shear[5][0] == pytest.approx(-1 / (0.312 * 0.01), rel=2e-3)
    assert strip.torsion_shear[4][1] == pytest.approx(0.742 / (0.312 * 0.01), rel=2e-3)


def test_a_twisted_bar_shows_the_shear_of_torsion():
    model = shell_model(straight(2), RECTANGLE)
    u = clamped(model, at_tip(model, [0, 0, 0, 1.0, 0, 0]))
    stress = stress_recovery(model).linearized().at_nodes(u)[1]
    tau = np.linalg.norm(RECTANGLE.geometry.torsion_shear, axis=1)
    np.testing.assert_allclose(von_mises(stress), np.tile(np.sqrt(3) * tau, 2), rtol=1e-9, atol=1e-6)


def test_stress_turns_with_the_beam(rng):
    Q = Rotation.random(random_state=3).as_matrix()
    mesh = straight(2)
    model = shell_model(mesh, RECTANGLE)
    turned = shell_model(Mesh(mesh.nodes @ Q.T, mesh.cells), replace(RECTANGLE, orientation=Q[:, 1]))
    u = 1e-3 * rng.normal(size=(6, 3))
    full = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    one = stress_recovery(model).at_nodes(u.ravel())[..., full]
    other = stress_recovery(turned).at_nodes((u @ Q.T).ravel())[..., full]
    np.testing.assert_allclose(other, Q @ one @ Q.T, atol=1e-9 * np.abs(one).max())


def test_strain_is_stress_over_stiffness():
    model = shell_model(straight(2), RECTANGLE)
    u = clamped(model, at_tip(model, [1.0, 0, 0, 0, 0, 0]))
    strain = strain_recovery(model).at_nodes(u)[0, 0]
    sigma = stress_recovery(model).at_nodes(u)[0, 0, 0]
    np.testing.assert_allclose(strain[:3], sigma / 2.1e11 * np.array([1, -0.3, -0.3]), rtol=1e-9)


def test_both_ends_of_a_tapered_beam():
    thin = replace(
        RECTANGLE, area=H * W / 4, I1=I1 / 16, I2=I2 / 16, geometry=rectangular_section(H / 2, W / 2)
    )
    model = shell_model(straight(1), replace(RECTANGLE, second=thin))
    u = clamped(model, at_tip(model, [0, 0, 0, 0, 0, 1.0]))
    stress = stress_recovery(model).linearized().at_nodes(u)[:, 0, 0]
    np.testing.assert_allclose(stress, [-H / 2 / I1, -H / 4 / (I1 / 16)], rtol=1e-9)


# --- beams beside others, and without points


def test_beams_beside_shells_have_layers_of_their_own():
    """A stiffened panel: the shell's stress is that without the beam's layers, at the same displacements."""
    flat = plate(1.0, 1.0, 2, 2)
    edge = np.flatnonzero(flat.nodes[:, 1] == 0)
    edge = edge[np.argsort(flat.nodes[edge, 0])]
    mesh = Mesh(flat.nodes, {**flat.cells, CellType.LINE2: np.column_stack([edge[:-1], edge[1:]])})
    shell = HomogeneousSection(STEEL, 0.01)
    wall = Section(CellType.TRIANGLE3, np.arange(len(mesh.cells[CellType.TRIANGLE3])), shell)
    beam = Section(CellType.LINE2, np.arange(2), RECTANGLE)
    # Whichever section comes first.
    model = finite_element_model(mesh, (beam, wall))
    recovery = stress_recovery(model)
    assert recovery.layers.names[:4] == ("bottom", "middle", "top", "beam 1 point 1")
    u = 1e-4 * np.random.default_rng(0).normal(size=model.n_dofs)
    alone = stress_recovery(shell_model(flat, shell)).at_nodes(u)
    at_nodes = recovery.at_nodes(u)
    np.testing.assert_allclose(at_nodes[:, :3], alone, rtol=1e-12)
    there = recovery.layers_at(np.arange(mesh.n_nodes))
    assert there[:, :3].all()
    assert (there[:, 3:].any(axis=1) == np.isin(np.arange(mesh.n_nodes), edge)).all()
    strains = strain_recovery(model).at_nodes(u)
    np.testing.assert_allclose(strains[:, 1] @ STEEL.elasticity, at_nodes[:, 1], atol=1e-6 * abs(alone).max())


def test_beams_that_meet_are_not_averaged():
    """A moment in the middle of a beam clamped at both ends: + M / 2 on one side, - M / 2 on the other."""
    model = shell_model(straight(2, 1.0), RECTANGLE)
    free = np.arange(6, 12)
    u = np.zeros(18)
    u[free] = np.linalg.solve(model.stiffness.toarray()[np.ix_(free, free)], [0, 0, 0, 1.0, 0, 0])
    T = beam_forces(model, u)[:, :, 3]
    np.testing.assert_allclose(T, [[0.5, 0.5], [-0.5, -0.5]], rtol=1e-9)
    worst = von_mises(stress_recovery(model).at_nodes(u)[1]).max()
    tau = np.linalg.norm(RECTANGLE.geometry.torsion_shear, axis=1).max()
    assert worst == pytest.approx(np.sqrt(3) * tau / 2, rel=1e-9)


def test_beams_without_points_have_no_stress():
    bare = replace(RECTANGLE, geometry=None)
    for section in (bare, replace(bare, geometry=SectionGeometry()), COUPLED):
        model = shell_model(straight(1), section)
        assert not has_stress(model)
        with pytest.raises(ModelError, match="have no recovery points"):
            stress_recovery(model)
    mixed = finite_element_model(
        replace(straight(2), node_ids=np.array([10, 20, 30])),
        tuple(Section(CellType.LINE2, np.array([k]), s) for k, s in enumerate((RECTANGLE, bare))),
    )
    assert has_stress(mixed)
    recovery = stress_recovery(mixed)
    assert recovery.layers_at(np.arange(3)).any(axis=1).tolist() == [True, True, False]
    with pytest.raises(ModelError, match=r"node 30 \(one of 1 such nodes\)"):
        recovery.around(np.array([1, 2]))


def test_a_mirrored_section_has_the_mirrored_stress():
    """An L with z the other way under the mirrored load: the same axial stress and torsion at every point."""
    s = SHAPES["L"](0.04, 0.05, 0.006, 0.004)
    neutral = (-s.shear_centre[0], -s.shear_centre[1])
    geometry = s.geometry.moved(*neutral)
    given = BeamSection(
        STEEL, s.area, s.I1, s.I2, s.J, I12=s.I12, neutral=neutral, orientation=(0, 1, 0), geometry=geometry
    )
    other = replace(given, I12=-s.I12, neutral=(neutral[0], -neutral[1]), geometry=geometry.mirrored())
    model, mirrored = shell_model(straight(1), given), shell_model(straight(1), other)
    wrench = np.array([1.0, 0.2, -0.3, 0.1, 0.7, -0.4])
    signs = np.array([1, 1, -1, -1, -1, 1])  # z of forces, x and y of moments
    one, two = (
        stress_recovery(each).linearized().at_nodes(clamped(each, at_tip(each, load)))
        for each, load in ((model, wrench), (mirrored, signs * wrench))
    )
    np.testing.assert_allclose(two, one * [1, 1, 1, -1, -1, 1], atol=1e-8 * np.abs(one).max())
