"""All steps of a run, found again after it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import RigidBody
from supple.integrate import AdaptiveStep, FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.methods.floating.compiled.every_step import every_step
from supple.simulation import simulate

RUN = Run(duration=1.0, output_step=0.1, step=FixedStep(0.02), tolerances=Tolerances(residual=1e-10))


@pytest.fixture(scope="module")
def pendulum():
    """A rod that swings from the horizontal."""
    rod = RigidBody("rod", 1.0, [0.5, 0, 0], np.diag([0.001, 0.1, 0.1]), {"eye": [0, 0, 0]})
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "eye"), axis=(0, 1, 0))
    return System((Placed(rod),), (hinge,), gravity=(0, 0, -9.81))


def is_the_run_at_its_outputs(steps, solution):
    told = steps.solution.at(steps.outputs)
    np.testing.assert_array_equal(told.times, solution.times)
    for name, array in solution.bodies["rod"].arrays().items():
        np.testing.assert_allclose(told.bodies["rod"].arrays()[name], array, atol=1e-9)
    np.testing.assert_allclose(told.multipliers["hinge"], solution.multipliers["hinge"], atol=1e-7)


def test_steps_between_the_outputs(pendulum):
    solution = simulate(pendulum, RUN)
    steps = every_step(pendulum, RUN, solution)
    np.testing.assert_allclose(steps.solution.times, np.linspace(0, 1, 51), atol=1e-12)
    is_the_run_at_its_outputs(steps, solution)


def test_steps_of_their_own_size(pendulum):
    run = replace(RUN, step=AdaptiveStep(first=1e-3, largest=0.05, tolerance=1e-5))
    solution = simulate(pendulum, run)
    steps = every_step(pendulum, run, solution)
    assert len(steps.solution.times) == solution.statistics.steps + 1
    assert np.ptp(np.diff(steps.solution.times)) > 1e-3
    is_the_run_at_its_outputs(steps, solution)


def test_a_run_whose_outputs_are_its_steps_is_not_made_again(pendulum):
    run = replace(RUN, output_step=0.02)
    solution = simulate(pendulum, run)
    assert every_step(pendulum, run, solution).solution is solution
