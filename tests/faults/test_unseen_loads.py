"""Loads and prescribed motions that steps jump over, or that jump themselves: named before the run."""

from __future__ import annotations

import warnings

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.equations.checks.rate_jumps import rate_jumps
from supple.equations.checks.step_resolution import missed_between_steps
from supple.errors import ModelError, ResolutionWarning, ValidityError
from supple.integrate import AdaptiveStep, FixedStep, Run, Validity
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Placed,
    PrescribedTranslation,
    Ramp,
    Scaled,
    Sine,
    SpinUp,
    Spline,
    System,
    Table,
    TimeFunction,
)
from supple.machine.laws.instants import instants_of_law
from supple.simulation import simulate, simulate_batch

MASS = 2.0
SPAN = (0.0, 1.0)


def pushed(force):
    """A free mass of 2 kg under a force along x."""
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"centre": [0, 0, 0]})
    law = Scaled([1.0, 0.0, 0.0], force)
    return System((Placed(ball),), loads=(DeadForce(body="ball", at="centre", force=law),))


def moved(law):
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"centre": [0, 0, 0]})
    drive = PrescribedTranslation(
        first=GROUND, second=At("ball", "centre"), axis=(1.0, 0, 0), displacement=law, name="drive"
    )
    return System((Placed(ball),), (drive,))


@pytest.mark.parametrize("steps", [6, 12, 50])
def test_straight_lines_miss_a_sine_by_the_square_of_its_step(steps):
    """(2 pi / n)^2 / 8 of the amplitude, at the middle of a step over a crest."""
    missed = missed_between_steps(Sine(3.0, 1.0), 0.0, 1 / steps, 5 * steps, np.zeros(0))
    assert missed.share == pytest.approx((2 * np.pi / steps) ** 2 / 8, rel=0.3)


def test_a_motion_whose_acceleration_is_zero_at_even_times_is_named_too():
    """Of 128 Hz, over a second: zero at all multiples of 1/256 s."""
    run = Run(1.0, 0.1, step=FixedStep(0.01), validity=Validity(strict=True))
    with pytest.raises(ValidityError, match="the acceleration of its prescribed motion"):
        simulate(moved(Sine(1e-3, 128.0)), run)


def test_a_sine_of_500_hz_on_steps_of_2_ms_is_named():
    """Seen at the ends of steps it is zero."""
    words = r"'ball': within a step of 0\.002, .* shortest time is 0\.002: .*Take a step of 0\.0002,"
    with pytest.warns(ResolutionWarning, match=words):
        solution = simulate(pushed(Sine(1.0, 500.0)), Run(0.02, 0.01, step=FixedStep(2e-3)))
    np.testing.assert_allclose(solution.bodies["ball"].position, 0, atol=1e-15)
    strict = Run(0.02, 0.01, step=FixedStep(2e-3), validity=Validity(strict=True))
    with pytest.raises(ValidityError, match="alias"):
        simulate(pushed(Sine(1.0, 500.0)), strict)


def test_the_case_of_a_batch_that_varies_fastest_is_looked_at():
    cases = [pushed(Sine(1.0, frequency)) for frequency in (5.0, 500.0)]
    with pytest.warns(ResolutionWarning, match="shortest time is 0.002: the steps"):
        simulate_batch(cases, Run(0.02, 0.01, step=FixedStep(2e-3)))


@pytest.mark.slow
def test_a_load_that_steps_see_passes():
    """Twenty steps a period; and a jump that a step meets."""
    for law in (Sine(1.0, 25.0), lambda t: jnp.where(t < 0.01, 0.0, 1.0), Ramp(1.0, 0.02), 3.0):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            simulate(pushed(law), Run(0.02, 0.01, step=FixedStep(2e-3)))


TRIANGLE = Table([0.0, 0.4103, 0.4108, 0.4113, 1.0], [0.0, 0.0, 100.0, 0.0, 0.0])
PULSES = {
    "table": (TRIANGLE, 0.5 * 1e-3 * 100.0),
    "function": (TimeFunction(lambda t: 100.0 * jnp.exp(-(((t - 0.41) / 1e-3) ** 2))), 0.1 * np.sqrt(np.pi)),
    "rectangle": (TimeFunction(lambda t: jnp.where((t > 0.41) & (t < 0.4107), 100.0, 0.0)), 0.07),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", PULSES)
def test_a_pulse_between_fixed_steps_is_named(kind):
    law, _ = PULSES[kind]
    with pytest.warns(ResolutionWarning, match=r"DeadForce on .*within a step of 0\.01, at t = 0\.41?"):
        simulate(pushed(law), Run(1.0, 0.5, step=FixedStep(0.01)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", PULSES)
def test_adaptive_steps_meet_a_pulse(kind):
    """Momentum is the impulse. Left to their errors alone they would jump over it: nothing moves before."""
    law, impulse = PULSES[kind]
    steps = AdaptiveStep(first=1e-4, largest=0.2, tolerance=1e-9)
    solution = simulate(pushed(law), Run(1.0, 0.5, step=steps))
    assert MASS * solution.bodies["ball"].velocity[-1, 0] == pytest.approx(impulse, rel=0.02)
    (batch,) = simulate_batch([pushed(law)], Run(1.0, 0.5, step=steps)).solutions
    np.testing.assert_allclose(batch.bodies["ball"].velocity, solution.bodies["ball"].velocity, rtol=1e-9)
    np.testing.assert_array_equal(batch.times, [0.0, 0.5, 1.0])


def test_laws_state_the_instants_at_which_they_break():
    np.testing.assert_array_equal(instants_of_law(TRIANGLE, *SPAN), [0.4103, 0.4108, 0.4113])
    np.testing.assert_array_equal(instants_of_law(Ramp(1.0, 0.5), *SPAN), [0.5])
    np.testing.assert_array_equal(instants_of_law(SpinUp(1.0, 0.3), *SPAN), [0.3])
    assert instants_of_law(Sine(1.0, 2.0), *SPAN).size == 0
    in_line = Table([0.0, 0.2, 0.4, 1.0], [0.0, 1.0, 2.0, 0.0])
    np.testing.assert_array_equal(instants_of_law(Scaled([1.0, 0, 0], in_line), *SPAN), [0.4])
    rows = np.linspace(0.0, 1.0, 9)
    np.testing.assert_array_equal(instants_of_law(Spline(rows, np.sin(6 * rows)), *SPAN), rows[2:-2])


def test_a_jump_of_a_function_is_closed_in():
    (before, after) = instants_of_law(TimeFunction(lambda t: jnp.where(t < 1 / 3, 0.0, 2.0)), *SPAN)
    assert before < 1 / 3 <= after
    assert after - before < 1e-10


SPEED = lambda t: jnp.where(t < 0.3, 0.0, 2.0 * (t - 0.3))  # noqa: E731
ACCELERATION = lambda t: jnp.where(t < 0.3, 0.0, 1.5 * (t - 0.3) ** 2)  # noqa: E731


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            TimeFunction(lambda t: jnp.where(t < 0.3, 0.0, 0.1)),
            r"the prescribed motion jumps by 0\.1 at t = 0\.3",
        ),
        (TimeFunction(SPEED), r"the speed of its prescribed motion jumps by 2 at t = 0\.3:"),
        (TimeFunction(ACCELERATION), r"the acceleration of its prescribed motion jumps by 3 at t = 0\.3:"),
        (
            Table([0.0, 0.25, 0.5, 1.0], [0.0, 0.0, 1.0, 3.0]),
            r"the speed of its prescribed motion jumps by 4 at t = 0\.25:",
        ),
    ],
    ids=["motion", "speed", "acceleration", "table"],
)
def test_a_motion_that_jumps_is_named(law, words):
    run = Run(1.0, 0.1, step=FixedStep(0.01), validity=Validity(strict=True))
    with pytest.raises(ValidityError, match=f"joint 'drive': {words}"):
        simulate(moved(law), run)


@pytest.mark.parametrize(
    "law",
    [
        Ramp(1.0, 0.5),
        SpinUp(6.0, 0.4),
        Sine(1.0, 3.0),
        Spline(np.linspace(0, 1, 17), np.sin(5 * np.linspace(0, 1, 17))),
        TimeFunction(lambda t: jnp.sin(20 * t) + t**2),
        TimeFunction(lambda t: 0.0 * t),
    ],
    ids=["ramp", "spin-up", "sine", "spline", "function", "nothing"],
)
def test_smooth_motions_do_not_jump(law):
    found, _, _ = rate_jumps(law, *SPAN)
    assert not found


def test_a_motion_that_ends_before_the_run_is_refused():
    law = Spline([0.0, 0.5, 0.9], [0.0, 0.1, 0.3])
    with pytest.raises(ModelError, match=r"joint 'drive': its table ends at t = 0\.9, before the run ends"):
        simulate(moved(law), Run(1.0, 0.1))
    late = Spline([0.1, 0.5, 2.0], [0.0, 0.1, 0.3])
    with pytest.raises(
        ModelError, match=r"joint 'drive': its table begins at t = 0\.1, after the run begins"
    ):
        simulate(moved(late), Run(1.0, 0.1))
