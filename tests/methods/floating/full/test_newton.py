"""Modified Newton's iteration of the full engine: the motion of Newton's own, with few factorisations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import (
    AveragingInterface,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RayleighDamping,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.errors import AccuracyError, ConvergenceError
from supple.fem import Isotropic, solid_model
from supple.integrate import AdaptiveStep, FixedStep, GeneralizedAlpha, Run, StepRule, Tolerances
from supple.integrate.run import run as march
from supple.machine import GROUND, At, Ball, DeadForce, Fixed, FollowerForce, Placed, Revolute, System
from supple.mesh import CellType, block
from supple.methods.floating import FullEngine
from supple.methods.floating.full.full_tangent import FullTangent
from supple.methods.floating.full.newton import exact_newton, modified_newton
from supple.results.run_summary import cost_numbers
from supple.results.run_tables import cost_line
from supple.simulation import simulate

pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.StartWarning")

DAMPING = RayleighDamping(alpha=0.2, beta=2e-4)
STATES = ("position", "rotation", "coordinates", "velocity", "angular_velocity", "coordinate_rates")


def beam(name="beam"):
    """A soft solid beam along x, Green-Lagrange."""
    model = solid_model(block(1.0, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e5, 0.3, 1000.0))
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    return flexible_body(name, model, ends)


def pendulum(body, spin=(0.5, -1.0, 2.0)):
    """The beam on a ball joint, pushed by forces that stand and follow."""
    return System(
        (Placed(body, angular_velocity=spin),),
        (Ball(first=GROUND, second=At("beam", "root"), name="shoulder"),),
        (
            DeadForce(body="beam", at=[7, 9], force=[0.0, 20.0, 5.0]),
            FollowerForce(first=At("beam", "tip"), force=[0.0, 0.0, 30.0]),
        ),
        (0, 0, -9.81),
    )


def closed_loop():
    """Two beams and a rigid coupler on two pivots of a plate that stands: a four-bar in its plane."""
    upright = [0, -np.pi / 2, 0]
    left = Placed(FullBody(beam("left"), NodalFixedFrame("root"), DAMPING), rotation=upright)
    right = Placed(FullBody(beam("right"), MeanAxisFrame(), DAMPING), position=[1, 0, 0], rotation=upright)
    ends = {"a": [-0.5, 0, 0], "b": [0.5, 0, 0]}
    coupler = Placed(RigidBody("coupler", 20.0, [0, 0, 0], 2.0 * np.eye(3), ends), position=[0.5, 0, 1.0])
    plate = Placed(RigidBody("plate", 1.0, [0, 0, 0], np.eye(3), {"o": [0, 0, 0], "s": [1, 0, 0]}))
    pins = [("plate.o", "left.root"), ("left.tip", "coupler.a"), ("coupler.b", "right.tip")]
    joints = [Revolute(first=a, second=b, axis=(0, 1, 0), name=b) for a, b in pins]
    joints += [Ball(first="plate.s", second="right.root"), Fixed(first=GROUND, second="plate.o")]
    push = FollowerForce(first="coupler.a", force=[60.0, 0.0, 0.0])
    return System((left, right, coupler, plate), joints, (push,), (0, 0, -9.81))


def options(h=5e-3, duration=0.1, residual=1e-9, step=None):
    return Run(duration, 0.02, step=step or FixedStep(h), tolerances=Tolerances(residual))


def both(system, run):
    """The same run by modified and by Newton's own iteration."""
    return [
        march(FullEngine(system, run, iteration), run.times) for iteration in (modified_newton, exact_newton)
    ]


def assert_same_motion(one, other, rtol):
    for name, motion in one.bodies.items():
        for field in STATES:
            own, expected = getattr(motion, field), getattr(other.bodies[name], field)
            np.testing.assert_allclose(own, expected, atol=rtol * max(1.0, np.abs(expected).max(initial=0.0)))


@pytest.fixture(scope="module")
def full():
    return FullBody(beam(), MeanAxisFrame(), DAMPING)


@pytest.mark.slow
def test_it_is_newtons_motion_with_a_tenth_of_the_factors(full):
    modified, exact = both(pendulum(full), options())
    assert_same_motion(modified, exact, 1e-7)
    assert exact.statistics.factorizations == exact.statistics.iterations >= exact.statistics.steps
    assert modified.statistics.factorizations <= 0.1 * exact.statistics.factorizations
    contraction = modified.statistics.contraction
    assert contraction is not None
    assert 1e-4 < contraction < 0.1
    numbers = cost_numbers(modified.statistics)
    assert numbers["factorizations"] == modified.statistics.factorizations
    assert numbers["residual left by an iteration"] == contraction
    words = f"{modified.statistics.factorizations} factorizations, an iteration leaves {contraction:.2g}"
    assert words in cost_line(modified.statistics)


@pytest.mark.slow
def test_a_closed_loop_of_two_full_bodies_moves_the_same():
    modified, exact = both(closed_loop(), options())
    assert np.ptp(exact.bodies["coupler"].position[:, 0]) > 1e-3  # it moves
    assert_same_motion(modified, exact, 1e-7)
    assert modified.statistics.factorizations < exact.statistics.factorizations / 3


@pytest.mark.slow
def test_factorisations_are_counted_as_they_are_made(full, monkeypatch):
    made = []
    for name in ("exact", "symmetric"):
        original = getattr(FullTangent, name)

        def counted(self, *point, original=original):
            made.append(point)
            return original(self, *point)

        monkeypatch.setattr(FullTangent, name, counted)
    solution = simulate(pendulum(full), options())
    at_the_start = 2  # positions and velocities are made consistent, then accelerations
    assert len(made) == solution.statistics.factorizations + at_the_start


@pytest.mark.slow
def test_a_linear_body_keeps_one_factor(full):
    """It changes with the angular velocity alone."""
    linear = replace(full, body=full.body.linearized())
    shoulder = Revolute(first=GROUND, second=At("beam", "root"), axis=(0, 1, 0), name="shoulder")
    modified, exact = both(System([linear], [shoulder], gravity=(0, 0, -1)), options())
    assert_same_motion(modified, exact, 1e-7)
    assert modified.statistics.factorizations == 1


@pytest.mark.slow
def test_a_factor_is_renewed_where_the_motion_outgrows_it(full):
    """The beam swings through a quarter turn and bends; one factor does not serve all of it."""
    modified = simulate(pendulum(full, spin=(0.5, -10.0, 2.0)), options(h=1e-2, duration=0.2))
    assert 2 <= modified.statistics.factorizations < modified.statistics.steps


def test_high_spin_takes_the_unsymmetric_tangent(monkeypatch):
    """Where 2 gamma h w is far above a tenth, the skew gyroscopic terms are no small part of the tangent."""
    model = solid_model(block(1.0, 0.2, 0.2, 3, 1, 1, CellType.TETRA4), Isotropic(5e7, 0.3, 1000.0))
    ends = (AveragingInterface("root", "root"), AveragingInterface("tip", "tip"))
    body = FullBody(flexible_body("beam", model, ends), MeanAxisFrame(), DAMPING)
    system = System((Placed(body, angular_velocity=[0.1, 0.2, 20.0]),))
    kinds = []
    for name in ("exact", "symmetric"):
        original = getattr(FullTangent, name)

        def noted(self, *point, name=name, original=original):
            kinds.append(name)
            return original(self, *point)

        monkeypatch.setattr(FullTangent, name, noted)
    run = options(h=1e-2, duration=0.1)
    engine = FullEngine(system, run)
    started = engine.start(0.0)
    kinds.clear()
    leg = engine.march(started, run.times[1:])
    first = kinds.index("exact")
    assert set(kinds[:first]) == {"symmetric"}
    assert set(kinds[first:]) == {"exact"}
    assert len(kinds) == leg.statistics.factorizations < 0.2 * leg.statistics.iterations
    exact = march(FullEngine(system, run, exact_newton), run.times)
    assert_same_motion(engine.solution(leg), exact.at(slice(1, None)), 1e-6)


@pytest.mark.slow
def test_steps_of_changing_size_take_factors_of_their_own(full):
    step = AdaptiveStep(first=1e-3, largest=0.01, tolerance=1e-5)
    modified, exact = both(pendulum(full), options(step=step))
    assert modified.statistics.steps == exact.statistics.steps
    assert_same_motion(modified, exact, 1e-7)
    assert 1 < modified.statistics.factorizations < exact.statistics.factorizations


@pytest.mark.slow
def test_the_residual_reached_is_the_one_stated(full):
    """Whatever tangent took it there: evaluated once more at the state that the step left."""
    run = options(residual=1e-8)
    engine = FullEngine(pendulum(full), run)
    state = engine.march(engine.start(0.0), run.times[1:]).last
    machine = engine.machine
    by_position = StepRule(GeneralizedAlpha(0.8).coefficients, 5e-3).factors.by_position
    assert machine.evaluate(state.state, by_position).relative_residual.max() <= 1e-8


@pytest.mark.slow
def test_newtons_own_iteration_takes_over_where_the_symmetric_part_is_singular(full, monkeypatch):
    def singular(self, *point):
        raise AccuracyError("singular")

    expected = simulate(pendulum(full), options())
    monkeypatch.setattr(FullTangent, "symmetric", singular)
    found = simulate(pendulum(full), options())
    assert_same_motion(found, expected, 1e-7)
    assert found.statistics.factorizations >= found.statistics.steps


def test_no_iteration_converges_and_the_run_says_so(full):
    run = Run(0.1, 0.02, step=FixedStep(5e-3, smallest=4e-3), tolerances=Tolerances(1e-9, max_iterations=1))
    with pytest.raises(ConvergenceError, match=r"no convergence at t = 0.* relative residual"):
        simulate(pendulum(full, spin=(0.5, -6.0, 2.0)), run)


@pytest.mark.slow
@pytest.mark.parametrize("cut", [0.1, 0.2])
def test_a_resumed_run_goes_on_bit_by_bit(full, cut):
    """With the tangent it had kept, made again, and the accelerations that it extrapolates."""
    system = pendulum(full, spin=(0.5, -10.0, 2.0))
    whole, part = (simulate(system, options(h=1e-2, duration=duration)) for duration in (0.3, cut))
    rest = simulate(system, options(h=1e-2, duration=0.3), resume=part)
    assert whole.statistics.factorizations > 1
    left = len(rest.times)
    for name, array in rest.bodies["beam"].arrays().items():
        np.testing.assert_array_equal(array, whole.bodies["beam"].arrays()[name][-left:])
    counts = (part.statistics + rest.statistics, whole.statistics)
    assert counts[0].iterations == counts[1].iterations
    assert counts[0].factorizations == counts[1].factorizations
