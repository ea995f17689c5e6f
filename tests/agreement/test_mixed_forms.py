"""One machine with a rigid, a reduced, a full and an intrinsic body: rest, modes, motion, resuming."""

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import FullBody, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.equations import joint_residuals
from supple.fem import BeamSection, Isotropic, shell_model
from supple.integrate import (
    AdaptiveStep,
    FixedStep,
    FloatingMotion,
    GeneralizedAlpha,
    Run,
    Solution,
    Statistics,
)
from supple.linearization import linearize, machine_modes
from supple.machine import (
    Controller,
    EndReading,
    Fixed,
    JointReading,
    Placed,
    Revolute,
    Spin,
    SpringDamper,
    System,
    TorqueBetween,
)
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import CLAMPED, intrinsic_body, released
from supple.methods.intrinsic.complete_motion import joined_instants
from supple.methods.intrinsic.joined_machine import joined_machine
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import assemble, equilibrium, simulate

SOFT = {"EA": 1e4, "EI": 5.0, "GJ": 5.0, "mass_per_length": 1.0, "radius": 0.05}
DOWN = np.array([[0, 0, 1.0], [0, 1, 0], [-1.0, 0, 0]])
BACK = np.diag([-1.0, -1.0, 1.0])
G = 9.81
FRAME = NodalFixedFrame("root")


def line(name, n=3, **section):
    """A beam on stations, its root free."""
    return released(intrinsic_body(beam_line(straight(1.0, n), name=name, **(SOFT | section)), CLAMPED, 4))


def beam(name, n=2, EI=5.0, EA=1e4):
    """The same beam of finite elements."""
    E = 1e6
    section = BeamSection(
        Isotropic(E, 0.0, E / EA),
        EA / E,
        EI / E,
        EI / E,
        2 * EI / E,
        5 / 6,
        5 / 6,
        orientation=(0.1, 0.7, 1.0),
    )
    cells = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    mesh = Mesh(straight(1.0, n), {CellType.LINE2: cells}, node_sets={"root": [0], "tip": [n]})
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    return flexible_body(name, shell_model(mesh, section), ends).linearized()


def whole(body):
    """A full body in all its modes, as a reduced one."""
    return reduce(body, FRAME, CraigBampton(body.n - 12), derivatives=NoDerivatives(), loads=NoLoads)


def pendulum(*, full, rate=None):
    """A rigid hub on a pin, a reduced beam on its left; on its right a full one, and a line on that."""
    hub = RigidBody(
        "hub",
        2.0,
        np.zeros(3),
        np.diag([0.1, 0.2, 0.2]),
        {"left": [-0.5, 0, 0], "right": [0.5, 0, 0], "pin": [0.05, 0, 0.1]},
    )
    arm = FullBody(beam("arm"), FRAME) if full else whole(beam("arm"))
    left = reduce(beam("left", 3), FRAME, CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    return System(
        [
            Placed(line("rope"), position=[0.5, 0, -1.0], rotation=DOWN),
            Placed(hub, angular_velocity=None if rate is None else [0, rate, 0]),
            Placed(arm, position=[0.5, 0, 0], rotation=DOWN),
            Placed(left, position=[-0.5, 0, 0], rotation=BACK),
        ],
        [
            Revolute(first="ground", second="hub.pin", axis=(0, 1, 0), name="pin"),
            Fixed(first="hub.left", second="left.root", name="weld"),
            Revolute(first="hub.right", second="arm.root", axis=(0, 1, 0), name="knee"),
            Revolute(first="arm.tip", second="rope.root", axis=(0, 1, 0), name="ankle"),
        ],
        gravity=[0, 0, -G],
    )


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # linear, as in both engines
def test_it_rests_and_vibrates_as_with_a_reduced_body_in_the_place_of_the_full_one():
    """Two engines: the sparse one, and that of lines among floating bodies."""
    mixed, other = (pendulum(full=full) for full in (True, False))
    found, expected = (equilibrium(machine, fulls=()) for machine in (mixed, other))
    assert found.stable
    assert expected.stable
    hub = found.solution.bodies["hub"].rotation[0]
    assert abs(hub[0, 2]) > 0.02  # it does not rest as it is placed
    for name, motion in expected.solution.bodies.items():
        own = found.solution.bodies[name]
        assert own.position == pytest.approx(motion.position, abs=1e-9)
        assert own.rotation == pytest.approx(motion.rotation, abs=1e-9)
    for name, forces in expected.joint_forces.items():
        assert found.joint_forces[name] == pytest.approx(forces, abs=1e-7)
    # The pin carries the weight of all bodies.
    weight = G * sum(placed.body.mass for placed in mixed.bodies)
    assert np.linalg.norm(found.joint_forces["pin"][:3]) == pytest.approx(weight, rel=1e-9)
    modes = [machine_modes(linearize(machine, fulls=()), 8).frequencies for machine in (mixed, other)]
    assert modes[0] == pytest.approx(modes[1], rel=1e-7)


def test_the_truncation_error_sees_a_full_body_by_the_motions_of_its_interfaces():
    """They are its coordinates in the model of joints, also before those of the bodies after it."""
    system = pendulum(full=True)
    rng = np.random.default_rng(0)
    bodies = {}
    for placed in system.bodies[1:]:
        vectors, turns, own = (
            np.zeros((1, 3)),
            np.eye(3)[None],
            rng.normal(size=(1, placed.body.n_coordinates)),
        )
        bodies[placed.body.name] = FloatingMotion(
            vectors, turns, own, vectors, vectors, 2 * own, *[vectors] * 3
        )
    forces = {joint.name: np.zeros((1, joint.n_constraints)) for joint in system.joints}
    solution = Solution(np.zeros(1), bodies, {}, Statistics(), multipliers=forces)
    machine = joined_machine(system, 0.0)
    now, _ = joined_instants(machine, solution, np.zeros(1), ())
    arm, left = system.bodies[2].body, bodies["left"].coordinates
    ends = [bodies["arm"].coordinates @ end.motion.T for end in arm.interfaces]
    assert now.floating.coordinates == pytest.approx(np.hstack([*ends, left]))
    assert now.velocity.shape[1] == machine.arrays.n_floating
    assert now.velocity[:, -left.size :] == pytest.approx(2 * left)


@pytest.mark.slow
def test_it_goes_on_in_the_same_bits():
    machine = pendulum(full=True, rate=1.0)
    parts = []
    run = Run(0.04, 0.01, step=FixedStep(5e-3))
    through = simulate(machine, run, record=parts.append)
    rest = simulate(machine, run, resume=parts[0])
    assert 1 < len(parts)
    assert np.abs(joint_residuals(machine, through)).max() < 1e-10  # of stations that joints hold too
    for name, motion in through.bodies.items():
        for what in ("position", "rotation", "coordinates", "velocity"):
            own = getattr(rest.bodies[name], what)
            assert np.array_equal(own[-1], getattr(motion, what)[-1])


@pytest.mark.filterwarnings("ignore:body '(arm|left)' is linear:supple.errors.ValidityWarning")
@pytest.mark.slow
def test_it_moves_as_with_a_reduced_body_to_second_order():
    apart = []
    for step in (4e-3, 2e-3):
        run = Run(0.2, 0.05, step=FixedStep(step), method=GeneralizedAlpha(0.9))
        mixed, other = (simulate(pendulum(full=full, rate=1.0), run) for full in (True, False))
        travelled = np.ptp(other.bodies["rope"].position, axis=0).max()
        missed = mixed.bodies["rope"].position - other.bodies["rope"].position
        apart.append(np.abs(missed).max() / travelled)
    assert apart[0] < 1e-3
    assert apart[1] < 0.3 * apart[0]


@pytest.mark.slow
def test_stiff_bodies_swing_as_a_compound_pendulum():
    """Frequency sqrt(m g d / I) about the pin, of masses and inertias of all four bodies."""
    stiff = {"EA": 1e7, "EI": 1e5}
    rope, arm, leg = line("rope", GJ=1e5, **stiff), beam("arm", **stiff), beam("leg", **stiff)
    ends = {"left": [-0.5, 0, 0], "right": [0.5, 0, 0], "foot": [0, 0, -0.1], "pin": [0, 0, 0.3]}
    hub = RigidBody("hub", 2.0, np.zeros(3), 0.2 * np.eye(3), ends)
    reduced = reduce(leg, FRAME, CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    machine = System(
        [
            hub,
            Placed(FullBody(arm, FRAME), position=[0.5, 0, 0]),
            Placed(rope, position=[-0.5, 0, 0], rotation=BACK),
            Placed(reduced, position=[0, 0, -0.1], rotation=DOWN),
        ],
        [
            Revolute(first="ground", second="hub.pin", axis=(0, 1, 0), name="pin"),
            Fixed(first="hub.right", second="arm.root", name="right"),
            Fixed(first="hub.left", second="rope.root", name="left"),
            Fixed(first="hub.foot", second="leg.root", name="foot"),
        ],
        gravity=[0, 0, -G],
    )
    twists = rope.line.twists
    grams = [np.diag([2.0, 2.0, 2.0, 0.2, 0.2, 0.2])]
    grams += [arm.rigid_modes.T @ arm.mass @ arm.rigid_modes, twists.T @ rope.line.mass @ twists]
    grams += [leg.rigid_modes.T @ leg.mass @ leg.rigid_modes]
    inertia = depth = 0.0
    for placed, gram in zip(machine.bodies, grams, strict=True):
        turn = np.array([0, 1.0, 0])
        moving = np.cross(turn, placed.position - [0, 0, 0.3])
        twist = np.concatenate([moving @ placed.rotation, turn @ placed.rotation])
        inertia += twist @ gram @ twist
        # Work of the weights along z, of second order in the angle: their moment about the pin.
        centre = placed.position + placed.rotation @ placed.body.centre_of_mass
        depth += placed.body.mass * (0.3 - centre[2])
    frequency = machine_modes(linearize(machine, fulls=()), 1).frequencies[0]
    assert frequency == pytest.approx(np.sqrt(G * depth / inertia), rel=2e-5)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # linear, as in both engines
def test_a_machine_that_turns_has_the_modes_of_the_other_engine():
    def rotor(*, full):
        hub = RigidBody(
            "hub",
            2.0,
            np.zeros(3),
            np.diag([0.1, 0.2, 0.2]),
            {"left": [-0.1, 0, 0], "right": [0.1, 0, 0], "pin": [0, 0, 0.1]},
        )
        arm = FullBody(beam("arm"), FRAME) if full else whole(beam("arm"))
        return System(
            [
                Placed(line("rope"), position=[-0.1, 0, 0], rotation=BACK),
                hub,
                Placed(arm, position=[0.1, 0, 0]),
            ],
            [
                Revolute(first="ground", second="hub.pin", axis=(0, 0, 1), name="pin"),
                Fixed(first="hub.left", second="rope.root", name="weld"),
                Fixed(first="hub.right", second="arm.root", name="other weld"),
            ],
            [SpringDamper(first="rope.tip", second="arm.tip", stiffness=3.0)],
        )

    spin = Spin(3.0, axis=(0, 0, 1))
    modes = [
        machine_modes(linearize(rotor(full=full), spin=spin, fulls=()), 6).frequencies
        for full in (True, False)
    ]
    first, second = (each[each > 1e-3][:4] for each in modes)
    assert first == pytest.approx(second, rel=1e-7)
    rest = equilibrium(rotor(full=True), spin=spin, fulls=())
    # Of what turns steadily the acceleration is w^2 r.
    assert rest.solution.bodies["rope"].acceleration[0] == pytest.approx([0.9, 0, 0], abs=1e-12)


def servo_machine(body):
    """A hinge and a motor that holds an angle, with an integral of what the tip lacks."""
    own = Controller(
        reads={"hinge": JointReading("hinge"), "tip": EndReading("beam.tip")},
        drives={"motor": TorqueBetween(first="ground", second="beam.root", axis=(0, 1, 0), torque=0.0)},
        outputs=lambda _, read, z: {
            "motor": 40.0 * (0.3 - read["hinge"].angle) - read["hinge"].rate + 2.0 * z[0]
        },
        rates=lambda _, read, z: jnp.stack([-read["tip"].point[2] - 0.2 - z[0]]),
        initial=[0.0],
        name="servo",
    )
    hinge = Revolute(first="ground", second="beam.root", axis=(0, 1, 0), name="hinge")
    return System([body], [hinge], controllers=[own], gravity=[0, 0, -G])


@pytest.mark.slow
def test_a_controlled_line_rests_as_a_rigid_rod():
    """Controllers of intrinsic bodies at rest and in modes, and adaptive steps of joined ones."""
    body = line("beam", EA=1e6, EI=1e5, GJ=1e5)
    gram = body.line.twists.T @ body.line.mass @ body.line.twists
    centre = np.array([0.5, 0, 0])
    inertia = gram[3:, 3:] - np.diag([0, 0.25, 0.25])
    rod = RigidBody("beam", 1.0, np.zeros(3), inertia, {"root": -centre, "tip": centre})
    machines = [servo_machine(each) for each in (body, Placed(rod, position=centre))]
    rests = [equilibrium(machine) for machine in machines]
    rotations = [rest.solution.bodies["beam"].rotation[0] for rest in rests]
    assert rotations[0] == pytest.approx(rotations[1], abs=1e-4)
    states = [rest.system.controllers[0].initial[0] for rest in rests]
    assert states[0] == pytest.approx(states[1], abs=1e-4)
    slowest = [machine_modes(linearize(machine), 2).eigenvalues[:2] for machine in machines]
    assert slowest[0] == pytest.approx(slowest[1], rel=1e-3)


@pytest.mark.slow
def test_adaptive_steps_of_joined_lines_meet_fixed_ones():
    machine = System(
        [line("a"), Placed(line("b"), position=[1.0, 0, 0])],
        [
            Revolute(first="ground", second="a.root", axis=(0, 1, 0), name="hinge"),
            Revolute(first="a.tip", second="b.root", axis=(0, 1, 0), name="elbow"),
        ],
        gravity=[0, 0, -G],
    )
    fixed, adaptive = (
        simulate(machine, Run(0.2, 0.1, step=step, method=GeneralizedAlpha(0.9)))
        for step in (FixedStep(1e-3), AdaptiveStep(1e-6))
    )
    travelled = np.ptp(fixed.bodies["b"].position, axis=0).max()
    missed = np.abs(adaptive.bodies["b"].position - fixed.bodies["b"].position).max()
    assert missed < 1e-3 * travelled
    assert adaptive.statistics.largest_error <= 1e-6


@pytest.mark.slow
def test_a_machine_with_a_line_is_assembled():
    """A gap at the elbow is closed by the least rigid motion."""
    hinge = Revolute(first="ground", second="a.root", axis=(0, 1, 0), name="hinge")
    elbow = Revolute(first="a.tip", second="b.root", axis=(0, 1, 0), name="elbow")
    apart = System([line("a"), Placed(line("b"), position=[1.0, 0, 0.1])], [hinge, elbow])
    found = assemble(apart)
    a, b = found.system.bodies
    assert a.position + a.rotation @ [1.0, 0, 0] == pytest.approx(b.position, abs=1e-9)
