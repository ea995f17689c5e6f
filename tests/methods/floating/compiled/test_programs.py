"""Which of the two programs marches, and that they march alike."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import numpy as np
import pytest
from fixtures.runs_on_disk import bits

from supple.body import RigidBody
from supple.equations.compiler_options import STARTING
from supple.integrate import AdaptiveStep, FixedStep, GeneralizedAlpha, Run
from supple.machine import GROUND, At, Ball, Placed, System
from supple.methods.floating.compiled import engine
from supple.methods.floating.compiled.elimination import ByLapack, ByLoops
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.programs import COMPILED_MARCH, QUICK_MARCH, march_for
from supple.methods.floating.compiled.time_step import march
from supple.simulation import simulate

RUN = Run(0.4, 0.1, FixedStep(0.01), method=GeneralizedAlpha(0.8))


@pytest.fixture
def pendulum():
    bob = RigidBody("bob", 2.0, [0, 0, 0], np.diag([0.15, 0.2, 0.25]), {"hinge": [0, 0, 0.8]})
    ball = Ball(first=GROUND, second=At("bob", "hinge"))
    return System((Placed(bob, position=(0.0, 0.0, -0.8)),), (ball,), gravity=(3.0, 1.0, -9.81))


def test_the_length_of_a_run_decides(pendulum):
    model, _ = initial_state(pendulum, 0.0, 0.01)
    assert march_for(model, steps=1e3) is QUICK_MARCH
    assert march_for(model, steps=1e6) is COMPILED_MARCH


def test_a_run_has_the_same_bits_whatever_its_process_did_before(pendulum):
    first = simulate(pendulum, RUN)
    simulate(pendulum, replace(RUN, step=AdaptiveStep(1e-7, 0.1)))  # as long as millions of these steps
    assert bits(simulate(pendulum, RUN)) == bits(first)


@pytest.mark.parametrize(
    ("elimination", "is_one"), [(ByLoops(), True), pytest.param(ByLapack(), False, marks=pytest.mark.slow)]
)
def test_the_march_is_one_function_of_machine_code(pendulum, elimination, is_one):
    """What its loop would be kept from by a call of a library: of LAPACK, or of one for products."""
    model, start = initial_state(pendulum, 0.0, 0.01)
    lowered = jax.jit(partial(march, elimination)).lower(model, controls(RUN), start, RUN.times)
    text = lowered.compile(compiler_options=STARTING).as_text()
    whole = text[text.index("ENTRY") :]
    assert ("xla_cpu_small_call" in whole and " while(" not in whole) == is_one


def marched_by(program, system, run, monkeypatch, **how):
    monkeypatch.setattr(engine, "march_for", lambda *_: program)
    return simulate(system, run, **how)


def assert_equal(one, other, tolerance):
    for item in ("position", "rotation", "velocity", "angular_velocity"):
        own, exact = (getattr(each.bodies["bob"], item) for each in (one, other))
        np.testing.assert_allclose(own, exact[-len(own) :], rtol=0, atol=tolerance * np.abs(exact).max())


def test_both_march_alike(pendulum, monkeypatch):
    quick, other = (marched_by(own, pendulum, RUN, monkeypatch) for own in (QUICK_MARCH, COMPILED_MARCH))
    assert_equal(quick, other, 1e-10)
    assert quick.statistics.iterations == other.statistics.iterations


@pytest.mark.parametrize("program", [QUICK_MARCH, COMPILED_MARCH], ids=["quick", "compiled well"])
def test_a_run_goes_on_by_the_program_that_it_was_begun_with(pendulum, monkeypatch, program):
    whole = marched_by(program, pendulum, RUN, monkeypatch)
    half = marched_by(program, pendulum, replace(RUN, duration=0.2), monkeypatch)
    refused = COMPILED_MARCH if program is QUICK_MARCH else QUICK_MARCH

    def refuse(*_):
        raise AssertionError("the other program marched")

    monkeypatch.setattr(refused, "compiled", refuse)
    assert_equal(marched_by(refused, pendulum, RUN, monkeypatch, resume=half), whole, 0.0)
