"""The references themselves: measured orders, closed forms, conservation, published numbers."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.section_tables import COUPLED

from supple_benchmarks.beam_statics import bend_beam
from supple_benchmarks.planar_beam import ROTATING_BEAM, BeamElements
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.references.lateral_buckling import lateral_buckling_load
from supple_benchmarks.references.rod import Rod
from supple_benchmarks.references.section_beam import SectionAt, bent_tip, clamped_rest
from supple_benchmarks.references.simo_reissner import Beam, bent, energies, straight_beam, swung

LENGTH = 10.0
STIFFNESS = np.array([1e4, 5e3, 5e3, 80.0, 100.0, 150.0])
N_ELEMENTS = 8


def cantilever(n_elements=N_ELEMENTS):
    return straight_beam(LENGTH, n_elements, STIFFNESS, mass=1.2, inertia=np.array([0.02, 0.01, 0.01]))


def at_the_tip(beam, *load):
    loads = np.zeros((len(beam.positions), 6))
    loads[-1] = load
    return loads


@pytest.mark.slow
@pytest.mark.parametrize("axis", [4, 5])
def test_an_end_moment_rolls_the_beam_up(axis):
    """M = pi E I / L bends half a circle, about either axis; the nodes approach it with fourth order."""
    radius = LENGTH / np.pi
    errors = []
    moment = np.pi * STIFFNESS[axis] / LENGTH
    for n in (4, 8):
        x, R = bent(cantilever(n), at_the_tip(cantilever(n), *(moment * np.eye(6)[axis])), n_steps=5)
        across = {4: -x[-1, 2], 5: x[-1, 1]}[axis]
        errors.append(abs(across / (2 * radius) - 1))
    assert errors[1] < 1e-4
    assert R[-1, 0, 0] == pytest.approx(-1, abs=1e-5)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.15)


@pytest.mark.slow
def test_an_end_torque_twists_the_beam():
    _, R = bent(cantilever(), at_the_tip(cantilever(), 0, 0, 0, 80.0 * 1.5 / LENGTH, 0, 0))
    c, s = np.cos(1.5), np.sin(1.5)
    np.testing.assert_allclose(R[-1], [[1, 0, 0], [0, c, -s], [0, s, c]], atol=1e-5)


@pytest.mark.slow
def test_the_bend_of_45_degrees():
    """Bathe and Bolourchi (1979); the published tip is one of eight straight elements, within 1 %."""
    n, radius, E = N_ELEMENTS, 100.0, 1e7
    angle = np.linspace(0, np.pi / 4, 2 * n + 1)
    zero = 0 * angle
    nodes = radius * np.stack([np.sin(angle), 1 - np.cos(angle), zero], axis=1)
    along, inward = [np.cos(angle), np.sin(angle), zero], [-np.sin(angle), np.cos(angle), zero]
    axes = np.stack([np.transpose(along), np.transpose(inward), np.tile([0, 0, 1], (2 * n + 1, 1))], axis=2)
    beam = Beam(nodes, axes, E * np.array([1, 1 / 2, 1 / 2, 1 / 12, 1 / 12, 1 / 12]))
    x, _ = bent(beam, at_the_tip(beam, 0, 0, 600.0, 0, 0, 0), n_steps=8)
    np.testing.assert_allclose(x[-1, [1, 0, 2]], [15.79, 47.23, 53.37], rtol=1e-2)


@pytest.mark.slow
def test_in_a_plane_it_is_the_planar_beam():
    """Two codes, one of angles and one of rotation matrices."""
    planar = ROTATING_BEAM
    EA, GA, EI = planar.axial_stiffness, planar.shear_stiffness, planar.bending_stiffness
    beam = straight_beam(LENGTH, N_ELEMENTS, [EA, GA, GA, EI, EI, EI])
    load = np.array([-300.0, 500.0, -200.0])
    x, _ = bent(beam, at_the_tip(beam, load[0], load[1], 0, 0, 0, load[2]))
    expected = bend_beam(BeamElements(planar, N_ELEMENTS), load)
    np.testing.assert_allclose(x[:, :2], expected[:, :2], atol=2e-4 * LENGTH)


def test_both_planar_beams_follow_the_elastica():
    """Slender enough that stretch and shear are 1e-6 of the deflection."""
    EI, force = 150.0, 5.0 * 150.0 / LENGTH**2
    along, across, angle = elastica(EI, LENGTH, force)
    assert angle > 1
    beam = straight_beam(LENGTH, N_ELEMENTS, [1e7, 1e7, 1e7, EI, EI, EI])
    x, R = bent(beam, at_the_tip(beam, 0, force, 0, 0, 0, 0))
    np.testing.assert_allclose(x[-1], [along, across, 0], atol=1e-3)
    assert np.arctan2(R[-1, 1, 0], R[-1, 0, 0]) == pytest.approx(angle, abs=2e-4)


def test_the_elastica_begins_as_a_cubic_and_ends_along_the_force():
    along, across, angle = elastica(2.0, 3.0, 1e-3)
    assert across == pytest.approx(1e-3 * 3.0**3 / (3 * 2.0), rel=1e-5)
    assert angle == pytest.approx(1e-3 * 3.0**2 / (2 * 2.0), rel=1e-5)
    assert along == pytest.approx(3.0 - 3 / 5 * across**2 / 3.0, rel=1e-9)
    assert elastica(2.0, 3.0, 10.0)[2] == pytest.approx(np.pi / 2, abs=0.01)


def test_lateral_buckling_of_a_thin_blade():
    assert lateral_buckling_load(4.0, 4e9, 9.0, 2.0) == pytest.approx(4.0126 * 6.0 / 4.0, rel=1e-5)


def pushed(step, n_steps, rho_inf):
    """A push of 0.4 s at the tip along y and z, then free motion; steps of one compiled length."""
    time = step * np.arange(n_steps + 1)
    pulse = np.where(time < 0.4, np.sin(np.pi * time / 0.4) ** 2, 0.0)
    return swung(cantilever(4), pulse[:, None] * [0.0, 60.0, 40.0], step=step, rho_inf=rho_inf)


@pytest.mark.slow
def test_motion_is_of_second_order_and_keeps_its_energy():
    """Three steps' lengths to the same instant; without damping the energy varies as their square."""
    n, beam = 80, cantilever(4)
    tips, drifts = [], []
    for part in (1, 2, 4):
        x, R, v = pushed(0.8 / n * 4 / part, n, 1.0)
        tips.append(x[n * part // 4, -1])
        after = range(1 + n * part // 8, n * part // 4 + 1, part)
        totals = [sum(energies(beam, x[i], R[i], v[i])) for i in after]
        drifts.append(np.ptp(totals) / np.mean(totals))
    rate = np.log2(np.linalg.norm(tips[0] - tips[1]) / np.linalg.norm(tips[1] - tips[2]))
    assert rate == pytest.approx(2, abs=0.3)
    assert np.abs(tips[2][1:]).min() > 0.05 * LENGTH
    assert np.log2(drifts[0] / drifts[2]) / 2 > 1.7
    assert drifts[2] < 5e-3


@pytest.mark.slow
def test_a_small_push_sounds_the_lowest_frequency():
    """omega = 1.8751^2 sqrt(E I / rho A L^4); shear, stretch and rotary inertia lower it a little."""
    omega = 1.8751041**2 * np.sqrt(STIFFNESS[4] / (1.2 * LENGTH**4))
    step = 2 * np.pi / omega / 40
    force = np.zeros((81, 3))
    # Of the shape of half a period: higher modes hardly answer.
    force[:21, 2] = 1e-4 * np.sin(np.pi * np.arange(21) / 20) ** 2
    w = swung(cantilever(4), force, step=step, rho_inf=1.0)[0][30:, -1, 2]
    # w'' = -omega^2 w between samples: w_(i-1) + w_(i+1) = 2 cos(omega h) w_i.
    cosine = (w[1:-1] @ (w[:-2] + w[2:])) / (2 * w[1:-1] @ w[1:-1])
    # The rule's own period error at this step is (omega h)^2 / 12.
    own = omega * step * (1 - (omega * step) ** 2 / 12)
    assert np.arccos(cosine) == pytest.approx(own, rel=0.02)


@pytest.mark.slow
def test_the_rod_in_a_plane_is_the_elastica():
    stiff = Rod(2.0, (1e9, 1e9, 1e9, 5.0, 3.0, 7.0))
    for axis, bending in ((2, 3.0), (1, 7.0)):
        force = 6.0 * bending / 2.0**2
        place, _ = stiff.tip(force * np.eye(3)[axis])
        along, across, _ = elastica(bending, 2.0, force)
        np.testing.assert_allclose(place[[0, axis]], [along, across], atol=1e-6)


def test_a_force_that_follows_the_rods_tip_is_the_dead_one_it_ends_as():
    rod = Rod(LENGTH, STIFFNESS, (0.0, 0.05, 0.1))
    place, turn = rod.tip_followed([0.0, 1.2, 0.9])
    np.testing.assert_allclose(rod.tip(turn @ [0.0, 1.2, 0.9])[0], place, atol=1e-7)


def test_the_rod_stretches_and_shears():
    place, _ = Rod(1.0, (4.0, 5.0, 1e9, 1e9, 1e9, 1e9)).tip([0.4, 1.0, 0.0])
    np.testing.assert_allclose(place, [1.1, 0.2, 0.0], atol=1e-7)


def test_an_exact_section_beam_is_the_linear_one_under_a_small_force():
    """By an elastica too: bending alone, beside the rows of another reference."""
    stiffness, force = COUPLED, np.array([2.0, -3.0, 1.0])

    def section(_s):
        return SectionAt(np.eye(3), stiffness, np.eye(6))

    linear = clamped_rest(section, [0, 2.0, 4.0], np.zeros(3), np.append(force, np.zeros(3)))[:6]
    assert bent_tip(stiffness, 4.0, 1e-4 * force) * 1e4 == pytest.approx(linear, rel=1e-4, abs=1e-8)
    along, across, turn = elastica(1.0, 1.0, 2.0)
    tip = bent_tip(np.diag([1e8, 1e8, 1e8, 1.0, 1.0, 1.0]), 1.0, (0, 2.0, 0))
    assert tip[[1, 2, 3]] == pytest.approx([across, along - 1, -turn], rel=1e-6)
