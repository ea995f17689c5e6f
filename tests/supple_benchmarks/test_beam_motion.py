"""Motion of the reference beam: conservation, rates, the spun-up beam of the literature."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import jax.numpy as jnp
import numpy as np
import pytest

from supple.errors import ConvergenceError, ModelError
from supple.machine.laws.spin_up import SpinUp
from supple_benchmarks.beam_motion import fly_beam, spin_up_beam
from supple_benchmarks.planar_beam import ROTATING_BEAM, BeamElements

# Soft enough that the steps below resolve every wave that carries energy.
SOFT_BEAM = replace(
    ROTATING_BEAM,
    axial_stiffness=5e3,
    shear_stiffness=5e3,
    bending_stiffness=500.0,
    rotary_inertia_per_length=0.5,
)


@cache
def arched_flight(step, rho_inf):
    """A beam arched smoothly, turning and drifting, let go for 2 s."""
    elements = BeamElements(SOFT_BEAM, 8)
    s = elements.arc_length / SOFT_BEAM.length
    start = elements.straight(0.0)
    start[:, 1] += 0.8 * np.sin(np.pi * s) ** 2
    start[:, 2] += 0.8 * np.pi / SOFT_BEAM.length * np.sin(2 * np.pi * s)
    spin = 1.5
    velocity = np.stack([0.3 - spin * start[:, 1], spin * (start[:, 0] - 5.0), spin + 0 * s], axis=-1)
    return fly_beam(elements, start, velocity, duration=2.0, step=step, rho_inf=rho_inf, tolerance=1e-12)


def test_free_flight_conserves_momentum():
    motion = arched_flight(0.01, 1.0)
    linear, angular = motion.linear_momentum(), motion.angular_momentum()
    np.testing.assert_allclose(
        linear, np.broadcast_to(linear[0], linear.shape), atol=1e-9 * abs(linear).max()
    )
    # The rule conserves linear momentum exactly, angular momentum at its order.
    assert abs(angular - angular[0]).max() < 1e-3 * abs(angular[0])


@pytest.mark.parametrize("invariant", ["energy", "angular_momentum"])
def test_free_flight_conserves_at_the_integrators_order(invariant):
    steps = np.array([0.01, 0.005, 0.0025])
    drifts = []
    for step in steps:
        values = getattr(arched_flight(step, 1.0), invariant)()
        drifts.append(abs(values - values[0]).max() / abs(values[0]))
    rate = np.polyfit(np.log(steps), np.log(drifts), 1)[0]
    assert rate > 1.8
    assert drifts[-1] < 1e-4


@pytest.mark.slow
def test_second_order_in_the_step():
    # Driven smoothly from rest: no initial jump spoils the rate with waves that the steps cannot resolve.
    def tip(step):
        law = SpinUp(1.0, rise_time=2.0)
        motion = spin_up_beam(SOFT_BEAM, law, duration=2.0, step=step, n_elements=4, tolerance=1e-12)
        return motion.configuration[-1, -1]

    tips = [tip(step) for step in (0.02, 0.01, 0.005, 0.0025)]
    gaps = [np.linalg.norm(coarse - fine) for coarse, fine in pairwise(tips)]
    rate = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(gaps), 1)[0]
    assert rate == pytest.approx(2.0, abs=0.15)


def test_numerical_damping_only_takes_energy_out():
    energy = arched_flight(0.02, 0.5).energy()
    assert energy.max() < 1.001 * energy[0]
    assert energy[-1] < 0.99 * energy[0]


@cache
def rotating_beam(speed, n_elements=12, step=0.01):
    return spin_up_beam(ROTATING_BEAM, SpinUp(speed), duration=20.0, step=step, n_elements=n_elements)


@pytest.mark.slow
def test_root_follows_the_law():
    motion = rotating_beam(6.0)
    law = np.array(
        [
            6.0 / 15.0 * (0.5 * t**2 + (15 / (2 * np.pi)) ** 2 * (np.cos(2 * np.pi * t / 15) - 1))
            if t <= 15
            else 6.0 * (t - 7.5)
            for t in motion.times
        ]
    )
    np.testing.assert_allclose(motion.root_angle, law, atol=1e-9)
    assert not motion.configuration[:, 0, :2].any()


@pytest.mark.parametrize(
    ("speed", "published"),
    [
        (6.0, -0.576),
        pytest.param(8.0, -0.726, marks=pytest.mark.slow),
        pytest.param(10.0, -0.858, marks=pytest.mark.slow),
        pytest.param(12.0, -0.972, marks=pytest.mark.slow),
    ],
)
def test_tip_lags_by_the_published_amount(speed, published):
    # At 6 rad/s -0.574 to -0.578 m near 6.76 s since [SimoVuQuoc1986]; other speeds: planar beam elements.
    motion = rotating_beam(speed)
    peak = motion.tip_transverse.argmin()
    assert motion.tip_transverse[peak] == pytest.approx(published, rel=4e-3)
    if speed == 6.0:
        assert motion.times[peak] == pytest.approx(6.76, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [6.0, 12.0])
def test_steady_extension_balances_the_centrifugal_force(speed):
    # u = rho A omega^2 L^3 / (3 EA): 5.143e-4 m at 6 rad/s, and rho A (omega L)^2 / EA < 1e-3 of it more,
    # for the stretched beam reaches further out.
    beam = ROTATING_BEAM
    motion = rotating_beam(speed, n_elements=6, step=0.005)
    expected = beam.mass_per_length * speed**2 * beam.length**3 / (3 * beam.axial_stiffness)
    assert motion.tip_axial[motion.times >= 16.0].mean() == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_spun_up_tip_converges_in_the_elements():
    peaks = np.array([rotating_beam(6.0, n, 0.02).tip_transverse.min() for n in (2, 4, 8, 16)])
    errors = abs(peaks[:-1] - peaks[-1])
    rate = -np.polyfit(np.log([2, 4, 8]), np.log(errors), 1)[0]
    assert rate > 3.0
    assert errors[-1] < 1e-5


def test_a_beam_that_starts_turning_at_full_speed_starts_in_rigid_rotation():
    motion = spin_up_beam(ROTATING_BEAM, lambda t: 0.5 + 2.0 * t, duration=0.01, step=0.01, n_elements=4)
    s = motion.elements.arc_length
    np.testing.assert_allclose(motion.configuration[0, :, 0], s * np.cos(0.5), atol=1e-14)
    np.testing.assert_allclose(np.hypot(*motion.velocity[0, :, :2].T), 2.0 * s, atol=1e-14)


def test_history_is_read_only():
    motion = spin_up_beam(ROTATING_BEAM, SpinUp(1.0), duration=0.1, step=0.05, n_elements=2)
    with pytest.raises(ValueError, match="read-only"):
        motion.configuration[0] = 0.0


@pytest.mark.parametrize(("duration", "step"), [(1.0, 0.0), (1.0, 2.0), (np.inf, 0.1)])
def test_time_grid_must_make_sense(duration, step):
    with pytest.raises(ModelError, match="0 < step <= duration"):
        spin_up_beam(ROTATING_BEAM, SpinUp(1.0), duration=duration, step=step)


def test_spectral_radius_must_lie_between_nought_and_one():
    with pytest.raises(ModelError, match=r"rho_inf is 1\.2"):
        spin_up_beam(ROTATING_BEAM, SpinUp(1.0), duration=1.0, step=0.1, rho_inf=1.2)


def test_start_must_have_a_row_for_each_node():
    elements = BeamElements(ROTATING_BEAM, 2)
    with pytest.raises(ModelError, match=r"initial velocity has shape \(2, 3\), not \(5, 3\)"):
        fly_beam(elements, elements.straight(0.0), np.zeros((2, 3)), duration=1.0, step=0.1)


def test_failed_step_names_its_time_and_the_remedy():
    with pytest.raises(
        ConvergenceError, match=r"no equilibrium at t = 1 s .* take a smaller step or rho_inf"
    ):
        spin_up_beam(ROTATING_BEAM, lambda t: 300.0 * jnp.square(t), duration=1.0, step=1.0, n_elements=4)
