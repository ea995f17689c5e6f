"""Many cases of intrinsic bodies at once are the same cases one by one."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import RayleighDamping, RigidBody
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, ResidualRungeKutta4, Run, RungeKutta4, Tolerances
from supple.machine import (
    Controller,
    DeadForce,
    Fixed,
    FollowerForce,
    Placed,
    PrescribedRotation,
    Ramp,
    SpringDamper,
    System,
    Table,
)
from supple.methods.intrinsic import CLAMPED, FREE, intrinsic_body, released
from supple.simulation import simulate, simulate_batch

SOFT = {"EA": 1e4, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.05}


def beam(support, **section):
    line = beam_line(straight(1.0, 6), **(SOFT | section))
    return intrinsic_body(line, support, 8, damping=RayleighDamping(0.1, 1e-4))


CLAMPED_BEAM, FREE_BEAM = beam(CLAMPED), beam(FREE)


def held(force, *, body=CLAMPED_BEAM, gravity=9.81):
    """Clamped: a follower, a dead load of a table, gravity, a first velocity, as the number says."""
    rates = np.zeros(body.n_coordinates)
    rates[0] = 0.1 * force
    table = Table(np.array([0.0, 0.2]), np.array([[0, 0, 0], [0, force, 0]]))
    loads = [
        FollowerForce(first="beam.tip", force=(0, 0, force)),
        DeadForce(at="beam.tip", force=table),
    ]
    clamp = Fixed(first="ground", second="beam.root", name="clamp")
    return System([Placed(body, coordinate_rates=rates)], [clamp], loads, gravity=np.array([0, 0, -gravity]))


def flying(force):
    """Free, thrown and turning, with a spring at its tip."""
    placed = Placed(FREE_BEAM, velocity=np.array([force, 0, 0]), angular_velocity=np.array([0, force, 1.0]))
    spring = SpringDamper(
        first="ground", second="beam.tip", stiffness=2.0 + force, damping=0.1, anchor=(0, 0, 2.0)
    )
    return System([placed], loads=[spring])


def driven(angle):
    """Turned at its root by an angle of its own."""
    drive = PrescribedRotation(
        first="ground", second="beam.root", axis=(0, 0, 1), angle=Ramp(angle, 0.1), name="drive"
    )
    return System([CLAMPED_BEAM], [drive])


def assert_same(cases, run, **options):
    together = simulate_batch(cases, run, **options).check()
    for system, own in zip(cases, together.solutions, strict=True):
        alone = simulate(system, run)
        assert own.times == pytest.approx(alone.times, abs=0)
        motion, expected = own.bodies["beam"], alone.bodies["beam"]
        for name, values in expected.arrays().items():
            assert motion.arrays()[name] == pytest.approx(values, abs=1e-11), name
        for name, force in alone.joint_forces.items():
            assert own.joint_forces[name] == pytest.approx(force, abs=1e-8)
        assert own.statistics.steps == alone.statistics.steps
    places = [own.bodies["beam"].coordinates[-1] for own in together.solutions]
    assert min(np.abs(places[0] - other).max() for other in places[1:]) > 1e-4  # cases do differ


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.parametrize("machine", [held, flying, driven])
def test_runge_kutta_steps_cases_together_as_one_by_one(machine):
    run = Run(0.1, 0.02, step=FixedStep(1e-3), method=RungeKutta4())
    assert_same([machine(number) for number in (0.5, 1.0, 2.0)], run, chunk=2)


@pytest.mark.slow
@pytest.mark.parametrize("method", [ResidualRungeKutta4(5), GeneralizedAlpha(1.0)])
def test_other_rules_are_mapped_over_cases(method):
    # Cases iterate together until the last has converged: what others gain by it is below the residual.
    run = Run(0.06, 0.02, step=FixedStep(1e-3), method=method, tolerances=Tolerances(residual=1e-12))
    assert_same([held(number) for number in (0.5, 1.0)], run)


@pytest.mark.slow
def test_cases_may_have_bodies_of_their_own():
    """Stiffer ones, so that they share no modes."""
    run = Run(0.06, 0.02, step=FixedStep(1e-3), method=RungeKutta4())
    assert_same([held(1.0), held(1.0, body=beam(CLAMPED, EI=1.3))], run)


def test_cases_with_bodies_of_their_own_take_the_shortest_of_their_default_steps():
    """Steps of the first, soft body would be unstable for the second one."""
    run = Run(0.02, 0.01, method=RungeKutta4())
    bodies = CLAMPED_BEAM, beam(CLAMPED, EA=25e4, EI=25.0, GJ=25.0)
    cases = [replace(held(1.0, body=body), loads=(), gravity=np.zeros(3)) for body in bodies]
    together = simulate_batch(cases, run).check().solutions
    alone = simulate(cases[1], run)
    assert together[0].statistics.steps == together[1].statistics.steps == alone.statistics.steps
    coordinates = [each.bodies["beam"].coordinates for each in (together[1], alone)]
    assert coordinates[0] == pytest.approx(coordinates[1], abs=1e-11)


@pytest.mark.slow
def test_a_case_that_fails_stops_at_the_last_time_that_it_reached():
    hasty = Run(
        0.2,
        0.05,
        step=FixedStep(0.05),
        method=GeneralizedAlpha(1.0),
        tolerances=Tolerances(residual=1e-12, max_iterations=6),
    )
    batch = simulate_batch([held(1e-3), held(400.0)], hasty)
    assert list(batch.failures) == [1]
    assert batch.solutions[0].times[-1] == pytest.approx(0.2)
    assert batch.solutions[1].times[-1] < 0.2
    with pytest.raises(ConvergenceError, match=r"1 of 2 cases failed \(1\); case 1: a step did not converge"):
        batch.check()


@pytest.mark.slow
def test_joined_machines_go_one_after_another():
    run = Run(0.1, 0.05, step=FixedStep(5e-3), method=GeneralizedAlpha(0.9))
    weld = Fixed(first="ground", second="beam.tip", name="weld")
    body = released(intrinsic_body(beam_line(straight(1.0, 2), **SOFT), CLAMPED))
    cases = [System([body], [weld], gravity=(0, 0, g)) for g in (-1.0, -2.0)]
    for found, system in zip(simulate_batch(cases, run).check().solutions, cases, strict=True):
        own = simulate(system, run).bodies["beam"].coordinates
        assert np.array_equal(found.bodies["beam"].coordinates, own)


def test_what_no_batch_takes_is_named():
    run = Run(0.1, 0.05, step=FixedStep(1e-3), method=RungeKutta4())
    drive = FollowerForce(first="beam.tip", force=(0, 0, 0))
    control = Controller(reads={}, drives={"drive": drive}, outputs=lambda *_: {"drive": np.zeros(3)})
    with pytest.raises(ModelError, match="between intrinsic bodies do not support RungeKutta4"):
        simulate_batch([replace(held(1.0), controllers=(control,))], run)
    bob = System([RigidBody("bob", 2.0, np.zeros(3), np.eye(3), {"hinge": np.zeros(3)})])
    with pytest.raises(ModelError, match="case 1 differs from the first in more than numbers"):
        simulate_batch([bob, held(1.0)], run)
    with pytest.raises(ModelError, match="case 1 differs from the first in more than numbers"):
        simulate_batch([held(1.0), driven(1.0)], run)
    with pytest.raises(ModelError, match=r"a step of .* is unstable"):
        simulate_batch([held(1.0)], Run(0.1, 0.05, step=FixedStep(0.05), method=RungeKutta4()))
