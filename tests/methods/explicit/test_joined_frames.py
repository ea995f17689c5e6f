"""Joints of modal parts and rigid bodies: closed forms, reduced bodies on the same joints, balance."""

from functools import cache
from itertools import pairwise

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import stepped
from scipy.special import ellipk

from supple.body import MeanAxisFrame, RigidBody, RigidInterface, flexible_body
from supple.equations import balances
from supple.errors import ConvergenceError, ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Run
from supple.linearization import linearize, machine_modes
from supple.machine import (
    AngleServo,
    Ball,
    BaseAcceleration,
    Bushing,
    ConstantRate,
    Controller,
    Cylindrical,
    DeadForce,
    DeadTorque,
    Fixed,
    FollowerForce,
    JointReading,
    Placed,
    PrescribedRotation,
    Revolute,
    SampledController,
    Spin,
    SpringDamper,
    System,
    TorqueBetween,
    TorsionSpringDamper,
)
from supple.mesh import CellType, block
from supple.methods.explicit import ENERGIES, CentrifugalStiffness, Energies, Explicit, modal_subdomain
from supple.quantities import AccelerationSensor, ControlSensor, JointForceSensor, StressSensor
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.simulation import equilibrium, simulate

G = (0.0, 0.0, -9.81)
ACROSS = (0.0, 1.0, 0.0)
BASIS = NormalModes(4)


@cache
def rubber(name):
    """A linear bar of 1 x 0.1 x 0.1, rigid at both ends."""
    model = solid_model(block(1.0, 0.1, 0.1, 4, 1, 1, CellType.TETRA10), Isotropic(3e7, 0.3, 1000.0))
    return flexible_body(name, model, [RigidInterface("a", "root"), RigidInterface("b", "tip")]).linearized()


@cache
def modal(name):
    return modal_subdomain(rubber(name), BASIS)


@cache
def reduced(name):
    return reduce(rubber(name), MeanAxisFrame(), BASIS, loads=NoLoads, derivatives=NoDerivatives())


def rod(name="rod", mass=2.0, length=1.0):
    inertia = mass * length**2 / 12
    ends = {"a": np.zeros(3), "b": np.array([length, 0, 0])}
    centre = np.array([length / 2, 0, 0])
    return RigidBody(name, mass, centre, np.diag([1e-3, inertia, inertia]), ends)


def double(make):
    """Two bars in a row, let go from the horizontal."""
    return System(
        [make("one"), Placed(make("two"), position=(1.0, 0, 0))],
        joints=[
            Revolute(name="pin", first="ground", second="one.a", axis=ACROSS),
            Revolute(name="knee", first="one.b", second="two.a", axis=ACROSS),
        ],
        gravity=G,
    )


def tip(system, solution):
    name = system.bodies[-1].body.name
    return system.placed(name).body.interface_motion(solution.bodies[name], "b").position


def opened(solution):
    """By how much the balance is open, of the largest energy."""
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    return np.abs(total - total[0]).max() / np.abs(e).max()


def test_a_rigid_pendulum_has_the_period_of_the_closed_form():
    """From the horizontal: a quarter swing takes K(sin(pi/4)) sqrt(l / g), l = 2/3 of a rod."""
    quarter = ellipk(0.5) * np.sqrt(2 / 3 / 9.81)
    system = System(
        [rod()], joints=[Revolute(name="pin", first="ground", second="rod.a", axis=ACROSS)], gravity=G
    )
    angles = []
    for h in (quarter / 100, quarter / 200):
        solution = simulate(system, stepped(Run(quarter, quarter / 20), h))
        axis = solution.bodies["rod"].rotation[:, :, 0]
        angles.append(np.arctan2(-axis[-1, 2], axis[-1, 0]))
    errors = np.abs(np.array(angles) - np.pi / 2)
    assert errors[1] < 5e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert opened(solution) < 1e-12
    # m g at the lowest point, and 3/2 m g of the swing there, along the joint's axes on the ground.
    force = solution.joint_forces["pin"]
    assert np.linalg.norm(force[-1, :3]) == pytest.approx(2.5 * 2.0 * 9.81, rel=1e-4)


def test_a_servo_that_comes_to_rest_leaves_the_scale_of_energies_as_it_was():
    """J a'' = k (a_0 - a) - c a' from rest; at its end all energies are those of round-off of the steps."""
    inertia, k, c, target = 2.0 / 3, 500.0, 20.0, 0.3
    about = {"first": "ground", "second": "rod.a", "axis": ACROSS}
    system = System(
        [rod()],
        joints=[Revolute(name="pin", **about)],
        loads=[AngleServo(**about, angle=target, stiffness=k, damping=c)],
    )
    solution = simulate(system, stepped(Run(1.5, 0.01), 2e-3))
    a, t = c / inertia / 2, solution.times
    w = np.sqrt(k / inertia - a**2)
    expected = target * (1 - np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t)))
    axis = solution.bodies["rod"].rotation[:, :, 0]
    assert np.arctan2(-axis[:, 2], axis[:, 0]) == pytest.approx(expected, abs=0.02 * target)
    assert opened(solution) < 1e-12


def test_a_part_that_rotates_far_in_a_step_stops_the_run_with_the_step():
    """One radian in a step, which a weak spring permits."""
    about = {"first": "ground", "second": "rod.a", "axis": ACROSS}
    system = System(
        [Placed(rod(), angular_velocity=(0.0, 10.0, 0.0))],
        joints=[Revolute(name="pin", **about)],
        loads=[TorsionSpringDamper(**about, stiffness=0.1, damping=0.0)],
    )
    with pytest.raises(ConvergenceError, match=r"rotate too far in a step; take a FixedStep below 0\.1"):
        simulate(system, Run(1.0, 0.1, method=Explicit()))


@pytest.mark.slow
def test_two_modal_parts_swing_as_two_reduced_ones():
    run = Run(1.0, 0.01)
    expected = tip(double(reduced), simulate(double(reduced), Run(1.0, 0.01, FixedStep(2e-4))))
    found = [simulate(double(modal), stepped(run, h)) for h in (4e-4, 2e-4, 1e-4)]
    places = [tip(double(modal), own) for own in found]
    assert np.abs(places[-1] - expected).max() < 1e-3 * 2.0
    first, second = (np.abs(a - b).max() for a, b in pairwise(places))
    assert first / second == pytest.approx(4.0, rel=0.15)
    assert all(opened(own) < 1e-9 for own in found)
    # They bend as they swing: the test is one of deformed parts.
    assert np.abs(found[-1].bodies["one"].coordinates).max() > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    "joint",
    [
        Ball(name="knee", first="one.b", second="rod.a"),
        Fixed(name="knee", first="one.b", second="rod.a"),
        Cylindrical(name="knee", first="one.b", second="rod.a", axis=ACROSS),
        PrescribedRotation(name="knee", first="one.b", second="rod.a", axis=ACROSS, angle=lambda t: t**2),
    ],
    ids=lambda joint: type(joint).__name__,
)
def test_a_rigid_body_on_a_modal_part_moves_as_on_a_reduced_one(joint):
    def machine(make):
        return System(
            [make("one"), Placed(rod(mass=1.0), position=(1.0, 0, 0))],
            joints=[Fixed(name="clamp", first="ground", second="one.a"), joint],
            gravity=G,
        )

    expected = simulate(machine(reduced), Run(0.2, 0.01, FixedStep(2e-4)))
    found = simulate(machine(modal), stepped(Run(0.2, 0.01), 2e-4))
    assert tip(machine(modal), found) == pytest.approx(tip(machine(reduced), expected), abs=1e-4)
    forces, own = expected.joint_forces["clamp"], found.joint_forces["clamp"]
    assert own == pytest.approx(forces, abs=0.02 * np.abs(forces).max())
    assert opened(found) < 1e-9


@pytest.mark.slow
def test_free_parts_on_a_ball_keep_both_momenta():
    system = System(
        [Placed(modal("one"), angular_velocity=(0.3, 0.5, 2.0)), Placed(rod(), position=(1.0, 0, 0))],
        joints=[Ball(name="knee", first="one.b", second="rod.a")],
        loads=[DeadForce(at="one.b", force=(0.0, 0.0, 0.0))],
    )
    solution = simulate(system, stepped(Run(0.3, 0.003), 2e-4))
    found = balances(system, solution)
    for momentum in (found.momentum, found.angular_momentum):
        # Rates at output times are means of two steps: of second order.
        assert np.abs(momentum - momentum[0]).max() < 1e-4 * np.abs(momentum).max()
    assert found.total == pytest.approx(np.full(101, found.total[0]), rel=1e-4)
    assert opened(solution) < 1e-10


def test_rest_and_modes_of_modal_parts_are_those_of_reduced_ones():
    def cantilever(make):
        return System(
            [make("one")],
            joints=[Fixed(name="clamp", first="ground", second="one.a")],
            loads=[DeadForce(at="one.b", force=(0.0, 0.0, -1.0))],
        )

    rests = [equilibrium(cantilever(make), fulls=()) for make in (modal, reduced)]
    one, other = (tip(rest.system, rest.solution) for rest in rests)
    assert one == pytest.approx(other, rel=1e-9)
    assert 1e-4 < np.abs(one[0, 2])
    assert rests[0].joint_forces["clamp"] == pytest.approx(rests[1].joint_forces["clamp"], abs=1e-8)
    modes = [machine_modes(linearize(cantilever(make), fulls=())) for make in (modal, reduced)]
    assert modes[0].frequencies == pytest.approx(modes[1].frequencies, rel=1e-9)


def test_a_spin_that_would_stiffen_a_modal_part_is_refused_at_rest():
    body = flexible_body("one", rubber("one").model, [RigidInterface("a", "root")])
    part = modal_subdomain(body, BASIS, stiffening=CentrifugalStiffness())
    clamp = Fixed(name="clamp", first="ground", second="one.a")
    hub = PrescribedRotation(name="hub", first="ground", second="one.a", axis=(0, 0, 1), angle=0.0)
    assert machine_modes(linearize(System([part], [clamp])), 1).frequencies[0] > 0
    with pytest.raises(ModelError, match="part 'one' has a centrifugal stiffness"):
        linearize(System([part], [hub]), spin=Spin(5.0, (0, 0, 1)))


@pytest.mark.slow
def test_a_mass_on_a_spring_and_damper_swings_as_the_closed_form():
    """From a stretched start: z = z_0 e^-at (cos wt + a/w sin wt); a damper follows half a step late."""
    mass, k, c, z0 = 2.0, 800.0, 4.0, 0.1
    ball = RigidBody("ball", mass, np.zeros(3), 0.01 * np.eye(3), {"eye": np.zeros(3)})
    spring = SpringDamper(
        first="ground", second="ball.eye", anchor=(0, 0, 1.0), stiffness=k, damping=c, rest_length=1.0
    )
    system = System([Placed(ball, position=(0, 0, -z0))], loads=[spring])
    a = c / mass / 2
    w = np.sqrt(k / mass - a**2)
    t = Run(1.0, 0.02).times
    expected = z0 * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))
    errors = []
    for h in (1e-3, 5e-4):
        solution = simulate(system, stepped(Run(1.0, 0.02), h))
        errors.append(np.abs(-solution.bodies["ball"].position[:, 2] - expected).max() / z0)
        assert opened(solution) < 1e-12
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
    e = dict(zip(Energies._fields, solution.series[ENERGIES].T, strict=True))
    assert e["internal"][0] == pytest.approx(k * z0**2 / 2)
    left = k * z0**2 / 2 * np.exp(-2 * a)
    assert e["damping"][-1] == pytest.approx(k * z0**2 / 2 - left, rel=0.02)
    # The longest stable step: h^2 w^2 / 4 + h c / 2m = 1.
    limit = 2 / (c / mass / 2 + np.sqrt((c / mass / 2) ** 2 + k / mass))
    with pytest.raises(ModelError, match=f"above the stability limit of {limit:.4g} s"):
        simulate(system, stepped(Run(1.0, 0.02), 1.01 * limit))


@pytest.mark.slow
def test_bushings_torques_and_the_base_act_as_on_reduced_bodies():
    def machine(make):
        return System(
            [make("one"), Placed(rod(mass=1.0), position=(1.0, 0, 0))],
            joints=[Fixed(name="clamp", first="ground", second="one.a")],
            loads=[
                Bushing(
                    first="one.b",
                    second="rod.a",
                    stiffness=(2e3, 2e3, 2e3, 20.0, 20.0, 20.0),
                    damping=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0),
                ),
                DeadTorque(first="rod.b", torque=(0.0, 2.0, 0.0)),
                FollowerForce(first="one.b", force=(0.0, 0.0, 5.0)),
                BaseAcceleration(acceleration=ConstantRate([0.0, 3.0, 0.0])),
            ],
        )

    expected = simulate(machine(reduced), Run(0.2, 0.01, FixedStep(2e-4)))
    found = simulate(machine(modal), stepped(Run(0.2, 0.01), 1e-4))
    places = tip(machine(reduced), expected)
    moved = np.abs(places - places[0]).max()
    assert tip(machine(modal), found) == pytest.approx(places, abs=1e-3 * moved)
    assert moved > 0.01
    assert opened(found) < 1e-9


@pytest.mark.slow
def test_sensors_read_frames_as_they_read_floating_bodies():
    def machine(make):
        return System(
            [make("one")],
            joints=[Fixed(name="clamp", first="ground", second="one.a")],
            loads=[DeadForce(at="one.b", force=lambda t: jnp.stack([0 * t, 0 * t, 5 * jnp.sin(20 * t)]))],
        )

    run = Run(0.2, 0.01, FixedStep(1e-4))
    reads = [
        AccelerationSensor("a", "one.b"),
        JointForceSensor("clamp", "clamp"),
        StressSensor("stress", "one", rubber("one").model, [0, 1]),
    ]
    machines = machine(modal), machine(reduced)
    motions = [simulate(system, own) for system, own in zip(machines, (stepped(run, 1e-4), run), strict=True)]
    for sensor in reads:
        one, other = (sensor.values(*each) for each in zip(machines, motions, strict=True))
        assert one == pytest.approx(other, abs=2e-3 * np.abs(other).max())


def held_up(sampled):
    """A rod on a hinge that a controller with an integral part turns to 0.3 rad."""
    pin = Revolute(name="pin", first="ground", second="rod.a", axis=ACROSS)
    torque = TorqueBetween(first="ground", second="rod.a", axis=ACROSS, torque=0.0)

    def law(wanted, read, integral):
        return 40 * (wanted - read.angle) - 6 * read.rate + 30 * integral

    common = {"reads": {"pin": JointReading("pin")}, "drives": {"motor": torque}}
    if sampled:

        def call(_time, readings, memory):
            left = 0.3 - readings["pin"].angle
            memory = {"integral": memory["integral"] + 0.01 * left}
            return {"motor": law(0.3, readings["pin"], memory["integral"])}, memory

        control = SampledController(**common, law=call, every=0.01, memory={"integral": 0.0})
    else:
        control = Controller(
            **common,
            outputs=lambda _t, read, z: {"motor": law(0.3, read["pin"], z[0])},
            rates=lambda _t, read, _z: jnp.stack([0.3 - read["pin"].angle]),
            initial=(0.0,),
        )
    return System([rod()], joints=[pin], gravity=G, controllers=[control])


@pytest.mark.slow
@pytest.mark.parametrize("sampled", [False, True], ids=["traced", "sampled"])
def test_controllers_drive_frames_as_they_drive_floating_bodies(sampled):
    system, run = held_up(sampled), Run(0.4, 0.02)
    implicit = simulate(system, Run(0.4, 0.02, FixedStep(1e-3)))
    expected = implicit.bodies["rod"].rotation
    found = simulate(system, stepped(run, 5e-4))
    one, other = (ControlSensor("u", "controller").values(system, each)[:, 0] for each in (found, implicit))
    assert one == pytest.approx(other, abs=5e-3 * np.abs(other).max())
    assert found.bodies["rod"].rotation == pytest.approx(expected, abs=2e-3)
    assert np.abs(expected[-1, 2, 0]) > 0.1  # it turns
    assert opened(found) < 1e-10
    begun = simulate(system, stepped(Run(0.2, 0.02), 5e-4))
    rest = simulate(system, stepped(run, 5e-4), resume=begun)
    assert np.array_equal(rest.bodies["rod"].rotation[-1], found.bodies["rod"].rotation[-1])
