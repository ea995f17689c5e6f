"""Steps and outputs too long for the motion, and joint forces that nothing damps: said with the number."""

from __future__ import annotations

import warnings

import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.equations.build_model import system_length
from supple.equations.checks.output_rate import hidden_vibration
from supple.errors import ConvergenceError, ResolutionWarning, ValidityError
from supple.integrate import (
    FixedStep,
    GeneralizedAlpha,
    Newmark,
    Run,
    Tolerances,
    Validity,
)
from supple.machine import (
    GROUND,
    At,
    Placed,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
)
from supple.results.run_summary import cost_numbers
from supple.simulation import simulate, simulate_batch

MASS, FREQUENCY, AMPLITUDE = 2.0, 36.0, 0.01
OMEGA = 2 * np.pi * FREQUENCY


def stops(time):
    return jnp.where(time < 0.5, time**3, jnp.nan)


def spinning(speed):
    """A free body about a principal axis: it turns by the same angle in each step."""
    top = RigidBody("top", 1.0, [0, 0, 0], np.diag([0.1, 0.2, 0.3]))
    return System((Placed(top, angular_velocity=[0, 0, speed]),))


def oscillator():
    """A mass on a rail and a spring of 0.5 m, let go 1 cm from its rest: 36 Hz."""
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"centre": [0, 0, 0]})
    rail = Prismatic(first=GROUND, second=At("ball", "centre"), axis=(1, 0, 0), name="rail")
    spring = SpringDamper(
        first=At("ball", "centre"),
        anchor=(-0.5, 0, 0),
        stiffness=MASS * OMEGA**2,
        rest_length=0.5 - AMPLITUDE,
    )
    return System((Placed(ball),), (rail,), (spring,))


@pytest.mark.parametrize(("speed", "warned"), [(30.0, True), (20.0, False)])
def test_the_turn_of_a_step_is_kept_and_warned_of(speed, warned):
    run = Run(0.2, 0.02)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        statistics = simulate(spinning(speed), run).statistics
    assert statistics.largest_turn == pytest.approx(speed * 0.02, rel=1e-9)
    assert cost_numbers(statistics)["largest turn in a step, rad"] == statistics.largest_turn
    assert [each.category for each in said] == [ResolutionWarning] * warned
    if warned:
        assert "fixed step of 0.02 is too long" in str(said[0].message)
        assert "a body rotates by 0.6 rad within it. Take 0.02 or less" in str(said[0].message)
        with pytest.raises(ValidityError, match=r"a body rotates by 0\.6 rad"):
            simulate(spinning(speed), Run(0.2, 0.02, validity=Validity(strict=True)))


@pytest.mark.slow
def test_the_local_error_of_a_step_is_kept():
    """Of x = A cos(w t) it is (beta - 1/6) h^3 w^3 A at most, over the machine's size."""
    h, system = 5e-4, oscillator()
    run = Run(0.05, h, method=Newmark(), tolerances=Tolerances(1e-10))
    found = simulate(system, run).statistics.largest_error
    jerk = AMPLITUDE * OMEGA**3
    assert found == pytest.approx((1 / 4 - 1 / 6) * h**3 * jerk / system_length(system), rel=0.02)
    (batch,) = simulate_batch([system], run).solutions
    assert batch.statistics.largest_error == pytest.approx(found, rel=1e-9)
    assert batch.statistics.largest_turn == pytest.approx(0.0, abs=1e-12)


def test_a_step_with_a_large_local_error_is_named():
    """Eight steps a period of a swing as large as the machine."""
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"centre": [0, 0, 0]})
    rail = Prismatic(first=GROUND, second=At("ball", "centre"), axis=(1, 0, 0), name="rail")
    spring = SpringDamper(
        first=At("ball", "centre"), anchor=(-3.0, 0, 0), stiffness=MASS * OMEGA**2, rest_length=2.0
    )
    step = 1 / FREQUENCY / 8
    run = Run(20 * step, step)
    with pytest.warns(ResolutionWarning, match=r"fixed step of .* is too long .* local error reaches"):
        simulate(System((Placed(ball),), (rail,), (spring,)), run)


def signal(times, frequency, slow=0.0):
    w = 2 * np.pi * frequency
    x = np.sin(w * times) + slow * np.sin(3 * times)
    v = w * np.cos(w * times) + 3 * slow * np.cos(3 * times)
    a = -(w**2) * np.sin(w * times) - 9 * slow * np.sin(3 * times)
    return (each[:, None] for each in (x, v, a))


@pytest.mark.parametrize("slow", [0.0, 5.0])
def test_velocities_give_away_a_vibration_between_outputs(slow):
    """36 Hz at 50 Hz looks like 14 Hz; beside a slow motion five times as large it is a fifth of it."""
    hidden = hidden_vibration(*signal(np.arange(0, 2, 0.02), 36.0, slow), 0.02)
    assert hidden.frequency / (2 * np.pi) == pytest.approx(36.0, rel=0.01)
    assert hidden.share == pytest.approx(1 / np.hypot(1, slow), rel=0.1)


def test_a_vibration_that_outputs_show_is_not_hidden():
    assert hidden_vibration(*signal(np.arange(0, 2, 0.002), 36.0), 0.002).share == 0.0


def test_outputs_too_sparse_are_named_with_the_frequency_and_the_step_needed():
    words = (
        r"output step of 0\.02 is .* body 'ball': its frame vibrates 3[56]\.?\d* times per unit of time; "
        r".* 0\.0028 or less"
    )
    with pytest.warns(ResolutionWarning, match=words):
        simulate(oscillator(), Run(1.0, 0.02, step=FixedStep(1e-3)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(oscillator(), Run(0.2, 0.0025, step=FixedStep(1e-3)))


@pytest.mark.parametrize("method", [GeneralizedAlpha(1.0), Newmark(), GeneralizedAlpha(0.8)])
def test_a_failure_names_the_method_that_damps_no_joint_force(method):
    """One iteration fails under any method; with joints, a method that damps none is the likely cause."""
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"hinge": [0.1, 0, 0]})
    hinge = Revolute(first=GROUND, second=At("ball", "hinge"), axis=(0, 1, 0), name="hinge")
    run = Run(1.0, 0.1, method=method, tolerances=Tolerances(residual=1e-12, max_iterations=1))
    system = System((Placed(ball, position=[-0.1, 0, 0]),), (hinge,), gravity=np.array([0.0, 0.0, -9.81]))
    with pytest.raises(ConvergenceError) as failed:
        simulate(system, run)
    damps = method == GeneralizedAlpha(0.8)
    assert ("with rho_inf = 1" in str(failed.value)) == (not damps)
    assert ("GeneralizedAlpha(0.8)" in str(failed.value)) == (not damps)


def test_a_law_that_stops_being_a_number_is_told_as_such():
    drive = PrescribedTranslation(
        first=GROUND, second=At("ball", "centre"), axis=(1, 0, 0), displacement=stops, name="drive"
    )
    ball = RigidBody("ball", MASS, [0, 0, 0], np.eye(3), {"centre": [0.1, 0, 0]})
    with pytest.raises(ConvergenceError, match=r"not numbers.*nan or infinity") as failed:
        simulate(System((Placed(ball),), (drive,)), Run(1.0, 0.1, method=GeneralizedAlpha(1.0)))
    assert "rho_inf" not in str(failed.value)
