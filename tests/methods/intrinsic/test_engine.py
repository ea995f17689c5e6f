"""Machines of intrinsic bodies: orders of rules, conservation, supports, loads, damping, what is refused."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight
from scipy.spatial.transform import Rotation

from supple.body import ModalDamping, RayleighDamping, RigidBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import (
    AdaptiveStep,
    FixedStep,
    GeneralizedAlpha,
    Newmark,
    ResidualRungeKutta4,
    Run,
    RungeKutta4,
)
from supple.machine import (
    Ball,
    Bushing,
    ConstantRate,
    DeadForce,
    DeadTorque,
    Fixed,
    FollowerForce,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Revolute,
    SpringDamper,
    System,
    TorsionSpringDamper,
    Universal,
)
from supple.methods.intrinsic import (
    BALL,
    CLAMPED,
    FREE,
    hinged,
    intrinsic_body,
    sliding,
)
from supple.methods.intrinsic.expansion import expansion_of_stations
from supple.methods.intrinsic.machine_of_lines import machine_of_lines
from supple.methods.intrinsic.stable_step import with_chosen_step
from supple.methods.intrinsic.station_loads import machine_loads
from supple.simulation import equilibrium, simulate

SOFT = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}
STIFF = {"EA": 1e6, "EI": 1e5, "GJ": 1e5, "mass_per_length": 1.0, "radius": 0.05}
CLAMP = Fixed(first="ground", second="beam.root", name="clamp")
GRAVITY = np.array([0, 0, -9.81])


def beam(support, *, n=8, n_modes=12, damping=None, **section):
    return intrinsic_body(beam_line(straight(1.0, n), **(SOFT | section)), support, n_modes, damping=damping)


def lowest_alone(support, n_modes):
    """Without second-order modes, whose high frequencies hide the order of a rule at usual steps."""
    whole = beam(support, n_modes=None)
    modes = whole.modes.truncated(n_modes + whole.modes.n_rigid)
    expansion = expansion_of_stations(whole.line.tree, modes.velocities[..., modes.n_rigid :])
    return replace(whole, modes=modes, expansion=expansion)


def plucked(body, size=0.3):
    """Placed with velocities in its lowest modes."""
    rates = np.zeros(body.n_coordinates)
    rates[:3] = size
    return Placed(body, coordinate_rates=rates)


def energies(body, motion):
    q2 = body.forces_of(motion.coordinates)
    return 0.5 * (np.sum(motion.rates**2, axis=1) + np.sum(q2**2, axis=1))


def tip_after(method, step, body, duration=0.4, **system):
    machine = System([plucked(body)], [CLAMP], **system)
    solution = simulate(machine, Run(duration, duration, step=FixedStep(step), method=method))
    return body.positions(solution.bodies["beam"], [body.line.n - 1])[-1, 0]


@pytest.mark.parametrize(
    ("method", "step", "order"), [(RungeKutta4(), 4e-3, 4), (GeneralizedAlpha(1.0), 4e-3, 2)]
)
def test_the_order_of_each_rule_is_measured(method, step, order):
    body = lowest_alone(CLAMPED, 6)
    reference = tip_after(RungeKutta4(), step / 16, body)
    errors = [np.linalg.norm(tip_after(method, step / k, body) - reference) for k in (1, 2)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.slow
def test_implicit_midpoint_keeps_the_energy_of_a_truncated_body_that_flies():
    body = beam(FREE)
    run = Run(1.0, 0.05, step=FixedStep(0.01), method=GeneralizedAlpha(1.0))
    motion = simulate(System([plucked(body, 1.0)]), run).bodies["beam"]
    energy = energies(body, motion)
    assert np.abs(energy / energy[0] - 1).max() < 1e-9


def test_runge_kutta_loses_energy_with_the_fifth_power_of_its_step():
    body = lowest_alone(FREE, 8)
    losses = []
    for step in (4e-3, 2e-3):
        run = Run(0.8, 0.8, step=FixedStep(step), method=RungeKutta4())
        energy = energies(body, simulate(System([plucked(body, 1.0)]), run).bodies["beam"])
        losses.append(1 - energy[-1] / energy[0])
    assert 0 < losses[0] < 1e-3
    assert np.log2(losses[0] / losses[1]) == pytest.approx(5, abs=0.7)


def centre_error(n):
    """Of a free beam that a dead force at its tip accelerates and turns."""
    body = beam(FREE, n=n, n_modes=None)
    system = System([body], loads=[DeadForce(at="beam.tip", force=(0, 0, 4.0))])
    solution = simulate(system, Run(0.6, 0.1, step=FixedStep(2.5e-3), method=GeneralizedAlpha(1.0)))
    masses = body.line.station_masses[:, 0, 0]
    centre = np.einsum("n,tni->ti", masses, body.positions(solution.bodies["beam"])) / masses.sum()
    exact = np.column_stack([np.full(7, 0.5), np.zeros(7), 2.0 * solution.times**2])
    assert np.abs(solution.bodies["beam"].rotation[-1] - np.eye(3)).max() > 1  # it has turned far
    return np.sqrt(np.mean(np.sum((centre - exact) ** 2, axis=1)))


@pytest.mark.slow
def test_the_centre_of_mass_moves_as_newton_says_to_second_order_in_the_stations():
    coarse, fine = centre_error(4), centre_error(8)
    assert fine < 5e-3
    assert np.log2(coarse / fine) > 1.7


@pytest.mark.slow
def test_a_stiff_hinged_beam_is_the_pendulum():
    """Against m L^2/3 a'' = m g L/2 cos a, integrated."""
    from scipy.integrate import solve_ivp

    n = 16
    body = intrinsic_body(
        beam_line(straight(1.0, n), **STIFF), hinged((0, 1, 0)), 4, damping=ModalDamping(0.7)
    )
    system = System(
        [body], [Revolute(first="ground", second="beam.root", axis=(0, 1, 0), name="hinge")], gravity=GRAVITY
    )
    solution = simulate(system, Run(1.0, 0.05, step=FixedStep(2e-3), method=GeneralizedAlpha(0.9)))
    tip = body.positions(solution.bodies["beam"], [n])[:, 0]
    inertia = body.line.mass
    twist = body.line.twists[:, 4]
    about = float(twist @ inertia @ twist)
    exact = solve_ivp(
        lambda _, y: [y[1], 9.81 / 2 * np.cos(y[0]) / about],
        (0, 1),
        [0, 0],
        t_eval=solution.times,
        rtol=1e-10,
        atol=1e-12,
    ).y[0]
    assert -np.arctan2(tip[:, 2], tip[:, 0]) % (2 * np.pi) == pytest.approx(exact % (2 * np.pi), abs=2e-4)
    # The hinge carries what accelerates the centre, m (a - g), and no moment about its axis.
    force = solution.joint_forces["hinge"]
    rate = np.gradient(exact, solution.times, edge_order=2)
    up, along = -np.array([0, 0, 1.0]), np.column_stack([np.cos(exact), 0 * exact, -np.sin(exact)])
    across = np.column_stack([-np.sin(exact), 0 * exact, -np.cos(exact)])
    acceleration = (
        0.5 * (9.81 / 2 * np.cos(exact) / about)[:, None] * across - 0.5 * rate[:, None] ** 2 * along
    )
    expected = np.linalg.norm(acceleration - GRAVITY, axis=1)
    assert up @ GRAVITY > 0
    assert np.linalg.norm(force[:, :3], axis=1)[2:-2] == pytest.approx(expected[2:-2], rel=0.02)
    assert np.abs(force[:, 5]).max() < 1e-9


def test_a_ball_leaves_all_turns_free_and_a_slide_none():
    ball = intrinsic_body(beam_line(straight(1.0, 4), **STIFF), BALL, 2)
    system = System([Placed(ball, angular_velocity=[0, 0, 2.0])], [Ball(first="ground", second="beam.root")])
    motion = simulate(system, Run(0.5, 0.1, step=FixedStep(0.01), method=GeneralizedAlpha(1.0))).bodies[
        "beam"
    ]
    tip = ball.positions(motion, [4])[:, 0]
    assert np.arctan2(tip[:, 1], tip[:, 0]) == pytest.approx(2.0 * np.arange(6) * 0.1, abs=1e-3)
    assert motion.position == pytest.approx(np.zeros((6, 3)), abs=1e-12)


@pytest.mark.slow
def test_a_prescribed_turn_at_constant_speed_stretches_as_the_formula_says():
    """u(L) = rho A w^2 L^3 / (3 EA), first order in the strain."""
    n, speed = 32, 5.0
    body = intrinsic_body(
        beam_line(straight(1.0, n), **SOFT | {"EA": 1e5, "EI": 1e3, "GJ": 1e3}),
        CLAMPED,
        8,
        damping=ModalDamping(1.0),
    )
    hub = PrescribedRotation(first="ground", second="beam.root", axis=(0, 0, 1), angle=ConstantRate(speed))
    placed = Placed(body, angular_velocity=[0, 0, speed])
    solution = simulate(
        System([placed], [hub]), Run(0.5, 0.1, step=FixedStep(1e-3), method=GeneralizedAlpha(0.8))
    )
    tip = body.positions(solution.bodies["beam"], [n])[-1, 0]
    assert np.linalg.norm(tip) - 1 == pytest.approx(speed**2 / 3e5, rel=0.02)
    assert np.arctan2(tip[1], tip[0]) == pytest.approx(speed * 0.5, abs=1e-3)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
def test_residual_modes_are_nearer_to_the_whole_than_truncated_ones():
    """A moment at the middle, of which few modes are not enough."""
    load = [
        FollowerTorque(first="beam.station 4", torque=ConstantRate(np.array([0, 1.2, 0]))),
        FollowerForce(first="beam.tip", force=ConstantRate(np.array([0, 0, 1.0]))),
    ]
    run = {"duration": 0.6, "output_step": 0.1, "step": FixedStep(2e-3)}
    stations = {"station 4": 4}
    line = beam_line(straight(1.0, 8), **SOFT)

    def tips(n_modes, method):
        body = intrinsic_body(line, CLAMPED, n_modes, stations=stations)
        return body.positions(
            simulate(System([body], [CLAMP], load), Run(**run, method=method)).bodies["beam"], [8]
        )

    whole = tips(20, GeneralizedAlpha(1.0))
    truncated = np.abs(tips(6, RungeKutta4()) - whole).max()
    residual = np.abs(tips(20, ResidualRungeKutta4(6)) - whole).max()
    assert residual < 0.4 * truncated


@pytest.mark.slow
def test_viscous_strains_damp_a_body_that_turns_without_slowing_its_turn():
    line = beam_line(straight(1.0, 6), **SOFT)
    spinning = {}
    for damping in (None, RayleighDamping(0.0, 0.02)):
        body = intrinsic_body(line, FREE, 8, damping=damping)
        placed = Placed(body, angular_velocity=[0, 0, 1.0], velocity=[0, -0.5, 0])
        motion = simulate(
            System([placed]), Run(2.0, 0.5, step=FixedStep(5e-3), method=GeneralizedAlpha(1.0))
        ).bodies["beam"]
        spinning[damping] = np.linalg.norm(motion.rates[-1, :6]) / np.linalg.norm(motion.rates[0, :6])
    assert list(spinning.values())[1] == pytest.approx(1, abs=2e-4)


@pytest.mark.slow
def test_a_damped_body_comes_to_the_equilibrium_of_statics():
    body = beam(CLAMPED, n_modes=10, damping=ModalDamping(0.9))
    system = System([body], [CLAMP], [DeadForce(at="beam.tip", force=(0, 0, 2.0))], gravity=GRAVITY / 10)
    rest = body.positions(equilibrium(system).solution.bodies["beam"])[0]
    run = Run(8.0, 2.0, step=FixedStep(0.02), method=GeneralizedAlpha(0.8))
    solution = simulate(system, run)
    assert body.positions(solution.bodies["beam"])[-1] == pytest.approx(rest, abs=1e-5)
    # At rest the clamp carries the load and the weight.
    weight = np.array([0, 0, 0.981 - 2.0])
    assert solution.joint_forces["clamp"][-1, :3] == pytest.approx(weight, abs=1e-3)


@pytest.mark.slow
def test_a_dead_torque_acts_at_a_station():
    body = beam(CLAMPED, n_modes=None)
    loads = [DeadTorque(first="beam.tip", torque=(0, -0.5, 0)), DeadForce(at="beam.root", force=(0, 0, 1.0))]
    rest = equilibrium(System([body], [CLAMP], loads)).solution.bodies["beam"]
    rotations, _ = body.places(rest)
    # Constant moment: the tip turns by M L / EI.
    assert np.arctan2(-rotations[0, -1, 2, 0], rotations[0, -1, 0, 0]) == pytest.approx(-0.5, rel=1e-6)


@pytest.mark.slow
def test_a_run_in_two_parts_is_the_run_in_one():
    body = beam(CLAMPED, n_modes=6)
    system = System([plucked(body)], [CLAMP], gravity=GRAVITY)
    for method in (RungeKutta4(), GeneralizedAlpha(0.9)):
        run = Run(0.2, 0.02, step=FixedStep(2e-3), method=method)
        parts = []
        whole = simulate(system, run, record=parts.append)
        resumed = simulate(system, run, resume=parts[5])
        assert np.array_equal(whole.bodies["beam"].rates[6:], resumed.bodies["beam"].rates)


def test_a_result_file_gives_the_motion_back(tmp_path):
    body = beam(CLAMPED, n_modes=6)
    system = System([plucked(body)], [CLAMP])
    run = Run(0.1, 0.02, step=FixedStep(2e-3), method=RungeKutta4())
    first = simulate(system, run, file=tmp_path / "beam.h5").bodies["beam"]
    again = simulate(system, run, file=tmp_path / "beam.h5").bodies["beam"]
    assert np.array_equal(first.rates, again.rates)
    assert np.array_equal(body.positions(first), body.positions(again))


def refused(system, message, *, kind=ModelError, **run):
    options = {"step": FixedStep(1e-3), "method": RungeKutta4()} | run
    with pytest.raises(kind, match=message):
        simulate(system, Run(0.1, 0.1, **options))


def test_what_intrinsic_bodies_cannot_do_is_refused_with_the_remedy():
    body = beam(CLAMPED, n_modes=6)
    alone = System([body], [CLAMP])
    refused(alone, "unstable with a highest frequency of .* use steps of", step=FixedStep(0.1))
    refused(alone, "do not support Newmark", method=Newmark())
    refused(alone, "need FixedStep", step=AdaptiveStep())
    refused(System([body]), "without a joint it has.*condense the body with the support")
    refused(System([beam(FREE, n_modes=6)], [CLAMP]), "do not support RungeKutta4: use GeneralizedAlpha")
    tip = Fixed(first="ground", second="beam.tip")
    refused(
        System([body], [tip]), r"acts on station 8 .*place released\(body\), which supports joints at any"
    )
    refused(System([body], [CLAMP, tip]), r"has 2 joints.*place released\(body\)")
    sprung = SpringDamper(first="ground", second="beam.tip", anchor=(1.0, 0, 0), stiffness=1.0)
    refused(System([body], [CLAMP], [sprung]), "both ends start at")
    driven = PrescribedRotation(first="ground", second="beam.root", axis=(0, 0, 1), angle=jnp.sqrt)
    refused(System([body], [driven]), "law of the joint at its root has no finite value or rate")
    universal = Universal(first="ground", second="beam.root", first_axis=(1, 0, 0), second_axis=(0, 1, 0))
    refused(System([body], [universal]), "Universal joint has free directions")
    hub = RigidBody("hub", 1.0, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})
    refused(System([body, hub], [CLAMP]), "do not support RungeKutta4")
    refused(
        System([Placed(body, velocity=[1.0, 0, 0])], [CLAMP]), "initial velocity that its root cannot have"
    )
    refused(alone, "of them rigid|unstable", method=ResidualRungeKutta4(6), step=FixedStep(0.1))
    free = System([beam(FREE, n_modes=6)])
    refused(free, "3 modes kept, 6 of them rigid", method=ResidualRungeKutta4(3), step=None)


def test_bodies_in_floating_frames_refuse_rules_of_first_order():
    stone = RigidBody("stone", 1.0, np.zeros(3), np.eye(3))
    refused(System([stone]), "RungeKutta4 supports machines of intrinsic bodies only", kind=ValueError)


@pytest.mark.slow
def test_residual_modes_that_do_not_contract_end_the_run():
    body = beam(CLAMPED, n_modes=None)
    load = FollowerForce(first="beam.tip", force=(0, 0, 60.0))
    system = System([body], [CLAMP], [load])
    refused(
        system,
        "residual modes did not converge .* Keep more modes than 3",
        kind=ConvergenceError,
        method=ResidualRungeKutta4(3),
        step=FixedStep(0.01),
    )


def test_implicit_steps_that_do_not_converge_end_the_run():
    body = beam(CLAMPED, n_modes=6)
    system = System([plucked(body, 1e6)], [CLAMP])
    refused(
        system,
        "a step did not converge",
        kind=ConvergenceError,
        method=GeneralizedAlpha(1.0),
        step=FixedStep(0.1),
    )


def test_supports_say_what_is_wrong_with_them():
    from supple.methods.intrinsic import RootSupport

    with pytest.raises(ModelError, match="linearly dependent"):
        RootSupport(np.ones((6, 2)))
    with pytest.raises(ModelError, match=r"array \(6, k\)"):
        RootSupport(np.ones((3, 2)))
    with pytest.raises(ModelError, match="must be finite"):
        RootSupport(np.full((6, 1), np.nan))
    with pytest.raises(ModelError, match="three finite numbers"):
        sliding((0, 0, 0))
    with pytest.raises(ModelError, match="interface 'middle' is at station 99"):
        intrinsic_body(beam_line(straight(1.0, 4), **SOFT), CLAMPED, 4, stations={"middle": 99})


def integrated_places(body, motion, times):
    """Positions (t, n, 3) of stations from their first ones, by velocities.

    From one output time to the next a station turns by the mean of its angular velocities, and moves with the
    mean of its velocities in space: second order in the output step. The difference from `body.places`, which
    goes out from the root by strains, falls with the square of the segments' length.

    times : (t,) of the motion
    Source: [Wang2015] (4)-(6), at every station.
    """
    modes = body.modes
    rates = np.einsum("nik,tk->tni", modes.velocities, motion.rates)
    first_rotations, first_positions = (each[0] for each in body.places(motion))
    n = body.line.n
    rotations = np.empty((len(times), n, 3, 3))
    rotations[0] = first_rotations
    steps = np.diff(times)
    for number, h in enumerate(steps):
        turn = Rotation.from_rotvec(0.5 * h * (rates[number, :, 3:] + rates[number + 1, :, 3:]))
        rotations[number + 1] = rotations[number] @ turn.as_matrix()
    velocity = np.einsum("tnij,tnj->tni", rotations, rates[..., :3])
    moved = 0.5 * steps[:, None, None] * (velocity[1:] + velocity[:-1])
    return first_positions + np.concatenate([np.zeros((1, n, 3)), np.cumsum(moved, axis=0)])


@pytest.mark.slow
def test_velocities_lead_where_strains_do_to_second_order_in_the_stations():
    apart = []
    for n in (4, 8):
        body = beam(FREE, n=n, n_modes=None)
        rates = np.zeros(body.n_coordinates)
        rates[0] = 0.7
        placed = Placed(body, coordinate_rates=rates, angular_velocity=np.array([0, 1.0, 0.5]))
        run = Run(0.3, 0.005, step=FixedStep(0.005), method=GeneralizedAlpha(1.0))
        solution = simulate(System([placed]), run)
        motion = solution.bodies["beam"]
        by_velocities = integrated_places(body, motion, solution.times)
        apart.append(np.abs(by_velocities - body.places(motion)[1]).max())
    assert apart[1] < 0.01
    assert np.log2(apart[0] / apart[1]) > 1.5


def test_a_run_without_a_step_resolves_the_periods_of_the_modes_kept():
    """Output times further apart than the period of the lowest mode say nothing of the step."""
    body = beam(CLAMPED, n_modes=2)
    rates = np.zeros(body.n_coordinates)
    rates[0] = 0.1
    system = System([Placed(body, coordinate_rates=rates)], [CLAMP])
    period = 2 * np.pi / body.modes.frequencies[-1]
    for method in (GeneralizedAlpha(1.0), RungeKutta4()):
        run = with_chosen_step(system, Run(4 * period, period, method=method))
        assert run.step.size <= period / 20 * (1 + 1e-9)
        assert period / run.step.size == pytest.approx(round(period / run.step.size))
    chosen = simulate(system, Run(4 * period, period, method=GeneralizedAlpha(1.0)))
    assert chosen.statistics.steps == 80
    named = Run(1.0, 0.5, step=FixedStep(0.25))
    assert with_chosen_step(system, named) is named
    stone = System([RigidBody("stone", 1.0, np.zeros(3), np.eye(3), {})])
    assert with_chosen_step(stone, Run(1.0, 0.5)).step is None


@pytest.mark.slow
def test_residual_modes_are_found_where_few_of_many_are_kept():
    """16 of 48 under a load that bends by half the length; sweeps that put the last values in diverge."""
    body = beam(CLAMPED, n_modes=None)
    system = System([body], [CLAMP], [DeadForce(at="beam.tip", force=ConstantRate(np.array([0, 0, 15.0])))])
    runs = [
        Run(0.4, 0.2, step=FixedStep(size), method=method)
        for size, method in ((2e-3, ResidualRungeKutta4(16)), (2e-3, GeneralizedAlpha(0.9)))
    ]
    kept, all_modes = (body.positions(simulate(system, run).bodies["beam"])[-1] for run in runs)
    assert np.abs(all_modes - body.nodes).max() > 0.4
    assert np.abs(kept - all_modes).max() < 0.02


def test_loads_on_a_body_that_has_moved_are_those_of_its_assembly():
    """After an equilibrium, or at a later start, springs do not relax and forces do not turn back."""
    placed = Placed(beam(FREE, n=4, n_modes=4), position=[1.0, 0, 0])
    turned = Rotation.from_euler("y", 0.4).as_matrix()
    loads = [
        FollowerForce(first="beam.tip", force=(0, 0, 1.0)),
        TorsionSpringDamper(first="ground", second="beam.root", axis=(0, 1, 0), stiffness=1.0),
        Bushing(first="beam.tip", second="ground", stiffness=np.eye(6)),
    ]
    before, after = (
        jax.tree.leaves(machine_loads(System([each], loads=loads)))
        for each in (placed, placed.moved_to(np.array([3.0, 0, 1.0]), turned))
    )
    for one, other in zip(before, after, strict=True):
        assert other == pytest.approx(one, abs=1e-12)


def test_the_moment_of_a_joint_on_the_ground_is_about_the_point_of_the_ground():
    """A beam carried 1 m along a slide, at rest: its weight of 1 N acts at 1.5 m from there."""
    body = beam(CLAMPED, n=4, n_modes=None)
    slide = PrescribedTranslation(
        first="beam.root", second="ground", axis=(1, 0, 0), displacement=-1.0, name="slide"
    )
    machine = machine_of_lines(System([body], [slide]), 0.0)
    own = np.array([[[0, 0, 1.0, 0, -0.5, 0]]])  # on the root
    states = tuple(jax.tree.map(lambda leaf: np.asarray(leaf)[None], machine.start))
    moved = machine.motions(np.zeros(1), states, [np.zeros_like(state.q1) for state in states])
    assert moved["beam"].position[0] == pytest.approx([1.0, 0, 0])
    found = machine.joint_forces(own, moved)["slide"][0]
    at = slide.initial_axes
    assert at @ found[:3] == pytest.approx([0, 0, -1.0])
    assert at @ found[3:] == pytest.approx([0, 1.5, 0])
