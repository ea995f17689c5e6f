"""What a report says of the start: velocities that come from drives, and the swing from gravity."""

from __future__ import annotations

import numpy as np
import pytest

from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    ConstantRate,
    Fixed,
    FollowerForce,
    Penalty,
    Placed,
    PrescribedRotation,
    SphereOnPlane,
    System,
)
from supple.results import summarize
from supple.results.run_start import _held, first_swing, start_lines
from supple.simulation import equilibrium, simulate

pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.ResolutionWarning")


def test_the_first_swing_of_closed_forms():
    t = np.linspace(0, 20, 401)
    share, row = first_swing(1 - np.cos(t))
    assert (share, t[row]) == (pytest.approx(1.0, abs=1e-3), pytest.approx(np.pi, abs=0.03))
    assert first_swing(1 - np.exp(-t)) is None  # without a swing
    assert first_swing(np.abs(np.sin(t)) * t) is None  # it grows later
    assert first_swing(0.1 * (1 - np.cos(t)) + t**2 / 400) is None
    assert first_swing(0 * t) is None


@pytest.mark.slow
def test_a_strip_that_begins_to_hang_swings_and_one_at_rest_does_not(clamped_blade):
    clamp = Fixed(name="clamp", first=GROUND, second=At("blade", "root"))
    system = System([clamped_blade], [clamp], gravity=(0, 0, -0.01))
    run = Run(4.0, 0.02, FixedStep(0.02))
    numbers = summarize(system, simulate(system, run))
    swing = numbers["start"]["swings from gravity"]["blade"]
    assert swing["share of largest"] > 0.9
    # Half a period of the lowest mode of a cantilever: 1.875^2 sqrt(E I / m) / L^2 = 2.03 rad/s.
    assert swing["at time"] == pytest.approx(np.pi / 2.03, abs=0.1)
    (line,) = start_lines(numbers)
    assert 'start at rest: start = "equilibrium"' in line
    found = equilibrium(system).system
    assert list(start_lines(summarize(found, simulate(found, run)))) == []


def test_a_body_that_is_not_held_does_not_swing_from_gravity(rod):
    """Its joints lead to the ground through another body; contacts of moving bodies are impacts."""
    bars = [rod("bar", 1.0), rod("other", 1.0), rod("free", 1.0)]
    joints = [Fixed(first="other.left", second="bar.left"), Fixed(first="ground", second="other.right")]
    stiff, origin = Penalty(stiffness=1e5), (0.0, 0.0, 0.0)
    wheel = SphereOnPlane(first="free.left", axis=(0, 0, 1), anchor=origin, penalty=stiff)
    system = System(bars, joints, [wheel, FollowerForce(first="free.right", force=(0, 0, 1))])
    assert _held(system, is_moving=True) == {"ground", "bar", "other"}
    assert _held(system, is_moving=False) == {"ground", "bar", "other", "free"}


def test_bodies_that_take_the_velocity_of_their_drive_are_named(rod):
    drive = PrescribedRotation(
        name="drive", first=GROUND, second=At("bar", "left"), axis=(0, 0, 1), angle=ConstantRate(2.0)
    )
    bar = Placed(rod("bar", 1.0), position=[0.5, 0, 0])
    system = System([bar, rod("stone", 1.0)], [drive])
    numbers = summarize(system, simulate(system, Run(0.02, 0.01)))
    (taken,) = numbers["start"]["velocities taken"]
    assert taken == {"body": "bar", "speed": pytest.approx(1.0), "angular speed": pytest.approx(2.0)}
    (line,) = start_lines(numbers)
    assert line.endswith("'bar' (speed 1, angular speed 2 rad per time)")
