"""Derivatives of runs against closed forms, and against differences of runs."""

from __future__ import annotations

from functools import partial

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as

from supple.body import RigidBody
from supple.errors import ArgumentError, ModelError
from supple.integrate import AdaptiveStep, FixedStep, Run, Tolerances
from supple.machine import (
    BaseAcceleration,
    Controller,
    DeadForce,
    HingeFriction,
    JointReading,
    Penalty,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    SampledController,
    Sine,
    SlideStop,
    SpringDamper,
    System,
    Table,
    TorqueBetween,
    TorsionSpringDamper,
)
from supple.quantities import (
    EnergySensor,
    JointForceSensor,
    JointMotionSensor,
    Place,
    PositionSensor,
    SpringForceSensor,
)
from supple.sensitivity import Statistic, sensitivities
from supple.sensitivity.parameter_changes import parameter_changes
from supple.simulation import equilibrium, simulate

DOWN = np.array([0.0, 0.0, -9.81])
EXACT = Tolerances(1e-11)
PIN = JointMotionSensor("pin", "pin")


def rod(length=1.0, mass=2.0, name="rod"):
    inertia = mass * length**2 / 12 * np.diag([1e-2, 1.0, 1.0])
    ends = {"root": np.zeros(3), "tip": np.array([length, 0, 0])}
    return RigidBody(name, mass, np.array([length / 2, 0, 0]), inertia, ends)


def pinned(body, *, loads=(), gravity=DOWN, **more):
    pin = Revolute(first="ground", second="rod.root", axis=(0, 1, 0), name="pin")
    return System([body], [pin], loads=loads, gravity=gravity, **more)


def by_differences(build, parameters, name, run, observables, step=1e-3):
    """Richardson's extrapolation of central differences of `simulate`."""

    def at(value):
        system = build({**parameters, name: value})
        solution = simulate(system, run)
        return np.concatenate([each.values(system, solution).ravel() for each in observables])

    value = parameters[name]
    coarse, fine = (
        (at(value * (1 + own)) - at(value * (1 - own))) / (2 * own * value) for own in (2 * step, step)
    )
    return (4 * fine - coarse) / 3


def assert_as_differences(build, parameters, run, observables, rtol=1e-7, step=1e-3):
    found = sensitivities(build, parameters, run, observables)
    for name in parameters:
        expected = by_differences(build, parameters, name, run, observables, step)
        own = np.concatenate([found.derivatives[each.name][name].ravel() for each in observables])
        np.testing.assert_allclose(own, expected, rtol=0, atol=rtol * abs(expected).max())
    return found


# A pendulum of any amplitude keeps its motion while all lengths grow, in time that grows with their root.


def swinging(parameters):
    return pinned(rod(parameters["length"], parameters["mass"]))


def test_a_pendulum_follows_its_length_as_its_period_does():
    """`theta(t; L) = phi(t / sqrt(L))`, so that `dtheta/dL = - t dtheta/dt / (2 L)`, to second order."""
    parameters = {"length": 0.8, "mass": 2.0}

    def error(step):
        run = Run(2.0, 0.04, FixedStep(step), tolerances=EXACT)
        force = JointForceSensor("force", "pin")
        found = sensitivities(swinging, parameters, run, [PIN, force, Statistic("peak", force, np.max)])
        angle, rate = found.values["pin"].T[:2]
        expected = -found.solution.times * rate / (2 * parameters["length"])
        assert abs(angle).max() > 3  # it swings through, from level to level
        # Forces grow with the mass, motions do not follow it.
        by_mass = found.derivatives["force"]["mass"] * parameters["mass"]
        np.testing.assert_allclose(by_mass, found.values["force"], atol=1e-7)
        by_mass = found.derivatives["peak"]["mass"] * parameters["mass"]
        np.testing.assert_allclose(by_mass, found.values["peak"], atol=1e-7)
        assert abs(found.derivatives["pin"]["mass"]).max() < 1e-9
        return abs(found.derivatives["pin"]["length"][:, 0] - expected).max() / abs(expected).max()

    coarse, fine = error(0.01), error(0.005)
    assert fine < 2e-4
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.1)


MASS, DAMPING, FORCE, FREQUENCY = 2.0, 8.0, 3.0, 1.0


def driven(parameters):
    """A mass on a spring along x, driven by a sine."""
    block = RigidBody("block", MASS, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})
    spring = SpringDamper(
        first="ground",
        second="block.centre",
        anchor=(-1.0, 0, 0),
        stiffness=parameters["stiffness"],
        damping=DAMPING,
        rest_length=1.0,
    )
    load = DeadForce(at="block.centre", force=Sine(np.array([FORCE, 0, 0]), FREQUENCY))
    slide = Prismatic(first="ground", second="block.centre", axis=(1, 0, 0), name="slide")
    return System([block], [slide], loads=[spring, load])


def last_periods(column):
    return np.sqrt(2 * np.mean(column[-300:] ** 2))


@pytest.mark.slow
def test_the_amplitude_of_a_driven_oscillator_follows_its_stiffness():
    """`A = F / |k - m w^2 + i c w|`, `dA/dk = - A (k - m w^2) / |..|^2`, once it has swung in."""
    position = PositionSensor("x", Place("block", "centre"))
    run = Run(8.0, 0.01, FixedStep(0.005), tolerances=EXACT)
    stiffness = 100.0
    found = sensitivities(
        driven,
        {"stiffness": stiffness},
        run,
        lambda system: [
            Statistic("amplitude", position, last_periods),
            SpringForceSensor("spring", system.loads[0]),
            position,
        ],
    )
    w = 2 * np.pi * FREQUENCY
    real, square = stiffness - MASS * w**2, (stiffness - MASS * w**2) ** 2 + (DAMPING * w) ** 2
    amplitude = FORCE / np.sqrt(square)
    assert found.values["amplitude"][0] == pytest.approx(amplitude, rel=2e-3)
    by_stiffness = found.derivatives["amplitude"]["stiffness"][0]
    assert by_stiffness == pytest.approx(-amplitude * real / square, rel=5e-3)
    # The spring's force on the block is -k x - c v: that k itself changes is part of the derivative.
    x = found.values["x"][:, 0]
    by_motion = found.derivatives["x"]["stiffness"][:, 0]
    times = found.solution.times
    rate = np.gradient(by_motion, times, edge_order=2)
    expected = -x - stiffness * by_motion - DAMPING * rate
    np.testing.assert_allclose(
        found.derivatives["spring"]["stiffness"][:, 0], expected, atol=2e-3 * abs(expected).max()
    )


@pytest.mark.slow
def test_consistent_starts_and_prescribed_motions_are_differentiated_too():
    """An arm hinged to a driven rod starts with the velocities and forces that the drive asks for."""

    def build(parameters):
        times = np.linspace(0, 2, 5)
        drive = PrescribedRotation(
            first="ground",
            second="rod.root",
            axis=(0, 0, 1),
            angle=Table(times, parameters["speed"] * times),
            name="drive",
        )
        length = parameters["length"]
        hinge = Revolute(first="rod.tip", second="arm.root", axis=(0, 0, 1), name="pin")
        return System(
            [rod(length), Placed(rod(0.7, 1.0, "arm"), position=np.array([length, 0, 0]))], [drive, hinge]
        )

    run = Run(0.6, 0.1, FixedStep(0.01), tolerances=EXACT)
    parameters = {"speed": 3.0, "length": 1.0}
    assert_as_differences(build, parameters, run, [PIN, JointForceSensor("force", "drive")])


@pytest.mark.slow
def test_a_run_from_equilibrium_begins_at_the_equilibrium_of_each_value():
    def build(parameters):
        spring = TorsionSpringDamper(
            first="ground", second="rod.root", axis=(0, 1, 0), stiffness=parameters["stiffness"]
        )
        push = DeadForce(at="rod.tip", force=Sine(np.array([0, 0, 3.0]), 1.0))
        return equilibrium(pinned(rod(), loads=[spring, push])).system

    run = Run(0.6, 0.1, FixedStep(0.01), tolerances=EXACT)
    found = assert_as_differences(build, {"stiffness": 40.0}, run, [PIN], rtol=1e-6, step=1e-2)
    assert abs(found.derivatives["pin"]["stiffness"][0, 0]) > 1e-3


@pytest.mark.slow
def test_adaptive_steps_meet_the_moved_instants_of_laws():
    def build(parameters):
        up = np.array([0, 0, parameters["force"]])
        rise = Table([0.0, parameters["rise"], 2.0], np.array([0 * up, up, up]))
        return pinned(rod(), loads=[DeadForce(at="rod.tip", force=rise)], gravity=0 * DOWN)

    run = Run(0.6, 0.1, AdaptiveStep(1e-5), tolerances=EXACT)
    observables = [PIN, JointForceSensor("force", "pin")]
    assert_as_differences(build, {"force": 1.0, "rise": 0.3712}, run, observables)
    with pytest.raises(ModelError, match="'rise' moves an instant"):
        sensitivities(build, {"force": 1.0, "rise": 0.3}, run, observables)


@pytest.mark.slow
def test_controllers_with_states_are_differentiated():
    def outputs(_time, reads, states):
        return {"motor": 3.0 * states[0] - 20 * reads["pin"].angle}

    def rates(time, reads, states):
        return jnp.array([jnp.sin(time) - states[0] - 0.1 * reads["pin"].rate])

    def build(parameters):
        motor = TorqueBetween(first="ground", second="rod.root", axis=(0, 1, 0), torque=parameters["torque"])
        controller = Controller(
            reads={"pin": JointReading("pin")},
            drives={"motor": motor},
            outputs=outputs,
            rates=rates,
            initial=[parameters["state"]],
        )
        return pinned(rod(1.0, parameters["mass"]), controllers=[controller])

    run = Run(0.6, 0.1, FixedStep(0.01), tolerances=EXACT)
    assert_as_differences(build, {"mass": 2.0, "state": 0.5, "torque": 0.3}, run, [PIN])


@pytest.mark.slow
def test_friction_that_reads_joint_forces_is_differentiated():
    def build(parameters):
        system = pinned(rod())
        friction = HingeFriction(
            joint=system.joints[0], coefficient=parameters["friction"], width=0.5, radius=0.1
        )
        return System(system.bodies, system.joints, loads=[friction], gravity=DOWN)

    run = Run(1.0, 0.1, FixedStep(0.01), tolerances=EXACT)
    assert_as_differences(build, {"friction": 0.3}, run, [PIN, JointForceSensor("force", "pin")])


@pytest.mark.slow
def test_a_deforming_bar_and_its_statistics_are_differentiated():
    bar = bar_as("reduced")
    tip = PositionSensor("tip", Place("bar", "tip"))

    def build(parameters):
        pin = Revolute(first="ground", second="bar.root", axis=(0, 1, 0), name="pin")
        spring = TorsionSpringDamper(
            first="ground", second="bar.root", axis=(0, 1, 0), stiffness=parameters["stiffness"]
        )
        push = DeadForce(at="bar.tip", force=Sine(np.array([0, 0, 20.0]), parameters["frequency"]))
        return System([bar], [pin], loads=[push, spring], gravity=DOWN)

    run = Run(0.2, 0.01, FixedStep(1e-3), tolerances=EXACT)
    observables = [PIN, tip, EnergySensor("energy"), Statistic("deviation", tip, np.std)]
    for each in observables:
        assert_as_differences(build, {"stiffness": 500.0, "frequency": 1.3}, run, [each])


@pytest.mark.slow
def test_chains_are_eliminated_along_their_tree():
    """Six rods on ball joints, as long as none of them has swung far: later their motion is chaotic."""

    def build(parameters):
        length, number = parameters["length"], 6
        bodies = [
            Placed(rod(length, 1.0 + 0.1 * each, f"r{each}"), position=np.array([each * length, 0, 0]))
            for each in range(number)
        ]
        joints = [
            Revolute(first=first, second=f"r{each}.root", axis=(0, 1, 0), name=f"j{each}")
            for each, first in enumerate(["ground", *(f"r{each}.tip" for each in range(number - 1))])
        ]
        return System(bodies, joints, gravity=DOWN)

    run = Run(0.2, 0.05, FixedStep(0.01), tolerances=EXACT)
    assert_as_differences(build, {"length": 0.5}, run, [JointForceSensor("force", "j0")])


def test_a_limit_beside_an_infinite_one_has_a_derivative():
    """A buffer at either end of a slide: the limits of both are one array, and three of its entries stay."""

    def buffered(parameters):
        block = RigidBody("block", MASS, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})
        ends = {"first": "ground", "second": "block.centre", "axis": (1, 0, 0)}
        penalty = Penalty(stiffness=1e3)
        stops = [
            SlideStop(**ends, upper=parameters["end"], penalty=penalty),
            SlideStop(**ends, lower=-0.1, penalty=penalty),
        ]
        slide = Prismatic(first="ground", second="block.centre", axis=(1, 0, 0), name="slide")
        return System([block], [slide], loads=stops)

    found = parameter_changes(buffered, {"end": 0.2}, {"end": 0.2}, Run(0.1, 0.05))
    (changed,) = [own for own in found.changes.model if own is not None]
    np.testing.assert_allclose(changed, [[1.0, 0.0]], rtol=1e-12)


def test_what_has_no_derivatives_is_refused():
    run = Run(0.1, 0.05, FixedStep(0.05))
    refused = partial(sensitivities, run=run, observables=[PIN])

    def kinked(parameters):
        return pinned(rod(), gravity=np.array([0, 0, -abs(parameters["g"] - 9.81)]))

    with pytest.raises(ModelError, match="is not smooth in parameter 'g'"):
        refused(kinked, {"g": 9.81})

    def growing(parameters):
        base = [BaseAcceleration(acceleration=np.zeros(3))] if parameters["loads"] > 1 else []
        return pinned(rod(), loads=base)

    with pytest.raises(ModelError, match="'loads' changes more than numbers"):
        refused(growing, {"loads": 1.0})
    with pytest.raises(ArgumentError, match=r"for a value of 0 a large change, sizes={'mass'"):
        refused(swinging, {"mass": 0.0, "length": 1.0})
    with pytest.raises(ModelError, match="did you mean 'mass'"):
        refused(swinging, {"mass": 1.0, "length": 1.0}, sizes={"mas": 1.0})
    with pytest.raises(ModelError, match="full bodies have no derivatives"):
        refused(lambda _: System([bar_as("full")]), {"mass": 1.0})
    motor = TorqueBetween(first="ground", second="rod.root", axis=(0, 1, 0), torque=0.0)
    sampled = SampledController(
        reads={}, drives={"motor": motor}, law=lambda *_: ({"motor": 0.0}, {}), every=0.05
    )
    with pytest.raises(ModelError, match="is sampled"):
        refused(lambda _: pinned(rod(), controllers=[sampled]), {"mass": 1.0})
    with pytest.raises(ModelError, match="refers to an element or joint of one machine"):
        sensitivities(
            driven, {"stiffness": 1.0}, run, [SpringForceSensor("f", driven({"stiffness": 1.0}).loads[0])]
        )
