"""Lines of section tables beside closed forms and an independent integration of the beam's equations."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_matrices
from fixtures.section_tables import COUPLED, OFFSET, helix, helix_table, inertia, moved, prismatic
from scipy.spatial.transform import Rotation

from supple.algebra.cross import cross_matrix
from supple.errors import ModelError
from supple.importers import SectionTable
from supple.machine import DeadForce, Fixed, System
from supple.methods.intrinsic import CLAMPED, FREE, intrinsic_body, section_line
from supple.simulation import equilibrium
from supple_benchmarks.references.section_beam import SectionAt, clamped_frequencies, clamped_rest

L = 4.0


def tip_motion(line, wrench):
    """Of the clamped line, linear."""
    return np.linalg.solve(line.stiffness[6:, 6:], np.append(np.zeros(6 * line.n - 12), wrench))[-6:]


@pytest.mark.parametrize("n", [2, 5])
def test_a_coupled_cantilever_under_forces_at_its_tip(n):
    """u = (L C + L^2/2 (N^T C + C N) + L^3/3 N^T C N) W, N W the moment at unit distance from the tip."""
    C, N = np.linalg.inv(COUPLED), np.zeros((6, 6))
    N[3:, :3] = cross_matrix(np.array([0, 0, 1.0]))
    flexibility = L * C + L**2 / 2 * (N.T @ C + C @ N) + L**3 / 3 * N.T @ C @ N
    line = section_line("beam", prismatic(L), n)
    for wrench in np.eye(6):
        assert tip_motion(line, wrench) == pytest.approx(flexibility @ wrench, rel=1e-9, abs=1e-14)
    assert flexibility[5, 1] != 0  # the flap force twists


def test_frequencies_of_a_coupled_cantilever_converge_to_the_second_order():
    def section(_s):
        return SectionAt(np.eye(3), COUPLED, OFFSET)

    exact = clamped_frequencies(section, np.linspace(0, L, 41), np.linspace(5.0, 420.0, 84))
    assert len(exact) >= 6
    errors = [
        intrinsic_body(section_line("beam", prismatic(L), n), CLAMPED).modes.frequencies[:6] / exact[:6] - 1
        for n in (11, 21, 41)
    ]
    assert np.abs(errors[0]).max() < 6e-3
    assert np.abs(errors[2]).max() < 4e-4
    assert (np.abs(errors[0]) / np.abs(errors[1]) > 3.5).all()


def test_a_curved_twisted_tapering_beam_beside_its_integration():
    gravity = np.array([0.4, -1.0, -9.0])

    def section(s):
        return helix(s)[1]

    steps = np.linspace(0, L, 81)
    rest = clamped_rest(section, steps, gravity)
    exact = clamped_frequencies(section, steps, np.linspace(5.0, 200.0, 66))[:4]
    line = section_line("beam", helix_table(161), 41)
    weight = line.mass @ np.tile(np.append(gravity, np.zeros(3)), line.n)
    tip = np.linalg.solve(line.stiffness[6:, 6:], weight[6:])[-6:]
    assert tip == pytest.approx(rest[:6], abs=1e-4 * np.abs(rest[:6]).max())
    # The root's force is the weight of the whole, its moment that about the root.
    root = weight.reshape(-1, 6)
    arms = line.tree.points - line.tree.points[0]
    moment = (root[:, 3:] + np.cross(arms, root[:, :3])).sum(axis=0)
    assert np.append(root[:, :3].sum(axis=0), moment) == pytest.approx(rest[6:], rel=1e-4, abs=1e-3)
    found = intrinsic_body(line, CLAMPED).modes.frequencies[:4]
    assert found == pytest.approx(exact, rel=1.5e-4)


def test_the_static_flexibility_does_not_depend_on_the_stations():
    """As it must be for sections that change along a curve, where statics is exact."""
    wrench = np.array([1.0, -2.0, 0.5, 0.3, 0.1, -0.7])
    few, many = (tip_motion(section_line("beam", helix_table(33), n), wrench) for n in (2, 17))
    assert few == pytest.approx(many, rel=1e-5)


def test_another_curve_through_the_same_beam():
    """Offset centres of shear, tension and mass: the beam moves as before, seen from the other curve."""
    offset = np.array([0.25, -0.4, 0.0])
    wrench = np.array([3.0, -1.0, 2.0, 0.4, 0.9, -0.5])
    there = wrench.copy()
    there[3:] += np.cross(-offset, wrench[:3])
    first, second = prismatic(L), moved(prismatic(L), offset)
    a = tip_motion(section_line("beam", first, 9), wrench)
    b = tip_motion(section_line("beam", second, 9), there)
    b[:3] += np.cross(b[3:], -offset)
    assert b == pytest.approx(a, rel=1e-9)
    one, other = (intrinsic_body(section_line("beam", t, 9), CLAMPED) for t in (first, second))
    assert other.modes.frequencies[:12] == pytest.approx(one.modes.frequencies[:12], rel=1e-8)
    assert other.centre_of_mass == pytest.approx(one.centre_of_mass)


def test_turned_section_axes_are_another_spelling():
    """Axes turned by Q with matrices along them; against the turn, the beam is another one."""
    turn = Rotation.from_rotvec([0, 0, 0.6]).as_matrix()
    both = np.kron(np.eye(2), turn)
    plain = prismatic(L)
    axes = plain.axes @ turn
    turned = SectionTable(
        plain.positions, axes, both.T @ plain.stiffness @ both, both.T @ plain.inertia @ both
    )
    wrong = SectionTable(plain.positions, axes.swapaxes(1, 2), turned.stiffness, turned.inertia)
    a, b, c = (section_line("beam", table, 5) for table in (plain, turned, wrong))
    assert b.stiffness == pytest.approx(a.stiffness, rel=1e-9, abs=1e-9 * a.stiffness.max())
    assert b.mass == pytest.approx(a.mass, abs=1e-12)
    assert np.abs(c.stiffness - a.stiffness).max() > 1e-2 * a.stiffness.max()


def test_the_sign_of_a_coupling_turns_the_twist():
    flipped = COUPLED.copy()
    flipped[[3, 5], [5, 3]] *= -1
    flipped[[4, 5], [5, 4]] *= -1
    flipped[[0, 5], [5, 0]] *= -1
    force = np.array([0, 1.0, 0, 0, 0, 0])
    twists = [tip_motion(section_line("b", prismatic(stiffness=k), 5), force)[5] for k in (COUPLED, flipped)]
    assert twists[0] == pytest.approx(-twists[1])
    assert twists[0] != 0


def test_mass_centre_and_inertia_are_those_of_the_sections():
    line = section_line("beam", prismatic(L), 7)
    rigid = line.twists.T @ line.mass @ line.twists
    m, x, y = 3.0 * L, 0.03, -0.02
    assert line.total_mass == pytest.approx(m)
    assert rigid[3:, :3] == pytest.approx(m * cross_matrix(np.array([x, y, L / 2])), abs=1e-9)
    expected = L * OFFSET[3:, 3:] + m * L**2 / 3 * np.diag([1, 1, 0])
    expected[0, 2] = expected[2, 0] = -m * x * L / 2
    expected[1, 2] = expected[2, 1] = -m * y * L / 2
    assert rigid[3:, 3:] == pytest.approx(expected)


def test_a_plain_section_is_the_beam_element():
    """Timoshenko beams of both kinds, straight along z: one stiffness at the stations."""
    EA, EI, GJ, factor = 1e6, (30.0, 70.0), 20.0, 0.8
    points = np.linspace(0, 2.0, 6)[:, None] * np.array([0, 0, 1.0])
    K, _ = beam_matrices(
        points, EA=EA, EI=EI, GJ=GJ, mass_per_length=1.0, shear_factor=factor, orientation=(1.0, 0, 0)
    )
    shear = factor * EA / 2  # G = E / 2
    # Beam axes x, y, z are z, x, y of the section; I_y and I_z bend about y and z.
    stiffness = np.diag([shear, shear, EA, EI[1], EI[0], GJ])
    swapped = np.diag([shear, shear, EA, EI[0], EI[1], GJ])
    found = [
        section_line("beam", prismatic(2.0, 2, k, inertia(1.0, 0, 0, 0.01, 0.01)), 6).stiffness
        for k in (stiffness, swapped)
    ]
    K = K.toarray()
    near = [np.abs(each - K).max() / np.abs(K).max() for each in found]
    assert min(near) < 1e-9
    assert max(near) > 1e-6


@pytest.mark.slow
def test_the_bend_of_45_degrees_stands_where_it_is_published():
    """Dead load 600 on the tip of an arc of radius 100; [SimoVuQuoc1986], part I: (15.79, 47.23, 53.37)."""
    angles = np.linspace(0, np.pi / 4, 65)
    points = np.column_stack([100 * (1 - np.cos(angles)), 100 * np.sin(angles), 0 * angles])
    z = np.column_stack([np.sin(angles), np.cos(angles), 0 * angles])
    x = np.tile([0, 0, 1.0], (len(z), 1))
    EI, one = 1e7 / 12, np.ones((len(z), 1, 1))
    K = np.diag([5e6, 5e6, 1e7, EI, EI, EI])
    table = SectionTable(
        points, np.stack([x, np.cross(z, x), z], axis=2), one * K, one * inertia(1.0, 0, 0, 1e-2, 1e-2)
    )
    body = intrinsic_body(section_line("beam", table, 17), CLAMPED)
    clamp = Fixed(first="ground", second="beam.root")
    machine = System([body], [clamp], [DeadForce(at="beam.tip", force=(0, 0, 600.0))])
    tip = body.places(equilibrium(machine).solution.bodies["beam"])[1][0, -1]
    assert tip == pytest.approx([15.79, 47.23, 53.37], rel=0.01)


def test_a_free_line_flies_and_a_single_station_is_refused():
    body = intrinsic_body(section_line("beam", prismatic(L), 5), FREE)
    assert body.modes.n_rigid == 6
    with pytest.raises(ModelError, match=r"line 'beam': it needs at least two stations, its ends, not 1"):
        section_line("beam", prismatic(L), 1)
