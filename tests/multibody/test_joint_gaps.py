"""Joint gaps: what a displaced body opens, and what a run leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import MeanAxisFrame
from supple.errors import ModelError
from supple.integrate import FixedStep
from supple.multibody import GROUND, At, Ball, FullBody, Placed, System, joint_gaps, simulate

LIFT = np.array([0.0, 0.0, 0.25])


@pytest.fixture(scope="module")
def pendulum(rod):
    hinge = Ball(first=GROUND, second=At("rod", "left"))
    return System(bodies=(Placed(rod("rod", 1.0)),), joints=(hinge,), gravity=(0, 0, -9.81))


@pytest.fixture(scope="module")
def swing(pendulum):
    return simulate(pendulum, duration=0.1, output_step=0.02, step=FixedStep(0.01))


def test_a_run_keeps_its_joints_closed(pendulum, swing):
    gaps = joint_gaps(pendulum, swing)
    assert gaps.shape == (6, 3)
    assert np.abs(gaps).max() < 1e-9


def test_a_body_moved_away_opens_its_joint_by_as_much(pendulum, swing):
    moved = replace(swing.bodies["rod"], position=swing.bodies["rod"].position + LIFT)
    gaps = joint_gaps(pendulum, replace(swing, bodies={"rod": moved}))
    np.testing.assert_allclose(gaps - LIFT, 0.0, atol=1e-9)


def test_full_bodies_are_refused(blade, swing):
    system = System(bodies=(Placed(FullBody(blade, MeanAxisFrame())),))
    with pytest.raises(ModelError, match="joint gaps of the full body 'blade' are not available"):
        joint_gaps(system, swing)
