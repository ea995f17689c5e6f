"""Joints between intrinsic bodies and others: closed forms, other methods, conservation, what is refused."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight
from scipy.integrate import solve_ivp

from supple.body import ModalDamping, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import BeamSection, Isotropic, shell_model
from supple.integrate import AdaptiveStep, FixedStep, GeneralizedAlpha, Run, RungeKutta4
from supple.machine import (
    Ball,
    DeadForce,
    Fixed,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    Revolute,
    System,
)
from supple.mesh import CellType, Mesh
from supple.methods.intrinsic import (
    BALL,
    CLAMPED,
    FREE,
    condensed_line,
    intrinsic_body,
    intrinsic_modes,
    released,
)
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate

SOFT = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}
STIFF = {"EA": 1e6, "EI": 1e5, "GJ": 1e5, "mass_per_length": 1.0, "radius": 0.05}
G = 9.81
GRAVITY = np.array([0, 0, -G])
UNDAMPED = ModalDamping(1e-12)
"""Damping in name alone: all double pendulums here are one machine to the compiler."""
HINGE = Revolute(first="ground", second="a.root", axis=(0, 1, 0), name="hinge")
ELBOW = Revolute(first="a.tip", second="b.root", axis=(0, 1, 0), name="elbow")


def beam(name, *, support=CLAMPED, n=4, n_modes=None, damping=None, **section):
    """A beam of length 1 along x, its root free."""
    line = beam_line(straight(1.0, n), name=name, **(SOFT | section))
    return released(intrinsic_body(line, support, n_modes, damping=damping))


def double_pendulum(step):
    """Two soft beams in a line that turn about the hinge and the elbow, at different speeds."""
    bodies = [beam(name, n_modes=4, damping=UNDAMPED) for name in "ab"]
    placed = [
        Placed(bodies[0], angular_velocity=[0, 0.5, 0]),
        Placed(bodies[1], position=[1.0, 0, 0], velocity=[0, 0, -0.5], angular_velocity=[0, -2.0, 0]),
    ]
    run = Run(0.5, 0.05, step=FixedStep(step), method=GeneralizedAlpha(1.0))
    return bodies, simulate(System(placed, [HINGE, ELBOW], gravity=0 * GRAVITY), run)


def energy(bodies, solution):
    """Of strain and motion, (t,)."""
    total = 0.0
    for body in bodies:
        motion = solution.bodies[body.name]
        q2 = body.forces_of(motion.coordinates)
        total = total + 0.5 * (np.sum(motion.rates**2, axis=1) + np.sum(q2**2, axis=1))
    return total


def test_released_modes_hold_those_of_the_support_and_of_the_free_body():
    line = beam_line(straight(1.0, 6), **SOFT)
    body = released(intrinsic_body(line, CLAMPED))
    # With all modes of the clamped line nothing is missing.
    exact = intrinsic_modes(line, FREE).omega
    assert body.modes.omega[6:] == pytest.approx(exact[6:], rel=1e-7)
    assert np.abs(body.modes.omega[:6]).max() == 0
    # The clamped shapes are in its span: the root at rest, a moment at the root.
    few = intrinsic_body(line, CLAMPED, 5)
    free = released(few)
    shapes = few.modes.velocities.reshape(-1, few.n_coordinates)
    weights = free.modes.momenta.reshape(line.n * 6, -1).T @ shapes
    assert free.modes.velocities.reshape(line.n * 6, -1) @ weights == pytest.approx(shapes, abs=1e-9)


@pytest.mark.slow
def test_a_ball_joint_holds_a_free_root_as_a_support_does():
    """The same steps to round-off: modes of a support and rigid motion are those of the free body."""
    held = intrinsic_body(beam_line(straight(1.0, 4), **SOFT), BALL)
    joint = Ball(first="ground", second="beam.root")
    run = Run(0.2, 0.1, step=FixedStep(4e-3), method=GeneralizedAlpha(1.0))
    tips = []
    for body in (held, released(held)):
        system = System([Placed(body, angular_velocity=[0.5, 1.0, 0.2])], [joint], gravity=GRAVITY)
        tips.append(body.positions(simulate(system, run).bodies["beam"], [4])[:, 0])
    assert tips[1] == pytest.approx(tips[0], abs=1e-10)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_stiff_beams_are_the_double_pendulum():
    """Against Lagrange's equations of two rods, their inertia as lumped."""
    bodies = [beam(name, n_modes=4, damping=ModalDamping(0.7), **STIFF) for name in "ab"]
    system = System([bodies[0], Placed(bodies[1], position=[1.0, 0, 0])], [HINGE, ELBOW], gravity=GRAVITY)
    solution = simulate(system, Run(0.6, 0.1, step=FixedStep(2e-3), method=GeneralizedAlpha(0.9)))
    twist = bodies[0].line.twists[:, 4]
    root = float(twist @ bodies[0].line.mass @ twist)

    def rates(_, y):
        a, b, u, v = y
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[root + 1.0, 0.5 * c], [0.5 * c, root]])
        force = [-0.5 * s * v**2 + G * 1.5 * np.cos(a), 0.5 * s * u**2 + G * 0.5 * np.cos(b)]
        return [u, v, *np.linalg.solve(mass, force)]

    exact = solve_ivp(rates, (0, 0.6), [0, 0, 0, 0], t_eval=solution.times, rtol=1e-10, atol=1e-12).y
    elbow = np.column_stack([np.cos(exact[0]), 0 * exact[0], -np.sin(exact[0])])
    tip = elbow + np.column_stack([np.cos(exact[1]), 0 * exact[1], -np.sin(exact[1])])
    found = bodies[1].positions(solution.bodies["b"], [0, 4])
    assert found[:, 0] == pytest.approx(elbow, abs=1e-3)
    assert found[:, 1] == pytest.approx(tip, abs=1e-3)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_joints_stay_closed_and_energy_is_kept_to_the_order_of_the_step():
    drifts = []
    for step in (4e-3, 2e-3):
        bodies, solution = double_pendulum(step)
        drifts.append(np.abs(energy(bodies, solution) / energy(bodies, solution)[0] - 1).max())
        tip = bodies[0].places(solution.bodies["a"])[1][:, -1]
        root = bodies[1].places(solution.bodies["b"])[1][:, 0]
        assert np.abs(tip - root).max() < 1e-10
    assert drifts[1] < 1e-4
    assert np.log2(drifts[0] / drifts[1]) > 1.7


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_a_rigid_hub_turns_a_blade_that_is_fixed_to_it():
    """Stiff: torque over inertia; the hinge carries no moment about its axis, the weld the blade's."""
    hub = RigidBody("hub", 2.0, np.zeros(3), 0.1 * np.eye(3), {"axle": np.zeros(3), "flange": [0.2, 0, 0]})
    blade = beam("blade", n_modes=6, damping=ModalDamping(0.7), **STIFF)
    joints = [
        Revolute(first="ground", second="hub.axle", axis=(0, 0, 1), name="hinge"),
        Fixed(first="hub.flange", second="blade.root", name="weld"),
    ]
    motor = FollowerTorque(first="hub.axle", torque=(0, 0, 3.0))
    system = System([hub, Placed(blade, position=[0.2, 0, 0])], joints, [motor])
    solution = simulate(system, Run(0.5, 0.1, step=FixedStep(2e-3), method=GeneralizedAlpha(0.9)))
    twist = blade.line.twists
    about = twist[:, 5] + 0.2 * twist[:, 1]
    inertia = float(about @ blade.line.mass @ about)
    rate = 3.0 / (0.1 + inertia)
    hub_motion = solution.bodies["hub"]
    assert hub_motion.angular_velocity[:, 2] == pytest.approx(rate * solution.times, rel=2e-3)
    weld = solution.joint_forces["weld"]
    # Along the radius m r w^2, across m r w'; the moment at the root less the arm of the flange.
    w = rate * solution.times[1:]
    assert weld[1:, 0] == pytest.approx(-0.7 * w**2, rel=5e-3)
    assert weld[1:, 1] == pytest.approx(0.7 * rate, rel=5e-3)
    assert weld[1:, 5] == pytest.approx((inertia - 0.2 * 0.7) * rate, rel=5e-3)
    assert np.abs(solution.joint_forces["hinge"][:, 5]).max() < 1e-9


@pytest.mark.slow
def test_a_prescribed_turn_moves_a_free_root_as_it_moves_a_clamped_one():
    drive = PrescribedRotation(
        first="ground", second="beam.root", axis=(0, 0, 1), angle=lambda t: 20 * t**2, name="drive"
    )
    line = beam_line(straight(1.0, 4), **SOFT)
    clamped = intrinsic_body(line, CLAMPED)
    run = Run(0.3, 0.1, step=FixedStep(1e-3), method=GeneralizedAlpha(1.0))
    tips = [
        body.positions(simulate(System([body], [drive]), run).bodies["beam"], [4])[:, 0]
        for body in (clamped, released(clamped))
    ]
    assert np.abs(tips[1] - tips[0]).max() < 2e-4


@pytest.mark.slow
def test_a_beam_held_at_both_ends_sags_as_the_formula_says():
    """P L^3 / 192 E I at the middle of a beam that two welds hold; small, so that it does not stretch."""
    body = released(
        intrinsic_body(
            beam_line(straight(1.0, 8), **SOFT),
            CLAMPED,
            None,
            stations={"middle": 4},
            damping=ModalDamping(0.9),
        )
    )
    joints = [Fixed(first="ground", second="beam.root"), Fixed(first="ground", second="beam.tip", name="far")]
    system = System([body], joints, [DeadForce(at="beam.middle", force=(0, 0, 0.1))])
    solution = simulate(system, Run(2.0, 1.0, step=FixedStep(0.02), method=GeneralizedAlpha(0.8)))
    sag = body.positions(solution.bodies["beam"], [4])[-1, 0, 2]
    assert sag == pytest.approx(0.1 / 192, rel=2e-2)
    assert solution.joint_forces["far"][-1, 2] == pytest.approx(-0.05, rel=1e-2)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_an_arm_in_a_floating_frame_carries_an_intrinsic_beam():
    """Small motion, so that the arm may as well be intrinsic: the same swing of the tip."""
    points = straight(1.0, 4)
    cells = np.column_stack([np.arange(4), np.arange(1, 5)])
    section = BeamSection(Isotropic(1e6, 0.0, 100.0), 0.01, 1e-4, 1e-4, 2e-4, orientation=(0, 0, 1))
    mesh = Mesh(points, {CellType.LINE2: cells}, node_sets={"root": [0], "tip": [4]})
    ends = [RigidInterface("root", "root"), RigidInterface("tip", "tip")]
    model = shell_model(mesh, section)
    floating = reduce(
        flexible_body("a", model, ends),
        NodalFixedFrame("root"),
        CraigBampton(8),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    own = condensed_line("a", points, model.stiffness, model.mass)
    intrinsic = released(intrinsic_body(own, CLAMPED, 14))
    beams = beam("b", n_modes=8, EA=1e4, EI=100.0, GJ=100.0)
    run = Run(0.2, 0.02, step=FixedStep(2e-3), method=GeneralizedAlpha(0.9))
    tips = []
    for arm in (floating, intrinsic):
        clamp = Fixed(first="ground", second="a.root", name="clamp")
        system = System([arm, Placed(beams, position=[1.0, 0, 0])], [clamp, ELBOW], gravity=GRAVITY / 100)
        tips.append(beams.positions(simulate(system, run).bodies["b"], [0])[:, 0, 2])
    assert np.abs(tips[0]).max() > 1e-4
    assert tips[1] == pytest.approx(tips[0], abs=0.02 * np.abs(tips[0]).max())


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_a_run_in_two_parts_is_the_run_in_one():
    bodies = [beam(name, n_modes=4, damping=UNDAMPED) for name in "ab"]
    system = System([bodies[0], Placed(bodies[1], position=[1.0, 0, 0])], [HINGE, ELBOW], gravity=GRAVITY)
    run = Run(0.2, 0.02, step=FixedStep(4e-3), method=GeneralizedAlpha(0.9))
    parts = []
    whole = simulate(system, run, record=parts.append)
    resumed = simulate(system, run, resume=parts[5])
    assert np.array_equal(whole.bodies["b"].rates[6:], resumed.bodies["b"].rates)


@pytest.mark.slow
def test_a_root_in_the_origin_is_no_error_of_a_step():
    """A beam falls about a hinge there; nothing but rounding is open in it."""
    body = beam("a", EI=100.0, EA=1e4)
    run = Run(0.1, 0.05, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    motion = simulate(System([body], [HINGE], gravity=GRAVITY), run).bodies["a"]
    angle = np.arctan2(motion.rotation[-1, 0, 2], motion.rotation[-1, 0, 0])
    assert angle == pytest.approx(1.5 * G * 0.1**2 / 2, rel=0.1)


def test_what_cannot_be_joined_is_refused_with_the_remedy():
    def refused(system, message, **run):
        options = {"step": FixedStep(1e-3), "method": GeneralizedAlpha(0.9)} | run
        with pytest.raises(ModelError, match=message):
            simulate(system, Run(0.1, 0.1, **options))

    clamped = intrinsic_body(beam_line(straight(1.0, 4), name="a", **SOFT), CLAMPED)
    other = beam("b")
    joined = System([clamped, Placed(other, position=[1.0, 0, 0])], [HINGE, ELBOW])
    refused(joined, r"its modes belong to a supported root.*place released\(body\)")
    good = System([released(clamped), Placed(other, position=[1.0, 0, 0])], [HINGE, ELBOW])
    refused(good, "do not support RungeKutta4", method=RungeKutta4())
    apart = System([released(clamped), Placed(other, position=[1.1, 0, 0])], [HINGE, ELBOW])
    refused(apart, "joint 'elbow' is open .* position x has a gap of 0.1")
    held = System([clamped], [Fixed(first="ground", second="a.root", name="clamp")])
    refused(held, r"adaptive step.*released\(body\)", step=AdaptiveStep())
