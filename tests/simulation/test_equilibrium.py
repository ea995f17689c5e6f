"""Static equilibria: closed forms, one engine against the other, what cannot rest."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.equations import StaticSearch
from supple.errors import ConvergenceError, ModelError, SuppleWarning, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.integrate import FixedStep, Run, Tolerances
from supple.linearization import linearize
from supple.machine import (
    GROUND,
    AngleServo,
    At,
    Ball,
    ConstantRate,
    Controller,
    Cylindrical,
    DeadForce,
    Fixed,
    JournalBearing,
    Placed,
    PrescribedRotation,
    Prismatic,
    Ramp,
    Revolute,
    Scaled,
    Sine,
    SlideServo,
    Spin,
    SpringDamper,
    System,
    Table,
    TorsionSpringDamper,
    Unbalance,
)
from supple.mesh import CellType, block, strip
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import equilibrium, simulate

E, LENGTH, WIDTH, THICKNESS = 2.1e11, 1.0, 0.1, 5e-3
BENDING = E * WIDTH * THICKNESS**3 / 12


def cantilever(tip_force, frame, reduced=False):
    model = shell_model(
        strip(length=LENGTH, width=WIDTH, n_length=10, n_width=2),
        HomogeneousSection(Isotropic(E, 0.0, 7850.0), THICKNESS),
    )
    body = flexible_body("strip", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))
    form = FullBody(body, frame)
    if reduced:
        form = reduce(body.linearized(), frame, CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    clamp = Fixed(first=GROUND, second=At("strip", "root"))
    force = DeadForce(body="strip", at="tip", force=Scaled((0.0, 0.0, tip_force), Ramp(1.0, 1.0)))
    return System((Placed(form),), (clamp,), (force,))


def tip(found):
    (placed,) = found.system.bodies
    interface = placed.body.interface("tip")
    local = interface.position + (interface.motion @ placed.coordinates)[:3]
    return placed.position + placed.rotation @ local


@pytest.mark.slow
def test_a_chain_of_links_hangs_straight_down():
    link = [
        RigidBody(
            name=f"link {i}",
            mass=1.0,
            inertia=np.eye(3),
            centre=np.zeros(3),
            points={"top": (0, 0, 0.5), "end": (0, 0, -0.5)},
        )
        for i in range(3)
    ]
    bodies, z = [], 0.0
    for i, each in enumerate(link):  # laid out sideways, along x
        bodies.append(Placed(each, position=(0.5 + i, 0, 0), rotation=(0, -np.pi / 2, 0)))
    ends = [GROUND, At("link 0", "end"), At("link 1", "end")]
    joints = [Ball(first=end, second=At(each.name, "top")) for end, each in zip(ends, link, strict=True)]
    found = equilibrium(System(bodies, joints, gravity=(0, 0, -9.81)))
    for i, placed in enumerate(found.system.bodies):
        assert np.allclose(placed.position, (0, 0, z - 0.5 - i), atol=1e-9)
    carried = [np.linalg.norm(found.joint_forces[joint.name]) for joint in joints]
    assert np.allclose(carried, 9.81 * np.array([3.0, 2.0, 1.0]), rtol=1e-9)


def test_a_spinning_spring_balances_a_weight():
    """`k phi = m g L cos phi` of a rod on a hinge with a torsion spring: solved by hand for phi."""
    rod = RigidBody(
        name="rod", mass=2.0, inertia=np.eye(3), centre=np.zeros(3), points={"hinge": (-0.5, 0, 0)}
    )
    hinge = Revolute(first=GROUND, second=At("rod", "hinge"), axis=(0, 1, 0))
    spring = TorsionSpringDamper(
        first=GROUND, second=At("rod", "hinge"), axis=(0, 1, 0), stiffness=20.0, damping=0.0
    )
    system = System((Placed(rod, position=(0.5, 0, 0)),), (hinge,), (spring,), gravity=(0, 0, -9.81))
    found = equilibrium(system)
    x, _, z = found.system.bodies[0].position
    phi = np.arctan2(-z, x)
    assert 20.0 * phi == pytest.approx(2.0 * 9.81 * 0.5 * np.cos(phi), rel=1e-8)
    assert np.hypot(x, z) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.slow
def test_a_damped_swing_ends_in_the_equilibrium():
    """A rod on a hinge with a spring and a damper: twelve seconds leave 1e-9 of the swing."""
    rod = RigidBody("rod", 2.0, [0.5, 0, 0], 0.1 * np.eye(3), {"root": (0, 0, 0)})
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "root"), axis=(0, 1, 0))
    spring = TorsionSpringDamper(
        first=GROUND, second=At("rod", "root"), axis=(0, 1, 0), stiffness=20.0, damping=2.4
    )
    system = System((Placed(rod),), (hinge,), (spring,), gravity=(0.0, 0.0, -9.81))
    rest = equilibrium(system).system.bodies[0]
    run = Run(duration=12.0, output_step=12.0, step=FixedStep(0.02), tolerances=Tolerances(residual=1e-11))
    assert np.allclose(simulate(system, run).bodies["rod"].rotation[-1], rest.rotation, atol=1e-8)
    assert abs(rest.rotation[2, 0]) > 0.1


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:body 'bar' is linear and rotates at 6 rad")  # its closed form is linear
@pytest.mark.parametrize("form", ["full", "complete"])
def test_a_bar_that_turns_is_stretched(form):
    """`E u'' + rho w^2 (x + u) = 0`, u(0) = 0, u'(L) = 0: `u(L) = tan(k L)/k - L`, `k^2 = rho w^2 / E`."""
    length, modulus, density, rate = 1.0, 1e7, 1000.0, 6.0
    model = solid_model(block(length, 0.1, 0.1, 8, 1, 1, CellType.HEXA8), Isotropic(modulus, 0.0, density))
    bar = flexible_body(
        "bar", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    ).linearized()
    frame = NodalFixedFrame("root")
    body = (
        FullBody(bar, frame)
        if form == "full"
        else reduce(bar, frame, CraigBampton(bar.n - 12), derivatives=NoDerivatives(), loads=NoLoads)
    )
    clamp = PrescribedRotation(name="hub", first=GROUND, second=At("bar", "root"), axis=(0, 0, 1), angle=0.0)
    spin = Spin(rate, (0, 0, 1))
    found = tip(equilibrium(System((Placed(body),), (clamp,)), spin=spin)) - [length, 0.0, 0.0]
    k = np.sqrt(density * rate**2 / modulus)
    assert found == pytest.approx([np.tan(k * length) / k - length, 0.0, 0.0], rel=5e-3, abs=1e-8)


X, TOP = (1, 0, 0), (0, 0, 2.0)


def on_a_tower(joint, mass, offset):
    """A rotor whose centre of mass is `offset` from its axis, on a tower fixed to the ground."""
    eye = np.eye(3)
    tower = RigidBody("tower", 5.0, np.zeros(3), eye, {"base": np.zeros(3), "top": np.array(TOP)})
    rotor = RigidBody("rotor", mass, np.array([0, offset, 0]), eye, {"hub": np.zeros(3)})
    own = {Revolute: {"axis": X}, PrescribedRotation: {"axis": X, "angle": 0.0}}.get(joint, {})
    shaft = joint(first="tower.top", second="rotor.hub", name="shaft", **own)
    base = Fixed(first=GROUND, second="tower.base", name="base")
    return System([tower, Placed(rotor, position=TOP)], [base, shaft])


@pytest.mark.parametrize(
    ("joint", "spin", "fixes"),
    [
        (Fixed, Spin(5.0, X, TOP, ["rotor"]), "rotation x"),
        (Revolute, Spin(5.0, X, bodies=["rotor"]), "position x"),
        (Revolute, Spin(5.0, (0, 0, 1), bodies=["rotor"]), "tilt about y"),
        (Revolute, Spin(5.0, (-1, 0, 0), TOP, ["rotor"]), None),
        (PrescribedRotation, Spin(5.0, X, TOP, ["rotor"]), None),
    ],
)
def test_a_joint_to_what_stands_lets_a_body_spin_or_is_an_error(joint, spin, fixes):
    """A rotor on a tower, whose centre of mass is 0.1 from its axis: it pulls its bearing by m e w^2."""
    mass, offset = 2.0, 0.1
    machine = on_a_tower(joint, mass, offset)
    if fixes:
        with pytest.raises(ModelError, match=f"'shaft' prevents the spin: .* 'tower.top' .* fixes {fixes}"):
            equilibrium(machine, spin=spin)
    else:
        force = equilibrium(machine, spin=spin).joint_forces["shaft"][:3]
        assert np.linalg.norm(force) == pytest.approx(mass * offset * spin.rate**2, rel=1e-9)


@pytest.mark.parametrize(
    ("joint", "spin"), [(Revolute, Spin(5.0, X, TOP)), (PrescribedRotation, Spin(5.0, X, TOP))]
)
def test_a_bearing_in_a_machine_that_rotates_as_a_whole_is_warned_of(joint, spin):
    with pytest.warns(SuppleWarning, match="joint 'base' to the ground .* joint 'shaft' is a bearing about"):
        equilibrium(on_a_tower(joint, 2.0, 0.1), spin=spin)


@pytest.mark.parametrize(("joint", "spin"), [(Fixed, Spin(5.0, X, TOP)), (Revolute, Spin(5.0, X))])
def test_a_machine_on_a_rotating_platform_is_not_warned_of(joint, spin):
    """Without a bearing about the axis of the spin."""
    assert equilibrium(on_a_tower(joint, 2.0, 0.1), spin=spin).joint_forces


@pytest.mark.parametrize("frame", [NodalFixedFrame("root"), MeanAxisFrame()], ids=["fixed", "mean"])
def test_small_deflections_are_those_of_a_beam(frame):
    load = 0.01
    found = equilibrium(cantilever(load, frame), time=1.0)
    expected = load * LENGTH**3 / (3 * BENDING)
    assert tip(found)[2] == pytest.approx(expected, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("reduced", [False, True], ids=["full", "reduced"])
def test_a_run_from_the_equilibrium_stays_there(reduced):
    system = cantilever(2.0, NodalFixedFrame("root"), reduced)
    found = equilibrium(system, time=1.0)
    start = tip(found)
    run = Run(1.05, start=1.0, output_step=0.01, step=FixedStep(5e-3))
    motion = simulate(found.system, run).bodies["strip"]
    moved = abs(motion.coordinates - found.system.bodies[0].coordinates).max()
    assert moved < 1e-7 * abs(start[2])
    assert found.iterations < 30


def test_a_table_has_a_value_between_its_first_and_last_time_only():
    """A spring of 20 N/m hangs 0.5 m lower under the 10 N of the last row; later times are refused."""
    bob = RigidBody("bob", 1.0, np.zeros(3), np.eye(3), {"top": np.zeros(3)})
    slide = Prismatic(first=GROUND, second=At("bob", "top"), axis=(0, 0, 1))
    spring = SpringDamper(
        first=GROUND, second=At("bob", "top"), stiffness=20.0, damping=0.0, anchor=(0, 0, 1), rest_length=1.0
    )
    pull = DeadForce(body="bob", at="top", force=Scaled((0.0, 0.0, -10.0), Table([0.0, 2.0], [0.0, 1.0])))
    system = System((Placed(bob),), (slide,), (spring, pull))
    assert equilibrium(system, time=2.0).system.bodies[0].position[2] == pytest.approx(-0.5, rel=1e-9)
    for time in (-0.1, 4.0):
        with pytest.raises(ModelError, match=rf"its table is from t = 0 to 2, .* at t = {time:g}\."):
            equilibrium(system, time=time)


def test_what_nothing_holds_has_no_equilibrium():
    free = RigidBody(name="stone", mass=1.0, inertia=np.eye(3), centre=np.zeros(3))
    with pytest.raises(ConvergenceError, match="no equilibrium at t = 0 after 20 iterations"):
        equilibrium(System((free,), gravity=(0, 0, -9.81)), search=StaticSearch(max_iterations=20))


def test_a_free_body_that_spins_beside_its_centre_is_told_its_axis():
    stone = RigidBody(name="stone", mass=1.0, inertia=np.diag([1.0, 1.2, 1.6]), centre=[0.1, 0, 0])
    placed = Placed(stone, position=(0, 0.3, 0), rotation=(0, 0, np.pi / 2))
    search = StaticSearch(max_iterations=5)
    with pytest.raises(ConvergenceError, match=r"is 0\.4 from .* the spin the point \(0, 0.4, 0\)"):
        equilibrium(System([placed]), spin=Spin(2.0, (0, 0, 1)), search=search)
    equilibrium(System([placed]), spin=Spin(2.0, (0, 0, 1), point=(0, 0.4, 0)), search=search)


def test_a_search_needs_positive_numbers():
    with pytest.raises(ValueError, match="largest_move of a static search must be positive"):
        StaticSearch(largest_move=0.0)


def wheel(*loads, controllers=()):
    body = Placed(RigidBody("wheel", 2.0, [0, 0, 0], 0.7 * np.eye(3), {"hub": (0, 0, 0)}))
    hinge = Revolute(first="ground", second="wheel.hub", axis=(0, 0, 1))
    return System([body], [hinge], loads, controllers=controllers)


ABOUT_HUB = {"first": "ground", "second": "wheel.hub", "axis": (0, 0, 1)}


@pytest.mark.parametrize("is_driven", [False, True])
def test_a_servo_rests_at_its_set_point_however_fast_that_moves(is_driven):
    """With its rate, 2 rad/s, the damper alone would exceed the limit, and the spring have no effect."""
    law = Sine(0.5, 2 / np.pi)
    servo = AngleServo(**ABOUT_HUB, angle=law, stiffness=10.0, damping=5.0, limit=8.0)
    controller = Controller(reads={}, drives={"servo": servo}, outputs=lambda *_: {"servo": np.zeros(2)})
    machine = wheel(controllers=[controller]) if is_driven else wheel(servo)
    for time in (0.0, 0.3):
        linear = linearize(machine, time=time)
        turned = linear.system.bodies[0].rotation
        np.testing.assert_allclose(np.arctan2(turned[1, 0], turned[0, 0]), 0.5 * np.sin(4 * time), atol=1e-9)
        ratios = [linear.stiffness[0, 0], linear.damping[0, 0]] / linear.mass[0, 0]
        np.testing.assert_allclose(ratios, [10 / 0.7, 5 / 0.7])
    assert linear.system.loads == machine.loads
    assert [own.drives for own in linear.system.controllers] == [own.drives for own in machine.controllers]


def test_weight_across_the_axis_of_a_spin_is_that_of_one_angle_and_unbalance_is_not():
    """As a load that rotates, weight deflects a rotor by g / (w^2 - W^2): a sag at rest is g / w^2."""
    rotor = RigidBody("rotor", 2.0, np.zeros(3), np.diag([0.2, 0.1, 0.1]), {"c": np.zeros(3)})
    ends = {"first": "ground", "second": "rotor.c", "axis": X}
    bearing = JournalBearing(**ends, stiffness=2e4 * np.eye(2))
    heavy = System([rotor], loads=[bearing], gravity=(0.0, 0.0, -9.81))
    assert equilibrium(heavy).system.bodies[0].position == pytest.approx([0, 0, -9.81 / 1e4], abs=1e-12)
    with pytest.warns(ValidityWarning, match="is that of one angle.* set the rate to zero"):
        found = equilibrium(heavy, spin=Spin(60.0, X))
    assert found.system.bodies[0].position == pytest.approx([0, 0, -9.81 / (1e4 - 60.0**2)], abs=1e-9)
    unbalanced = System([rotor], loads=[bearing, Unbalance(first="rotor.c", moment=(0.0, 1e-4, 0.0))])
    found = equilibrium(unbalanced, spin=Spin(60.0, X))
    expected = 1e-4 * 60.0**2 / (2.0 * (1e4 - 60.0**2))
    assert found.system.bodies[0].position == pytest.approx([0, expected, 0], abs=1e-12)


def test_a_servo_drives_a_rotor_at_the_rate_of_its_law():
    """Its damper balances a drag: 3 (5 - 3) = 2 . 3."""
    drive = AngleServo(**ABOUT_HUB, angle=ConstantRate(5.0), stiffness=0.0, damping=3.0)
    drag = AngleServo(**ABOUT_HUB, angle=0.0, stiffness=0.0, damping=2.0)
    found = equilibrium(wheel(drive, drag), spin=Spin(3.0, (0, 0, 1)))
    np.testing.assert_allclose(found.system.bodies[0].angular_velocity, [0, 0, 3.0])


@pytest.mark.parametrize("spin", [None, Spin(3.0, (0, 0, 1))])
def test_a_slide_of_a_rotor_rests_at_its_set_point_however_fast_that_moves(spin):
    """The slide of a steady rotation has no rate, so the damper has no force."""
    body = RigidBody("rotor", 1.0, np.zeros(3), np.eye(3), {"hub": np.zeros(3)})
    ends = {"first": "ground", "second": "rotor.hub", "axis": (0, 0, 1)}
    servo = SlideServo(**ends, slide=ConstantRate(2.0), stiffness=100.0, damping=5.0)
    found = equilibrium(System([body], [Cylindrical(**ends)], [servo]), time=0.4, spin=spin)
    np.testing.assert_allclose(found.system.bodies[0].position, [0, 0, 0.8], atol=1e-8)
