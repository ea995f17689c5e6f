"""Steps that end without a last evaluation: all the same, their residual is below the tolerance."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.equations.balance import balance
from supple.equations.configuration import SystemMotion
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Ball, DeadForce, Placed, SpringDamper, System, Table
from supple.methods.floating.compiled.contraction import (
    MEASURED_EVERY,
    Contraction,
    new_contraction,
    no_contraction,
    predicted_to_converge,
)
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.programs import COMPILED_MARCH

STEP, N_STEPS, TOLERANCE = 1e-3, 64, 1e-6


def rod(name):
    inertia = np.diag([1e-2, 0.2, 0.2])
    return RigidBody(name, 2.0, [0.5, 0.0, 0.0], inertia, {"near": [0.0, 0, 0], "far": [1.0, 0, 0]})


def double_pendulum(*loads):
    return System(
        (Placed(rod("upper")), Placed(rod("lower"), position=[1.0, 0, 0], rotation=[0, 0.4, 0.3])),
        (
            Ball(first=GROUND, second=At("upper", "near"), name="top"),
            Ball(first=At("upper", "far"), second=At("lower", "near"), name="middle"),
        ),
        loads,
        gravity=(0.0, 0.0, -9.81),
    )


def marched(system):
    """The model, its states behind every step, and their residuals in parts of the largest term, (t,)."""
    model, start = initial_state(system, 0.0, STEP)
    run = Run(1.0, STEP, step=FixedStep(STEP), tolerances=Tolerances(TOLERANCE))
    stops = STEP * np.arange(1, N_STEPS + 1)
    _, states = COMPILED_MARCH(model, controls(run), start, stops)
    names = ("time", "configuration", "velocity", "acceleration", "multipliers")
    motions = SystemMotion(*(getattr(states, name) for name in names))
    terms = jax.jit(jax.vmap(lambda motion: balance(model, motion)._replace(linearization=())))(motions)

    def sizes(term):  # forces and moments apart, over the bodies
        parts = np.asarray(term).reshape(N_STEPS, -1, 2, 3)
        return np.sqrt((parts**2).sum(axis=(1, 3)))

    largest = np.max([sizes(term) for term in (terms.inertia, terms.applied, terms.joint)], axis=0)
    return states, (sizes(terms.residual) / largest).max(axis=1)


def seen(states):
    """Steps whose last iterate was evaluated: others know a residual that is not good enough."""
    return np.asarray(states.relative_residual).max(axis=1) <= TOLERANCE


@pytest.mark.slow
def test_most_steps_of_a_smooth_machine_are_not_evaluated_and_good_all_the_same():
    states, residuals = marched(double_pendulum())
    assert np.mean(~seen(states)) > 0.8
    assert residuals.max() < 0.1 * TOLERANCE


@pytest.mark.slow
def test_a_load_that_jumps_is_seen():
    """By ten thousand times the weight: the residual to correct is larger than any that was measured."""
    times = np.array([0.0, 0.0299, 0.0301, 1.0])
    force = np.array([[0.0, 0, 0], [0, 0, 0], [0, 1e6, 0], [0, 1e6, 0]])
    jumping = double_pendulum(DeadForce(body="lower", at="far", force=Table(times, force)))
    states, residuals = marched(jumping)
    assert seen(states)[29:31].all()
    assert np.mean(~seen(states)) > 0.3
    assert residuals.max() <= TOLERANCE


@pytest.mark.slow
def test_force_elements_may_have_kinks_and_are_always_evaluated():
    spring = SpringDamper(
        first=GROUND, second=At("lower", "far"), anchor=(2.0, 1.0, 0.0), stiffness=50.0, rest_length=0.5
    )
    states, residuals = marched(double_pendulum(spring))
    assert seen(states).all()
    assert residuals.max() < TOLERANCE


@pytest.mark.parametrize(
    ("size", "step", "phase", "expected"),
    [
        (1e3, 0.1, 1, True),
        (1e2, 0.1, 1, True),
        (1.55e3, 0.1, 1, True),  # 4e-3 (1.55)^2 = 0.96e-2, and the margin is 100
        (1.6e3, 0.1, 1, False),
        (1e3, 0.11, 1, False),  # a longer step
        (1e3, 0.1, 0, False),  # due to be measured
        (np.nan, 0.1, 1, False),
    ],
)
def test_the_residual_grows_with_the_square_of_the_one_before(size, step, phase, expected):
    known = Contraction(before=1e3, after=4e-3, step=0.1, phase=phase)
    assert bool(predicted_to_converge(known, jnp.asarray(size), jnp.asarray(step))) is expected


def test_a_residual_unlike_that_measured_is_seen():
    known = Contraction(before=1e3, after=1e-9, step=0.1, phase=1)
    assert predicted_to_converge(known, jnp.asarray(1.9e3), jnp.asarray(0.1))
    assert not predicted_to_converge(known, jnp.asarray(2.1e3), jnp.asarray(0.1))


def test_nothing_is_predicted_before_something_was_measured():
    known = no_contraction()._replace(phase=1, step=0.1)
    assert not predicted_to_converge(known, jnp.asarray(1e-9), jnp.asarray(0.1))


@pytest.mark.parametrize(
    ("corrections", "evaluated", "before"),
    [(1, True, 1e2), (1, False, 1e3), (0, True, 1e3), (2, True, 0.0), (3, True, 0.0)],
)
def test_only_a_step_of_one_correction_that_was_evaluated_tells(corrections, evaluated, before):
    known = Contraction(1e3, 1e-4, 0.1, MEASURED_EVERY - 1)
    after = new_contraction(
        known, jnp.array([1e2, 1e-5]), jnp.asarray(0.05), corrections, jnp.asarray(evaluated)
    )
    assert float(after.before) == before
    assert float(after.phase) == 0
    assert float(after.step) == (0.05 if before == 1e2 else 0.1)
