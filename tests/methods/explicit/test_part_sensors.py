"""Sensors read parts of an explicit march as they read any body."""

import numpy as np
import pytest
from fixtures.explicit_bars import bar, explicit_bar

from supple.body import flexible_body
from supple.integrate import FixedStep, Run
from supple.machine import Placed, System
from supple.mesh import CellType
from supple.methods.explicit import modal_subdomain
from supple.quantities import AccelerationSensor, AngularVelocitySensor, Place, PositionSensor, VelocitySensor
from supple.reduction import NormalModes
from supple.simulation import simulate

RATE = 0.02
SPIN = np.array([0.0, 0.0, RATE])


def modal_bar():
    return modal_subdomain(flexible_body("bar", bar(CellType.HEXA8)), NormalModes(4))


@pytest.fixture(
    scope="module", params=[lambda: explicit_bar(CellType.HEXA8), modal_bar], ids=["elements", "modal"]
)
def flight(request):
    """A bar that stands turned by 90 degrees about z, flies, and spins slowly about its middle."""
    part = request.param()
    spun = Placed(part, rotation=(0, 0, np.pi / 2), angular_velocity=SPIN)
    system = System([spun.with_centre_velocity((1.0, 0.0, 0.0))])
    return system, simulate(system, Run(0.4, 0.1, FixedStep(1e-3)))


def test_position_and_velocity_of_a_node_set_are_those_of_the_flight(flight):
    system, solution = flight
    part, t = system.placed("bar").body, solution.times
    arm = part.interface("tip").position - part.centre_of_mass
    angles = np.pi / 2 + RATE * t
    radius, height = arm[0], arm[2]
    around = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.full_like(t, height)])
    start = system.placed("bar").rotation @ part.centre_of_mass
    expected = start + np.outer(t, [1.0, 0, 0]) + around
    assert PositionSensor("tip", "bar.tip").values(system, solution) == pytest.approx(expected, abs=3e-4)
    velocity = np.array([1.0, 0, 0]) + np.cross(SPIN, around)
    assert VelocitySensor("tip", "bar.tip").values(system, solution) == pytest.approx(velocity, abs=3e-4)
    nodes = Place("bar", tuple(part.interface("tip").nodes))
    same = VelocitySensor("nodes", nodes).values(system, solution)
    assert same == pytest.approx(VelocitySensor("tip", "bar.tip").values(system, solution), abs=1e-12)


def test_a_node_set_turns_with_its_part(flight):
    system, solution = flight
    part = system.placed("bar").body
    moving = part.interface_motion(solution.bodies["bar"], "tip")
    angles = np.pi / 2 + RATE * solution.times
    assert moving.rotation[:, 0, 0] == pytest.approx(np.cos(angles), abs=3e-4)
    assert moving.rotation[:, 1, 0] == pytest.approx(np.sin(angles), abs=3e-4)
    assert AngularVelocitySensor("spin", "bar.tip").values(system, solution)[:, 2] == pytest.approx(
        RATE, rel=1e-3
    )


def test_a_node_set_accelerates_towards_the_middle_of_the_turn(flight):
    system, solution = flight
    part = system.placed("bar").body
    middle = part.centre_of_mass
    moving = part.interface_motion(solution.bodies["bar"], "tip").position
    centre = system.placed("bar").rotation @ middle + np.outer(solution.times, [1.0, 0, 0])
    arm = moving - centre
    found = AccelerationSensor("tip", "bar.tip").values(system, solution)
    # It stretches as it spins up: the mean over its vibration is what the turn asks for.
    assert found.mean(axis=0)[:2] == pytest.approx(-(RATE**2) * arm.mean(axis=0)[:2], abs=RATE**2)
