"""Friction under the joint's own force: an incline, and a hinge against an independent integration."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from supple.body import RigidBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, Kinematic, Run
from supple.machine import (
    GROUND,
    At,
    Ball,
    ConstantRate,
    Fixed,
    HingeFriction,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    SlideFriction,
    System,
    Universal,
)
from supple.quantities import ElementEnergySensor, SpringForceSensor
from supple.simulation import simulate, simulate_batch

G = 9.81


def incline(angle, coefficient, width=1e-5, velocity=0.0):
    """A block on a slide that falls at an angle."""
    block = RigidBody(
        name="block", mass=3.0, inertia=np.eye(3), centre=np.zeros(3), points={"foot": np.zeros(3)}
    )
    down = np.array([np.cos(angle), 0.0, -np.sin(angle)])
    slide = Prismatic(name="slide", first=GROUND, second=At("block", "foot"), axis=tuple(down))
    friction = SlideFriction(joint=slide, coefficient=coefficient, width=width)
    return System((Placed(block, velocity=velocity * down),), (slide,), (friction,), gravity=(0, 0, -G)), down


@pytest.mark.slow
def test_a_block_slides_down_an_incline_with_the_acceleration_of_its_formula():
    """`g (sin a - mu cos a)`, its normal force being the joint's."""
    angle, mu = 0.6, 0.3
    machine, down = incline(angle, mu, velocity=0.1)
    found = simulate(machine, Run(1.0, 0.1, step=FixedStep(0.01)))
    acceleration = found.bodies["block"].acceleration @ down
    assert acceleration == pytest.approx(np.full(11, G * (np.sin(angle) - mu * np.cos(angle))), rel=1e-8)
    across = np.linalg.norm(found.joint_forces["slide"][:, :2], axis=1)
    assert across == pytest.approx(np.full(11, 3.0 * G * np.cos(angle)), rel=1e-8)


def test_a_block_stays_where_the_incline_is_flatter_than_friction():
    """It creeps at `w s / sqrt(1 - s^2)`, `s = tan a / mu`."""
    angle, mu, width = 0.2, 0.3, 1e-3
    machine, down = incline(angle, mu, width)
    (friction,) = machine.loads
    found = simulate(machine, Run(0.5, 0.1, step=FixedStep(1e-3)))
    # A sensor reads what holds the block: friction on the second end, up the incline.
    held = SpringForceSensor("friction", friction).values(machine, found)[-1, :3]
    assert held == pytest.approx(-3.0 * G * np.sin(angle) * down, rel=1e-6)
    share = np.tan(angle) / mu
    assert found.bodies["block"].velocity[-1] @ down == pytest.approx(
        width * share / np.sqrt(1 - share**2), rel=1e-6
    )


def pendulum(coefficient, radius=0.05, width=0.05):
    """A heavy rod let go level, its pin as thick as a tenth of it."""
    rod = RigidBody(
        name="rod", mass=2.0, inertia=np.diag([1e-3, 0.3, 0.3]), centre=np.array([0.5, 0, 0]),
        points={"eye": np.zeros(3)},
    )  # fmt: skip
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "eye"), axis=(0, 1, 0))
    friction = HingeFriction(joint=hinge, coefficient=coefficient, radius=radius, width=width)
    return System((Placed(rod),), (hinge,), (friction,), gravity=(0, 0, -G)), friction


def exact_pendulum(times, coefficient, radius, width):
    """`I phi'' = m g c cos(phi) - mu r N s`, N from the motion of the centre: independent of joints."""
    mass, centre, inertia = 2.0, 0.5, 0.3 + 2.0 * 0.25

    def rates(_, state):
        phi, rate = state
        direction = rate / np.hypot(rate, width)
        # Along and across the rod: N^2 = a^2 + b^2, b = m (g cos - c phi''), phi'' with N: a quadratic.
        along = mass * (G * np.sin(phi) + centre * rate**2)
        free = mass * G * centre * np.cos(phi) / inertia
        lever = coefficient * radius * direction / inertia
        force = along
        for _ in range(200):
            across = mass * (G * np.cos(phi) - centre * (free - lever * force))
            force = np.hypot(along, across)
        return rate, free - lever * force

    found = solve_ivp(
        rates, (0, times[-1]), (0.0, 0.0), t_eval=times, rtol=1e-11, atol=1e-12, method="DOP853"
    )
    return found.y


@pytest.mark.slow
def test_friction_in_a_hinge_follows_its_force():
    """Two swings: angle and rate as by another integrator of the same law, the error of second order."""
    mu, radius, width = 0.4, 0.05, 0.05
    machine, friction = pendulum(mu, radius, width)
    errors = []
    for step in (2e-3, 1e-3):
        found = simulate(machine, Run(2.0, 0.1, step=FixedStep(step)))
        axes = found.bodies["rod"].rotation
        angle = np.unwrap(np.arctan2(-axes[:, 2, 0], axes[:, 0, 0]))
        exact = exact_pendulum(found.times, mu, radius, width)
        errors.append(abs(angle - exact[0]).max())
    assert errors[1] < 2e-5
    assert 3.0 < errors[0] / errors[1] < 5.0
    # What the rod has lost of its energy, the hinge has taken.
    power = ElementEnergySensor("hinge", friction).values(machine, found)[:, 1]
    assert (power <= 0).all()


def slider_crank(coefficient):
    """A crank turned steadily, its slider on a rail with friction; no equation repeats another."""

    def rigid(name, mass, length, **points):
        inertia = np.diag([1e-4, 1.0, 1.0]) * mass * length**2 / 12
        return RigidBody(name=name, mass=mass, inertia=inertia, centre=np.zeros(3), points=points)

    crank, arm, tilt = 0.1, 0.4, np.arcsin(0.1 / 0.4)
    pin = np.array([0, 0, crank])
    end = pin + arm * np.array([np.cos(tilt), 0, -np.sin(tilt)])
    bodies = (
        Placed(rigid("crank", 0.5, crank, eye=np.zeros(3), pin=pin)),
        Placed(rigid("rod", 0.8, arm, pin=(-arm / 2, 0, 0), end=(arm / 2, 0, 0)),
               position=(pin + end) / 2, rotation=(0, tilt, 0)),
        Placed(rigid("slider", 1.5, 0.1, end=np.zeros(3)), position=end),
    )  # fmt: skip
    rail = Prismatic(name="rail", first=GROUND, second=At("slider", "end"), axis=(1, 0, 0))
    joints = (
        PrescribedRotation(
            name="motor", first=GROUND, second=At("crank", "eye"), axis=(0, 1, 0), angle=ConstantRate(12.0)
        ),
        Ball(name="pin", first=At("crank", "pin"), second=At("rod", "pin")),
        Universal(name="end", first=At("rod", "end"), second=At("slider", "end"),
                  first_axis=(0, 1, 0), second_axis=(0, 0, 1)),
        rail,
    )  # fmt: skip
    friction = SlideFriction(joint=rail, coefficient=coefficient, width=0.05)
    return System(bodies, joints, (friction,), gravity=(0, 0, -G))


@pytest.mark.slow
def test_inverse_dynamics_knows_friction():
    """The motor's torque as in a run that is integrated, once its sudden start has died out."""
    machine = slider_crank(0.3)
    run = Run(0.2, 0.01, step=FixedStep(5e-4))
    moved = simulate(machine, replace(run, method=Kinematic())).joint_forces["motor"][:, 5]
    integrated = simulate(machine, run).joint_forces["motor"][:, 5]
    free = simulate(slider_crank(0.0), replace(run, method=Kinematic())).joint_forces["motor"][:, 5]
    assert abs(moved - integrated)[5:].max() < 1e-4 * abs(moved).max()
    assert abs(moved - free).max() > 0.05 * abs(moved).max()


def test_what_friction_cannot_know_is_refused():
    machine, _ = incline(0.6, 0.3)
    with pytest.raises(ModelError, match="not among the machine's joints"):
        replace(machine, joints=())
    twice = Fixed(name="twice", first=GROUND, second=At("block", "foot"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(ModelError, match="not unique"):
            simulate(replace(machine, joints=(twice, *machine.joints)), Run(0.1, 0.1))


def test_a_pin_that_jams_is_refused():
    """Thicker than the rod is long, friction raises the force that it comes from."""
    machine, _ = pendulum(1.0, radius=50.0)
    moving = replace(machine, bodies=[replace(machine.bodies[0], angular_velocity=(0, 3.0, 0))])
    with pytest.raises(ConvergenceError, match="jams"):
        simulate(moving, Run(0.1, 0.1))


@pytest.mark.slow
def test_a_batch_and_a_run_start_alike():
    machine, _ = incline(0.6, 0.3, velocity=0.1)
    other, _ = incline(0.6, 0.3, velocity=0.1)
    run = Run(0.1, 0.1, step=FixedStep(0.01))
    alone = simulate(machine, run).bodies["block"]
    for each in simulate_batch([machine, other], run).check().solutions:
        assert each.bodies["block"].acceleration == pytest.approx(alone.acceleration, rel=1e-12)
