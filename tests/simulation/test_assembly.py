"""Machines put together: closed forms of a triangle, what cannot fit, what stays as it was."""

from __future__ import annotations

import numpy as np
import pytest

from supple.equations import joint_residuals
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, ConstantRate, Placed, PrescribedRotation, Revolute, System
from supple.simulation import assemble, simulate

Z = (0.0, 0.0, 1.0)
pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")


def triangle(rod, lengths=(3.0, 4.0), *, apart=0.5, base=5.0):
    """Two rods in a plane, pinned to the ground and to each other; drawn apart."""
    first, second = lengths
    return System(
        bodies=(
            Placed(rod("left", first), position=[0.5 * first, 0, 0]),
            Placed(
                rod("right", second), position=[base, apart + 0.5 * second, 0], rotation=[0, 0, -np.pi / 2]
            ),
        ),
        joints=(
            Revolute(first=GROUND, second=At("left", "left"), axis=Z),
            Revolute(first=At("left", "right"), second=At("right", "left"), axis=Z),
            # The ground's point of this hinge is where the rod's end is drawn: (base, apart).
            Revolute(first=GROUND, second=At("right", "right"), axis=Z),
        ),
    )


def test_a_triangle_closes_at_the_cosine_rules_angle(rod):
    found = assemble(triangle(rod, apart=0.0)).system
    left = found.bodies[0]
    corner = left.position + 1.5 * left.rotation[:, 0]
    # Sides 3, 4 and 5: a right angle at the corner, 9 / 5 along the base.
    np.testing.assert_allclose(corner, [9 / 5, 12 / 5, 0.0], atol=1e-12)


@pytest.mark.slow
def test_all_joints_fit_wherever_bodies_are_drawn(rod):
    found = assemble(triangle(rod, apart=0.7))
    solution = simulate(found.system, Run(1e-3, 1e-3, step=FixedStep(1e-3)))
    assert np.abs(joint_residuals(found.system, solution)[0]).max() < 1e-12
    moved = {each.body: each for each in found.moved}
    assert moved["left"].angle > 0.1


def test_a_run_of_the_machine_as_drawn_is_refused_and_names_the_remedy(rod):
    with pytest.raises(ModelError, match=r"is open .* assemble = true"):
        simulate(triangle(rod), Run(1.0, 0.1))


@pytest.mark.parametrize("angle", [1.2, 2.5])
def test_a_driven_crank_is_put_to_where_its_law_begins(rod, angle):
    system = System(
        bodies=(Placed(rod("crank", 1.0), position=[0.5, 0, 0]),),
        joints=(
            PrescribedRotation(
                first=GROUND, second=At("crank", "left"), axis=Z, angle=ConstantRate(1.0, angle)
            ),
        ),
    )
    found = assemble(system)
    np.testing.assert_allclose(
        found.system.bodies[0].rotation[:2, 0], [np.cos(angle), np.sin(angle)], atol=1e-12
    )
    (moved,) = found.moved
    assert moved.angle == pytest.approx(angle)
    assert assemble(found.system).moved[0].angle == pytest.approx(0.0, abs=1e-12)


def test_a_drive_that_begins_half_a_revolution_away_is_open(rod):
    """The joint measures the sine of its deviation, which is zero there."""
    ends = {"first": GROUND, "second": At("crank", "left"), "axis": Z}
    bodies = (Placed(rod("crank", 1.0), position=[0.5, 0, 0]),)
    drive = PrescribedRotation(**ends, angle=ConstantRate(1.0, np.pi))
    with pytest.raises(ModelError, match=r"rotation z is off by -?3\.14.*assemble = true"):
        simulate(System(bodies=bodies, joints=(drive,)), Run(0.1, 0.1))
    whole = System(bodies=bodies, joints=(PrescribedRotation(**ends, angle=ConstantRate(1.0, 2 * np.pi)),))
    assert simulate(whole, Run(0.1, 0.1)).stopped is None


def test_a_machine_that_fits_stays_where_it_is(rod):
    system = assemble(triangle(rod)).system
    again = assemble(system)
    assert max(each.distance for each in again.moved) < 1e-13


def test_rods_that_are_too_short_are_named_with_what_stays_open(rod):
    """Sides of 2 and 2 do not span 5: one is missing."""
    with pytest.raises(ConvergenceError, match=r"cannot be assembled: joint .* stays open by") as raised:
        assemble(triangle(rod, (2.0, 2.0), apart=0.0))
    assert "position x" in str(raised.value)
