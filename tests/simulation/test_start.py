"""Going on from an instant of a motion: the same machine, other bases and forms of bodies, other units."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.bar_of_every_form import DENSITY, LENGTH, MODULUS, WIDTH, bar_as, elastic
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

import supple as sp
from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import BasisWarning, ModelError, StartWarning
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, FloatingMotion, Run, Solution, Statistics
from supple.machine import (
    At,
    Contact,
    Controller,
    Fixed,
    JointReading,
    Placed,
    Revolute,
    RigidPlane,
    RigidSphere,
    System,
    TorqueBetween,
)
from supple.mesh import CellType, block
from supple.quantities import EnergySensor
from supple.reduction import CraigBampton, NoDerivatives, Rubin, reduce
from supple.simulation import Start, simulate
from supple.simulation.recorded_columns import measured_columns

HINGE = Revolute(first="ground", second="bar.root", axis=(0, 1, 0), name="hinge")
GRAVITY = [0.0, 0.0, -9.81]
ROOT = At("bar", "root")


def hinged(body, **more):
    """The bar on its hinge, level."""
    return System([Placed(body)], [HINGE], gravity=GRAVITY, **more)


def an_instant(body, seed=3):
    """A bar that is somewhere, bent, turning and vibrating, as a motion of one instant."""
    random = np.random.default_rng(seed)
    r = body.n_coordinates
    q, dq = 1e-3 * random.standard_normal((2, 1, r)) if r else np.zeros((2, 1, 0))
    if isinstance(body, FullBody):  # within the conditions of its frame
        q, dq = (each @ within(body).T for each in (q, dq))
    pose = np.array([[0.3, 0.2, -0.1]]), Rotation.from_rotvec([[0.2, -0.7, 0.4]]).as_matrix()
    v, w, still = np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, -1.0, 0.7]]), np.zeros((1, 3))
    motion = FloatingMotion(*pose, q, v, w, dq, still, still, np.zeros_like(q))
    columns = measured_columns(System([Placed(body)]))
    return Solution(np.array([2.5]), {"bar": motion}, {}, Statistics(), columns=columns)


def within(body):
    """Projector on the deformations that a frame allows."""
    rigid, conditions = body.body.rigid_modes, body.frame.constraint(body.body)
    return np.eye(len(rigid)) - rigid @ np.linalg.solve(conditions @ rigid, conditions)


def nodes_of(body, solution):
    """Positions and velocities (N, 3) of all nodes at its last instant."""
    motion = solution.bodies["bar"].at(np.array([-1]))
    moving = body.node_motion(motion, np.arange(len(body.nodes)))
    return moving.position[0], moving.velocity[0]


def as_motion(placed):
    """The instant at which a body is placed."""
    still, q = np.zeros((1, 3)), placed.coordinates[None]
    return Solution(
        np.zeros(1),
        {
            "bar": FloatingMotion(
                placed.position[None],
                placed.rotation[None],
                q,
                placed.velocity[None],
                placed.angular_velocity[None],
                placed.coordinate_rates[None],
                still,
                still,
                np.zeros_like(q),
            )
        },
        {},
        Statistics(),
    )


@pytest.mark.parametrize(
    "form",
    [
        "reduced",
        *(pytest.param(form, marks=pytest.mark.slow) for form in ("rigid", "full", "intrinsic", "modal")),
    ],
)
def test_a_run_gone_on_with_is_the_uninterrupted_one_to_second_order(form):
    body, left = bar_as(form), []
    steps = (1e-3, 5e-4) if form != "modal" else (1e-4, 5e-5)
    for step in steps:
        machine, control = hinged(body), FixedStep(step)
        through = simulate(machine, Run(0.1, 0.025, step=control))
        found = Start(through, 0.05).place(machine)
        again = simulate(found.system, Run(0.05, 0.025, step=control, start=found.time))
        whole, rest = (body.positions(each.bodies["bar"]) for each in (through, again))
        assert rest[0] == pytest.approx(whole[2], abs=1e-14)
        assert again.times == pytest.approx(through.times[2:], abs=1e-15)
        left.append(np.abs(rest[-1] - whole[-1]).max())
        pivot = body.interface_motion(again.bodies["bar"], "root").position
        assert np.abs(pivot).max() < 1e-13  # the hinge has not moved
        # Joint forces are those of the same state, to what rates miss of the joint's own.
        assert again.joint_forces["hinge"][0] == pytest.approx(through.joint_forces["hinge"][2], abs=1e-2)
    assert left[0] < 1e-6 * LENGTH
    assert left[0] / left[1] > 3.0  # 4: second order


def test_reduced_again_the_columns_are_others_and_the_shape_is_the_same():
    body = bar_as("reduced")
    solution = an_instant(body)
    flipped = replace(
        body,
        gram=np.zeros_like(body.gram) + body.gram,
        nodal_basis=body.nodal_basis @ np.diag([-1.0, *np.ones(body.r - 1)]),
        interfaces=tuple(
            replace(each, motion=each.motion @ np.diag([-1.0, *np.ones(body.r - 1)]))
            for each in body.interfaces
        ),
        cubic=None,
        quartic=None,
        condensed=None,
    )
    expected = solution.bodies["bar"].coordinates[0].copy()
    expected[0] *= -1
    with pytest.raises(ModelError, match="give the machine of the motion"):
        Start(solution).place(System([Placed(flipped)]))
    moved = replace(body, cubic=None, quartic=None, condensed=None)
    found = Start(solution, machine=System([Placed(moved)])).place(System([Placed(flipped)]))
    assert found.system.bodies[0].coordinates == pytest.approx(expected, abs=1e-14)
    assert found.losses["bar"].relative < 1e-12
    assert found.losses["bar"].rate < 1e-12


@pytest.mark.parametrize("frame", [MeanAxisFrame(), NodalFixedFrame("tip")])
def test_on_another_basis_the_loss_is_stated_and_interfaces_stay(frame):
    body = bar_as("reduced")
    solution = an_instant(body)
    other = reduce(elastic(), frame, Rubin(3), derivatives=NoDerivatives())
    with pytest.warns(BasisWarning, match=r"lacks .* % of the initial deformation"):
        found = Start(solution, 2.5, System([Placed(body)])).place(System([Placed(other)]))
    loss, placed = found.losses["bar"], found.system.bodies[0]
    before, after = solution.bodies["bar"], as_motion(placed).bodies["bar"]
    for end in ("root", "tip"):
        ours, theirs = (
            each.interface_motion(motion, end) for each, motion in ((other, after), (body, before))
        )
        assert ours.position == pytest.approx(theirs.position, abs=1e-12)
        assert ours.velocity == pytest.approx(theirs.velocity, abs=1e-9)
    # The stated loss is the motion missing at the nodes, in the norm of the mass.
    apart = nodes_of(other, as_motion(placed))[0] - nodes_of(body, solution)[0]
    full = elastic()
    weights = full.nodal_mass
    rms = np.sqrt(apart.ravel() @ (weights @ apart.ravel()) / body.mass)
    assert loss.rms == pytest.approx(rms, rel=1e-3)
    assert loss.gap < 1e-12


@pytest.mark.parametrize("source", ["reduced", "full"])
@pytest.mark.parametrize("frame", [MeanAxisFrame(), NodalFixedFrame("tip")])
def test_with_all_coordinates_the_motion_in_space_is_the_same(source, frame):
    body, full = bar_as(source), FullBody(elastic(), frame)
    solution = an_instant(body)
    placed = Start(solution, machine=System([Placed(body)])).place(System([Placed(full)])).system.bodies[0]
    here, there = nodes_of(full, as_motion(placed)), nodes_of(body, solution)
    # Ends are rigid pieces, whose rotation is linear: a frame that turns differs by half its square, times an
    # arm of at most a diagonal of the section.
    q = solution.bodies["bar"].coordinates[0]
    angle = max(np.linalg.norm((each.motion @ q)[3:]) for each in body.interfaces)
    allowed = 1e-12 if frame == MeanAxisFrame() else np.sqrt(2) * WIDTH * angle**2 / 2
    assert allowed < 4e-4
    assert here[0] == pytest.approx(there[0], abs=allowed)
    assert here[1] == pytest.approx(there[1], abs=40 * allowed)
    conditions = frame.constraint(full.body)
    assert np.abs(conditions @ placed.coordinates).max() < 1e-12
    assert np.abs(conditions @ placed.coordinate_rates).max() < 1e-10


def test_a_state_in_metres_and_seconds_goes_on_in_millimetres_and_milliseconds():
    body = bar_as("reduced")
    mm = flexible_body(
        "bar",
        solid_model(
            block(1e3 * LENGTH, 1e3 * WIDTH, 1e3 * WIDTH, 8, 1, 1, CellType.HEXA8),
            Isotropic(1e-9 * MODULUS, 0.0, 1e-9 * DENSITY),
        ),
        [RigidInterface("root", "root"), RigidInterface("tip", "tip")],
    )
    other = reduce(mm, MeanAxisFrame(), CraigBampton(6), derivatives=NoDerivatives())
    solution = an_instant(body)
    start = Start(solution, 2500.0, System([Placed(body)]), length=1e3, duration=1e3)
    found = start.place(System([Placed(other)]))
    assert found.time == 2500.0
    assert found.losses["bar"].relative < 1e-10
    here, there = nodes_of(other, as_motion(found.system.bodies[0])), nodes_of(body, solution)
    assert here[0] == pytest.approx(1e3 * there[0], rel=1e-10)
    assert here[1] == pytest.approx(there[1], rel=1e-9)  # mm/ms
    with pytest.raises(ModelError, match="another mesh"):
        Start(solution, machine=System([Placed(body)])).place(System([Placed(other)]))


@pytest.mark.parametrize(
    "form",
    [
        "rigid",
        "reduced",
        *(pytest.param(form, marks=pytest.mark.slow) for form in ("full", "intrinsic", "modal")),
    ],
)
def test_a_latch_stops_the_root_and_the_rest_goes_on_vibrating(form):
    """A bar that rotates about its hinge is locked there: an impact without rebound, of all freedoms.

    v = v_0 - M^-1 G^T (G M^-1 G^T)^-1 G v_0 with the mass M of the elements and the rows G of the root.
    """
    body, rate = bar_as(form), 0.1
    still, q = np.zeros((1, 3)), np.zeros((1, body.n_coordinates))
    turning = np.array([[0.0, rate, 0.0]])
    if form == "intrinsic":
        swung = System([Placed(body, angular_velocity=turning[0])], [HINGE])
        solution = simulate(swung, Run(1e-4, 1e-4, step=FixedStep(1e-4)))
    else:
        motion = FloatingMotion(still, np.eye(3)[None], q, still, turning, q, still, still, q)
        columns = measured_columns(System([Placed(body)]))
        solution = Solution(np.zeros(1), {"bar": motion}, {}, Statistics(), columns=columns)
    latch = Fixed(first="ground", second="bar.root", name="latch")
    found = Start(solution, solution.times[0]).place(System([Placed(body)], [latch]))
    run = Run(1e-5, 1e-5, step=FixedStep(1e-5))
    with pytest.warns(StartWarning, match=r"earlier motion, which an impact without rebound changes"):
        after = simulate(found.system, run)
    kinetic = EnergySensor("energy").values(found.system, after)[0, 0]

    mass, rows = elastic().mass, elastic().interface("root").motion.toarray()
    before = elastic().rigid_modes @ [0, 0, 0, 0, rate, 0]
    soft = spsolve(csc_array(mass), csc_array(rows.T)).toarray()
    locked = before - soft @ np.linalg.solve(rows @ soft, rows @ before)
    expected = 0.0 if form == "rigid" else locked @ (mass @ locked) / 2
    assert kinetic == pytest.approx(expected, rel=1e-6 if form == "full" else 0.02, abs=1e-12)


def test_what_cannot_go_on_is_refused():
    body, rigid = bar_as("reduced"), bar_as("rigid")
    solution = an_instant(body)

    def refused(words, *bodies, start=None):
        with pytest.raises(ModelError, match=words):
            (start or Start(solution)).place(System([Placed(each) for each in bodies]))

    refused(r"body 'other' has no motion to start from.*there are: bar", bar_as("reduced", "other"))
    refused("was elastic and is rigid", rigid)
    refused("was rigid and is elastic", body, start=Start(an_instant(rigid)))
    refused("explicit elements", bar_as("finite elements"))
    refused("keep the form of the motion", bar_as("intrinsic"))
    refused("give the machine of the motion", bar_as("full"))
    unknown = replace(solution, columns={})
    refused("the basis of the motion of body", body, start=Start(unknown))
    other = reduce(elastic(), MeanAxisFrame(), CraigBampton(6), derivatives=NoDerivatives())
    wrong = replace(other, nodal_basis=-other.nodal_basis, full=None)
    refused("has other columns", bar_as("full"), start=Start(solution, machine=System([Placed(wrong)])))
    known = Start(solution, machine=System([Placed(body)]))
    refused("read as reduced", replace(wrong, name="bar"), start=known)
    coarser = solid_model(block(LENGTH, WIDTH, WIDTH, 4, 1, 1, CellType.HEXA8), Isotropic(1.0, 0.0, 1.0))
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    refused("another mesh", FullBody(flexible_body("bar", coarser, ends), MeanAxisFrame()), start=known)
    with pytest.raises(ModelError, match=r"2\.4 is not among those from 2\.5 to 2\.5"):
        Start(solution, 2.4)


def test_obstacles_go_on_from_where_they_are():
    """A free ball and a driven plane; a wall at rest stays where it is given."""
    body = bar_as("modal")
    wall, tip = RigidPlane((0.0, 0.0, -5.0), (0.0, 0.0, 1.0)), At("bar", "tip")
    ball = RigidSphere((2.0, 0.0, 1.0), 0.1, velocity=(0.0, 0.0, -3.0), mass=0.5)
    ram = RigidPlane((9.0, 0.0, 0.0), (-1.0, 0.0, 0.0), velocity=(-2.0, 0.0, 0.0))
    system = System([Placed(body)], contacts=[Contact(tip, each) for each in (wall, ball, ram)])
    states = [np.zeros(6), [0.0, 0.1, -0.4, 0.0, 1.0, 2.0], [-5.0, 0.0, 0.0, -2.0, 0.0, 0.0]]
    solution = replace(an_instant(body), series={"obstacles": np.concatenate(states)[None]})
    found = [each.obstacle for each in Start(solution).place(system).system.rigid_contacts]
    assert found[0] == wall
    assert found[1] == replace(ball, centre=(2.0, 0.1, 0.6), velocity=(0.0, 1.0, 2.0))
    assert found[2] == replace(ram, point=(4.0, 0.0, 0.0))
    fewer = replace(system, contacts=system.contacts[1:])
    with pytest.raises(ModelError, match=r"2 contacts with rigid obstacles, of which some move, .* has 3"):
        Start(solution).place(fewer)


def test_a_controller_has_its_states_at_the_end_of_a_run_alone():
    motor = TorqueBetween(first="ground", second=ROOT, axis=(0, 1, 0))
    own = Controller(
        reads={"hinge": JointReading("hinge")},
        drives={"motor": motor},
        outputs=lambda _t, _r, z: {"motor": z[0]},
        rates=lambda _t, readings, _z: readings["hinge"].rate[None],
        initial=[0.0],
    )
    machine = hinged(bar_as("rigid"), controllers=[own])
    through = simulate(machine, Run(0.1, 0.05, step=FixedStep(1e-2)))
    (continued_from,) = Start(through).place(machine).system.controllers
    angle = through.engine_state["control.states.controller"][0]
    assert abs(angle) > 1e-3
    assert continued_from.initial == pytest.approx([angle], abs=0)
    with pytest.warns(StartWarning, match="restarts"):
        (anew,) = Start(through, 0.05).place(machine).system.controllers
    assert anew.initial == pytest.approx([0.0])


def test_a_controller_goes_on_with_the_revolutions_that_it_counted():
    """A rotor at its set-point, four revolutions away, stays there; without the count it would turn on."""
    rotor = RigidBody("rotor", 1.0, np.zeros(3), np.eye(3), {"hub": np.zeros(3)})
    hinge = Revolute(first="ground", second="rotor.hub", axis=(0, 0, 1), name="hinge")
    target, rate = 8 * np.pi + 0.3, 10.0
    servo = Controller(
        reads={"hinge": JointReading("hinge")},
        drives={"motor": TorqueBetween(first="ground", second="rotor.hub", axis=(0, 0, 1))},
        outputs=lambda _, reads, __: {
            "motor": rate**2 * (target - reads["hinge"].angle) - 2 * rate * reads["hinge"].rate
        },
    )
    machine = System([rotor], [hinge], controllers=[servo])
    through = simulate(machine, Run(2.0, 1.0, step=FixedStep(2e-3)))
    begun = Start(through).place(machine)
    angle = begun.system.controllers[0].reads["hinge"].near
    assert angle == pytest.approx(target, abs=1e-5)
    went_on = simulate(begun.system, Run(0.1, 0.05, step=FixedStep(2e-3), start=begun.time))
    turned = Rotation.from_matrix(went_on.bodies["rotor"].rotation).as_rotvec()[:, 2]
    assert turned == pytest.approx([0.3] * 3, abs=1e-5)
    with pytest.warns(StartWarning, match="revolutions of the joint angles"):
        Start(through, 1.0).place(machine)


def test_controllers_in_another_order_keep_their_own_states():
    def counter(name, rate):
        return Controller(
            reads={},
            drives={"motor": TorqueBetween(first="ground", second=ROOT, axis=(0, 1, 0))},
            outputs=lambda *_: {"motor": jnp.zeros(())},
            rates=lambda *_: jnp.array([rate]),
            initial=[0.0],
            name=name,
        )

    up, down = counter("up", 1.0), counter("down", -1.0)
    through = simulate(hinged(bar_as("rigid"), controllers=[up, down]), Run(0.1, 0.1, step=FixedStep(1e-2)))
    turned = hinged(bar_as("rigid"), controllers=[down, up])
    began = {own.name: own.initial.item() for own in Start(through).place(turned).system.controllers}
    assert began == pytest.approx({"down": -0.1, "up": 0.1})
    other = hinged(bar_as("rigid"), controllers=[counter("other", 1.0)])
    with pytest.warns(StartWarning, match="controller 'other' restarts .* by the names of the controllers"):
        Start(through).place(other)


def test_it_is_in_the_front_door():
    assert sp.Start is Start
