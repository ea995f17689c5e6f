"""Constraint residuals of joints: what a displaced body opens, and what a run leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame
from supple.equations import joint_residuals
from supple.integrate import FixedStep, FloatingMotion, Run, Solution, Statistics
from supple.machine import GROUND, At, Ball, Placed, System
from supple.simulation import simulate

LIFT = np.array([0.0, 0.0, 0.25])


@pytest.fixture(scope="module")
def pendulum(rod):
    hinge = Ball(first=GROUND, second=At("rod", "left"))
    return System(bodies=(Placed(rod("rod", 1.0)),), joints=(hinge,), gravity=(0, 0, -9.81))


@pytest.fixture(scope="module")
def swing(pendulum):
    return simulate(pendulum, Run(duration=0.1, output_step=0.02, step=FixedStep(0.01)))


def test_a_run_keeps_its_joints_closed(pendulum, swing):
    residuals = joint_residuals(pendulum, swing)
    assert residuals.shape == (6, 3)
    assert np.abs(residuals).max() < 1e-9


def test_a_body_moved_away_opens_its_joint_by_as_much(pendulum, swing):
    moved = replace(swing.bodies["rod"], position=swing.bodies["rod"].position + LIFT)
    residuals = joint_residuals(pendulum, replace(swing, bodies={"rod": moved}))
    np.testing.assert_allclose(residuals - LIFT, 0.0, atol=1e-9)


def test_joints_see_the_interfaces_of_a_full_body(blade):
    """A ball joint with the ground at the tip opens by the tip's displacement."""
    full = FullBody(blade, MeanAxisFrame())
    hinge = Ball(first=GROUND, second=At("blade", "tip"))
    q = 0.01 * np.random.default_rng(2).standard_normal((3, full.n_coordinates))
    rest = np.zeros_like(q)
    frame = np.zeros((3, 3))
    motion = FloatingMotion(frame, np.tile(np.eye(3), (3, 1, 1)), q, frame, frame, rest, frame, frame, rest)
    solution = Solution(np.arange(3.0), {"blade": motion}, {}, Statistics())
    residuals = joint_residuals(System(bodies=(Placed(full),), joints=(hinge,)), solution)
    np.testing.assert_allclose(residuals, q @ blade.interface("tip").motion[:3].T, atol=1e-15)
