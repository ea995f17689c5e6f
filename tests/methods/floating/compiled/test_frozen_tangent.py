"""Tangents kept over steps: the same motion, the stated residual, fewer tangents."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
from supple.equations.balance import tangent
from supple.equations.build_model import build_model
from supple.equations.compiler_options import STARTING
from supple.equations.joint_force import constraint_rows
from supple.equations.machine_model import Model
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, StepRule, Tolerances
from supple.machine import GROUND, At, DeadForce, Placed, PrescribedRotation, SpringDamper, System, Table
from supple.machine.laws.spin_up import SpinUp
from supple.mesh import CellType, block
from supple.methods.floating.compiled import batch_start, engine
from supple.methods.floating.compiled.contraction import MEASURED_EVERY
from supple.methods.floating.compiled.elimination import ByLapack
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.frozen_tangent import (
    PAUSE,
    FrozenInverse,
    bodies_inverse,
    freezes_tangent,
    no_tangent,
    predicted,
    predicted_to_suffice,
    serves,
    solution_by_parts,
    used,
)
from supple.methods.floating.compiled.iterate import evaluate, linearized
from supple.methods.floating.compiled.programs import COMPILED_MARCH, STOPS_AT_ONCE
from supple.methods.floating.compiled.state import State
from supple.methods.floating.compiled.step_equations import step_matrix
from supple.programs.program_cache import CachedProgram
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate, simulate_batch

STEP, N_STEPS, TOLERANCE = 1e-3, STOPS_AT_ONCE, 1e-6
MESH = block(1.0, 0.05, 0.05, 4, 1, 1, CellType.HEXA20)


def elastic():
    steel = Isotropic(youngs_modulus=2.1e10, poissons_ratio=0.3, density=7850.0)
    near = AveragingInterface("near", (MESH.nodes[:, 0] < 1e-9).nonzero()[0])
    return flexible_body("rod", solid_model(MESH, steel), [near])


@pytest.fixture(scope="module")
def rod():
    """Fourteen coordinates, nonlinear."""
    return reduce(elastic(), MeanAxisFrame(), CraigBampton(n_modes=4), loads=NoLoads)


def turning(rod, *loads, newtons=0.0):
    """On a hinge that turns it faster and faster, with a force at its free end from one step to the next.

    The force is in all of them, so that they share a program.
    """
    law = SpinUp(speed=8.0, rise_time=0.5)
    hinge = PrescribedRotation(first=GROUND, second=At("rod", "near"), axis=(0.0, 0.0, 1.0), angle=law)
    end = [int(node) for node in (MESH.nodes[:, 0] > 1 - 1e-9).nonzero()[0]]
    times = np.array([0.0, 0.0599, 0.0601, 1.0])
    force = newtons * np.outer([0, 0, 1, 1], [0.0, 0.0, 1.0])
    push = DeadForce(body="rod", at=end, force=Table(times, force))
    return System([Placed(rod)], [hinge], [push, *loads])


@pytest.mark.slow
def test_the_march_is_one_function_of_machine_code(rod):
    """No library is called within: a sort for the inverse would take twice the time of a step."""
    model, start = initial_state(turning(rod), 0.0, STEP)
    stops = STEP * np.arange(1, N_STEPS + 1)
    text = COMPILED_MARCH.compiled(model, controls(Run(1.0, STEP)), start, stops).as_text()
    whole = text[text.index("ENTRY") :]
    assert "xla_cpu_small_call" in whole
    assert " while(" not in whole


class Marched(NamedTuple):
    """States behind every step, the last one, and the residuals there in parts of the tolerance."""

    model: Model
    states: State
    last: State
    residuals: np.ndarray


def marched(system: System, *, keeping: bool = True) -> Marched:
    model, start = initial_state(system, 0.0, STEP)
    assert start.kept is not None
    begun = start if keeping else start._replace(kept=None)
    run = Run(1.0, STEP, step=FixedStep(STEP), tolerances=Tolerances(TOLERANCE), method=GeneralizedAlpha(0.8))
    device = jax.device_put((model, controls(run)))
    last, states = COMPILED_MARCH(*device, begun, STEP * np.arange(1, N_STEPS + 1))
    begun = start._replace(kept=None)
    every = jax.tree.map(lambda first, own: np.concatenate([np.asarray(first)[None], own]), begun, states)
    before = jax.tree.map(lambda leaf: leaf[:-1], every)
    return Marched(model, states, last, np.asarray(_residuals(model, before, states)))


@pytest.fixture(scope="module")
def smooth(rod):
    return marched(turning(rod))


def _residuals_of(model: Model, before: State, behind: State) -> Any:
    rule = StepRule(GeneralizedAlpha(0.8).coefficients, STEP)

    def residual(start: State, end: State) -> Any:
        at = evaluate(model, rule, start, end.acceleration, end.multipliers, jnp.asarray(TOLERANCE))
        return jnp.max(at.relative_residual) / TOLERANCE

    return jax.vmap(residual)(before, behind)


_residuals = CachedProgram(_residuals_of, STARTING)


def seen(states):
    """Steps whose last iterate was evaluated."""
    return np.asarray(states.relative_residual).max(axis=1) <= TOLERANCE


def test_the_residual_is_the_stated_one_at_every_step(smooth):
    assert smooth.residuals.max() <= 1.0
    assert np.quantile(smooth.residuals, 0.9) < 0.1


def test_few_tangents_are_made_and_most_steps_end_unseen(smooth):
    assert 1 <= float(smooth.last.kept.made) < 0.5 * N_STEPS
    assert float(smooth.last.kept.age) > 10
    assert np.mean(~seen(smooth.states)) > 0.5


def test_the_motion_is_that_of_newtons_method(rod, smooth):
    newton = marched(turning(rod), keeping=False)
    assert newton.last.kept is None
    for name in ("velocity", "multipliers", "acceleration"):
        own, exact = (np.asarray(getattr(each.states, name)) for each in (smooth, newton))
        assert np.abs(own - exact).max() < 1e-4 * np.abs(exact).max()
    own, exact = (np.asarray(each.states.configuration.coordinates) for each in (smooth, newton))
    assert np.abs(own - exact).max() < 1e-5 * np.abs(exact).max()


def test_a_load_that_jumps_is_met_all_the_same(rod):
    jumping = marched(turning(rod, newtons=500.0))
    assert seen(jumping.states)[59:61].all()
    assert jumping.residuals.max() <= 1.0
    assert np.argmax(np.abs(np.diff(jumping.states.acceleration[:, 2]))) in (58, 59)
    assert int(jumping.last.rejected_steps) == 0


@pytest.mark.slow
def test_a_resumed_run_meets_the_whole_one_in_every_bit(rod):
    system = turning(rod)

    def of(duration, resume=None):
        return simulate(system, Run(duration, 0.01, step=FixedStep(STEP)), resume=resume)

    whole, part = of(0.08), of(0.03)
    assert float(part.engine_state["tangent.made"]) > 0
    rest = of(0.08, resume=part)
    own, resumed = whole.bodies["rod"].arrays(), rest.bodies["rod"].arrays()
    for name, values in resumed.items():
        assert np.array_equal(own[name][-len(values) :], values), name
    assert 0 < whole.statistics.factorizations < whole.statistics.iterations


@pytest.mark.slow
def test_a_recorded_part_without_a_tangent_is_continued(rod):
    system = turning(rod)
    whole, part = (simulate(system, Run(end, 0.01, step=FixedStep(STEP))) for end in (0.08, 0.03))
    known = {name: value for name, value in part.engine_state.items() if "tangent" not in name}
    object.__setattr__(part, "engine_state", known)
    rest = simulate(system, Run(0.08, 0.01, step=FixedStep(STEP)), resume=part)
    own, resumed = whole.bodies["rod"].position[-1], rest.bodies["rod"].position[-1]
    assert np.allclose(own, resumed, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_cases_of_a_batch_keep_their_own_and_move_as_alone(rod, monkeypatch):
    monkeypatch.setattr(engine, "march_for", lambda *_: COMPILED_MARCH)  # that of batches
    # Started one by one: of machines at rest, rounding would tell whether tangents are worth keeping.
    monkeypatch.setattr(batch_start, "_starts_alike", lambda *_: False)
    systems = [turning(rod, newtons=own) for own in (0.0, 50.0, 400.0)]
    run = Run(0.1, 0.01, FixedStep(STEP))
    batch = simulate_batch(systems, run, chunk=2).check()
    for system, own in zip(systems, batch.solutions, strict=True):
        alone = simulate(system, run)
        np.testing.assert_allclose(
            own.bodies["rod"].coordinates, alone.bodies["rod"].coordinates, rtol=0, atol=1e-12
        )
        assert own.statistics.iterations == alone.statistics.iterations
        assert own.statistics.factorizations == alone.statistics.factorizations < own.statistics.iterations
        assert "tangent.made" not in own.engine_state
    bent = [np.abs(own.bodies["rod"].coordinates).max() for own in batch.solutions]
    assert bent[0] < 0.9 * bent[2]


def test_a_dear_tangent_of_a_smooth_machine_is_kept(rod):
    spring = SpringDamper(
        first=GROUND, second=At("rod", "near"), anchor=(2.0, 1.0, 0.0), stiffness=50.0, rest_length=0.5
    )

    def kept(body, *loads):
        return freezes_tangent(build_model(turning(body, *loads)))

    assert kept(rod)
    assert not kept(rod, spring)  # its law may have a kink
    linear = reduce(
        elastic().linearized(),
        MeanAxisFrame(),
        CraigBampton(n_modes=10),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    assert not kept(linear)


class Point(NamedTuple):
    """An iterate within a step, and its matrices."""

    model: Model
    rotations: Any
    inverse: Any
    rows: Any
    by_increment: Any
    matrix: Any


def _matrices_at(model: Model, start: State) -> Any:
    rule = StepRule(GeneralizedAlpha(0.8).coefficients, STEP)
    trial = evaluate(model, rule, start, start.acceleration, start.multipliers, jnp.asarray(TOLERANCE))
    step = linearized(rule, start, trial)
    rotations = trial.configuration.rotations
    return (
        rotations,
        bodies_inverse(ByLapack(), model, rotations, tangent(model, *step)),
        constraint_rows(model, trial.linearization.joints),
        constraint_rows(model, trial.linearization.joints, trial.increments),
        step_matrix(model, step),
    )


_at = CachedProgram(_matrices_at, STARTING)


@pytest.mark.slow
def test_a_solution_by_parts_is_that_of_the_whole_matrix(smooth):
    state = jax.tree.map(lambda leaf: leaf[N_STEPS // 2], smooth.states)
    point = Point(smooth.model, *_at(smooth.model, state))
    n, mass = smooth.model.n_velocities, smooth.model.mass
    load, gap = np.random.default_rng(1).standard_normal(n), np.linspace(-0.3, 0.2, 6)
    change, multipliers = solution_by_parts(ByLapack(), *point[:5], jnp.asarray(load), jnp.asarray(gap))
    whole = np.linalg.solve(point.matrix, np.concatenate([load, mass * gap]))
    assert np.allclose(change, whole[:n], rtol=0, atol=1e-8 * np.abs(whole[:n]).max())
    assert np.allclose(multipliers, mass * whole[n:], rtol=0, atol=1e-8 * np.abs(mass * whole[n:]).max())


def test_the_inverse_is_the_same_however_a_body_turns(smooth):
    state = jax.tree.map(lambda leaf: leaf[N_STEPS // 2], smooth.states)
    turn = np.asarray(rotation_exp(jnp.array([0.4, -1.1, 0.7])))

    def turned(vector):
        return jnp.concatenate([turn @ vector[:3], vector[3:]])

    about = state._replace(
        configuration=state.configuration._replace(
            origins=state.configuration.origins @ turn.T, rotations=turn @ state.configuration.rotations
        ),
        velocity=turned(state.velocity),
        acceleration=turned(state.acceleration),
        auxiliary=turned(state.auxiliary),
        multipliers=0 * state.multipliers,
    )
    here = Point(smooth.model, *_at(smooth.model, state._replace(multipliers=0 * state.multipliers)))
    there = Point(smooth.model, *_at(smooth.model, about))
    assert np.abs(here.rotations - there.rotations).max() > 0.5
    scale = np.sqrt(np.outer(np.diag(here.inverse), np.diag(here.inverse)))
    assert np.abs((here.inverse - there.inverse) / scale).max() < 1e-9


KNOWN = FrozenInverse(np.eye(1), STEP, 4.0, 1e3, 4e-3, 2.0, 1.0, 1.0, 0.0, np.ones(1), STEP, 0.0)


@pytest.mark.parametrize(
    ("size", "changes", "expected"),
    [
        (1e3, {}, True),  # 4e-3 at twice and a half the age: 1e-2
        (1.9e3, {}, True),  # 3.6 times that
        (1e3, {"age": 60.0}, False),  # thirty times as old
        (2.1e3, {}, False),  # unlike what was measured
        (1e3, {"phase": 0.0}, False),  # due to be measured
        (1e3, {"before": 0.0}, False),
        (np.nan, {}, False),
    ],
)
def test_what_a_tangent_leaves_grows_with_its_age_and_the_residual(size, changes, expected):
    assert bool(predicted_to_suffice(KNOWN._replace(**changes), jnp.asarray(size))) is expected


@pytest.mark.parametrize(
    ("left", "corrections", "evaluated", "made", "serving", "age"),
    [
        (1e-3, 1, True, 0, True, 5),
        (0.09, 1, True, 0, False, 5),  # at the next age more than a tenth of the tolerance
        (0.09, 1, False, 0, True, 5),  # not measured, and no word of that step
        (1e-3, 2, True, 0, False, 5),
        (1e-3, 2, True, 1, True, 0),
    ],
)
def test_a_tangent_serves_while_one_correction_surely_does(left, corrections, evaluated, made, serving, age):
    after = used(
        KNOWN, STEP, (np.ones(1), np.ones(1)), np.ones(1), made, np.array([1.0, left]), corrections, evaluated
    )
    assert bool(serves(after, jnp.asarray(STEP))) is serving
    assert float(after.age) == age
    assert float(after.made) == 1 + made
    assert float(after.phase) == (0 if made else 2 % MEASURED_EVERY)
    assert (float(after.before) == 1.0) is (evaluated and corrections == 1 and not made)


def test_a_tangent_that_does_not_outlive_its_first_step_is_followed_by_a_pause():
    first = KNOWN._replace(age=0.0)
    state = used(first, STEP, (np.ones(1), np.ones(1)), np.ones(1), 0, np.array([1e2, 1.0]), 2, True)
    assert float(state.pause) == PAUSE
    for left in np.arange(PAUSE)[::-1]:
        assert not serves(state, jnp.asarray(STEP))
        state = used(state, STEP, (np.ones(1), np.ones(1)), np.ones(1), 1, np.ones(2), 1, True)
        assert float(state.pause) == left
    assert serves(state, jnp.asarray(STEP))


def test_another_step_has_another_tangent():
    assert not serves(KNOWN, jnp.asarray(1.01 * STEP))


def test_an_iteration_begins_along_a_line_where_that_would_have_led_nearer():
    steady = used(KNOWN, STEP, (np.array([2.0]), np.array([2.9])), np.ones(1), 0, np.ones(2), 1, False)
    assert float(steady.lead) == 1.0
    assert np.allclose(predicted(steady, jnp.array([2.9]), STEP / 2), [3.35])
    shaken = used(KNOWN, STEP, (np.array([2.0]), np.array([1.0])), np.ones(1), 0, np.ones(2), 1, False)
    assert np.allclose(predicted(shaken, jnp.array([1.0]), STEP), [1.0])


def test_nothing_is_known_before_the_first_step(smooth):
    fresh = no_tangent(smooth.model)._replace(acceleration=np.zeros(3))
    assert not serves(fresh, jnp.asarray(STEP))
    assert np.array_equal(predicted(fresh, jnp.ones(3), STEP), np.ones(3))
