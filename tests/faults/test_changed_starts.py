"""Initial positions and velocities that the joints do not allow: changed, and said by how much."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from supple.errors import StartWarning, ValidityError
from supple.integrate import Run, Validity
from supple.machine import GROUND, At, ConstantRate, Fixed, Placed, PrescribedRotation, Revolute, System
from supple.simulation import simulate, simulate_batch

RUN = Run(0.02, 0.01)
Z = (0.0, 0.0, 1.0)


def hinged(rod, **start):
    """A rod of 1 kg and 1 m on a hinge at its left end."""
    hinge = Revolute(first=GROUND, second=At("bar", "left"), axis=Z, name="hinge")
    return System((Placed(rod("bar", 1.0), position=[0.5, 0, 0], **start),), (hinge,))


def test_a_velocity_along_a_hinged_rod_is_lost_and_said(rod):
    """5 m/s of 1 kg are 12.5 J; the hinge leaves none of them."""
    mass = rod("bar", 1.0).mass
    energy = mass * 5.0**2 / 2
    words = rf"kinetic energy is .* instead of {energy:.4g} \(-100 %\); body 'bar' starts with .*instead of 5"
    with pytest.warns(StartWarning, match=words) as said:
        solution = simulate(hinged(rod, velocity=[5.0, 0, 0]), RUN)
    assert "violated: 'hinge' (position x)" in str(said[0].message)
    np.testing.assert_allclose(solution.bodies["bar"].velocity[0], 0, atol=1e-12)


def test_it_is_an_error_when_strict(rod):
    strict = Run(0.02, 0.01, validity=Validity(strict=True))
    with pytest.raises(ValidityError, match="joints do not allow the initial velocities"):
        simulate(hinged(rod, velocity=[5.0, 0, 0]), strict)
    with pytest.raises(ValidityError, match="joints do not allow the initial velocities"):
        simulate_batch([hinged(rod, velocity=[5.0, 0, 0])], strict)


@pytest.mark.slow
def test_two_equal_bodies_of_which_one_moves_lose_half(rod):
    """Perfectly inelastic: the energy of the relative motion goes, half of it all."""
    standing = Placed(rod("b", 1.0), position=[1.0, 0, 0], velocity=[0, 0, 0], angular_velocity=[0, 0, 0])
    bodies = (Placed(rod("a", 1.0), velocity=[4.0, 0, 0], angular_velocity=[0, 0, 0]), standing)
    weld = Fixed(first=At("a", "right"), second=At("b", "left"), name="weld")
    with pytest.warns(
        StartWarning,
        match=r"\(-50 %\); body 'a' starts with a speed of 2 instead of 4, body 'b' starts with .*",
    ):
        solution = simulate(System(bodies, (weld,)), RUN)
    np.testing.assert_allclose(solution.bodies["b"].velocity[0], [2.0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("start", [{}, {"velocity": [0, 1.0, 0], "angular_velocity": [0, 0, 2.0]}])
def test_velocities_that_fit_and_bodies_that_are_driven_pass(rod, start):
    """A body at rest that a joint drives starts with the joint's speed: nothing that was given is lost."""
    motor = PrescribedRotation(first=GROUND, second=At("bar", "left"), axis=Z, angle=ConstantRate(2.0))
    driven = System((Placed(rod("bar", 1.0), position=[0.5, 0, 0], **start),), (motor,))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = simulate(driven, RUN)
    np.testing.assert_allclose(solution.bodies["bar"].velocity[0], [0, 1.0, 0], atol=1e-12)


def chain(rod, gap):
    joints = (
        Revolute(first=GROUND, second=At("a", "left"), axis=Z, name="shoulder"),
        Revolute(first=At("a", "right"), second=At("b", "left"), axis=Z, name="elbow"),
    )
    placed = Placed(rod("a", 1.0), position=[0.5, 0, 0]), Placed(rod("b", 1.0), position=[1.5 + gap, 0, 0])
    return System(placed, joints)


def test_an_open_joint_is_named_with_its_gap_and_what_was_moved(rod):
    """Only the second rod can come: the first hangs on the ground."""
    words = r"joint 'elbow' is open by 0\.0003 .*\(position x\): body 'b' was moved by 0\.0003 to close it"
    with pytest.warns(StartWarning, match=words):
        simulate(chain(rod, 3e-4), RUN)
    with pytest.raises(ValidityError, match="joint 'elbow' is open by"):
        simulate(chain(rod, 3e-4), Run(0.02, 0.01, validity=Validity(strict=True)))


def test_rounding_of_six_digits_passes(rod):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(chain(rod, 4e-7), RUN)
