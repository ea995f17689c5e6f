"""The linearised march: its operators, its exactness, and its order."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from error.equation.machines import (
    MEAN,
    NODAL,
    nodal_errors,
    reduced,
    rms,
    spinning,
)

from supple.body import FullBody, RayleighDamping
from supple.error.equation import (
    AssessedBody,
    ErrorEquation,
    ErrorHistory,
    ErrorSpace,
    run_columns,
    second_corrections,
)
from supple.error.equation.linearised_march import _linearized, _weighted
from supple.error.residual_correction import _expanded, _expanded_motion
from supple.integrate import StepFactors
from supple.machine import Placed
from supple.methods.floating.full.full_system import FullSystem
from supple.reduction import CompleteBasis, NoDerivatives, project, reduction_basis
from supple.simulation import simulate

pytestmark = pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")


def complete(body, frame, motion):
    """All of a body's deformation seen from a frame, the columns of a motion first."""
    every = reduction_basis(body, frame, CompleteBasis(), derivatives=NoDerivatives()).vectors
    onto = every.T @ (body.mass @ motion)
    others = np.linalg.svd(onto)[0][:, motion.shape[1] :]
    return ErrorSpace(np.hstack([motion, every @ others]), motion.shape[1])


def equation_of(system, small, bases, run, solution):
    """With all deformation in the space of the error."""
    bodies = {}
    for name, full in system.bodies_of(FullBody).items():
        body = small.bodies[small.body_index(name)].body
        motion = run_columns(full.body, body, bases[name], solution.bodies[name])
        bodies[name] = AssessedBody(
            full, motion, complete(full.body, full.frame, motion.vectors), full.damping
        )
    active = tuple(int(row) for row in solution.engine_state["active"])
    return ErrorEquation(small, bodies, run.method.coefficients, solution, active, {})


@pytest.fixture(scope="module", params=["mean-axis", pytest.param("nodal-fixed", marks=pytest.mark.slow)])
def spun(request):
    """A damped strip spun up: systems, bases, run and solution."""
    frame = NODAL if request.param == "nodal-fixed" else MEAN
    system, run = spinning(frame, RayleighDamping(0.5, 2e-3))
    small, bases = reduced(system, 3, 3)
    return system, small, bases, run, simulate(small, run)


def test_its_residual_is_that_of_the_full_equations(spun):
    """Through the columns: inertia, elasticity and damping of all elements, joints; at a state in motion."""
    system, small, bases, run, solution = spun
    equation = equation_of(system, small, bases, run, solution)
    row = 80
    full = system.bodies_of(FullBody)["strip"]
    body = small.bodies[0].body
    active = tuple(int(each) for each in solution.engine_state["active"])
    prepared = FullSystem(system, active)
    expanded = {
        "strip": _expanded_motion(full, body, bases["strip"], solution.bodies["strip"], np.array([row]))
    }
    evaluation = prepared.evaluate(_expanded(prepared, solution, expanded, 0, row), 0.0)
    whole = np.asarray(evaluation.interior_residuals[0])
    Z = equation.bodies["strip"].space.vectors
    told = linearized_at(equation, row)
    np.testing.assert_allclose(np.asarray(told.gap), evaluation.constraint_residual, atol=1e-10)
    exact = np.concatenate([whole[:6], Z.T @ whole[6:]])
    got = np.asarray(told.residual)[: len(exact)]
    np.testing.assert_allclose(got, exact, atol=1e-6 * np.abs(exact).max())


def test_a_second_correction_is_what_the_first_leaves_of_the_forces(spun):
    """Of any error e, by definition: K_t(q) d = -( f(q + e) - f(q) - K_t(q) e ), |d| / |e|; once."""
    equation = equation_of(*spun)
    own, times = equation.bodies["strip"], equation.steps.times
    row, n = 70, len(equation.steps.times)
    found, rms = np.zeros((n, own.space.size)), np.zeros(n)
    found[row] = (
        1e-3 * np.random.default_rng(1).standard_normal(own.space.size) / np.arange(1, own.space.size + 1)
    )
    rms[row] = 1.0
    none = np.zeros((n, 3))
    history = ErrorHistory(own, times, equation.steps.bodies["strip"].rotation, none, none, found, rms)
    assembly, Z = own.full.body.assembly, own.space.vectors
    q, e = own.motion.vectors @ own.motion.coordinates[row], Z @ found[row]
    tangent = assembly.tangent(q)
    left = assembly.internal_force(q + e) - assembly.internal_force(q) - tangent @ e
    second = np.linalg.solve(Z.T @ (tangent @ Z), Z.T @ left)
    exact = np.linalg.norm(second) / np.linalg.norm(found[row])
    assert second_corrections(equation, {"strip": history})["strip"] == pytest.approx(exact, rel=1e-2)


def linearized_at(equation, row):
    """The linearised step at one instant, from differences of zero."""
    point = equation.point
    gained = [equation.gained(name, own) for name, own in point.bodies.items()]
    bodies = tuple(each[0] for each in gained)
    here = [
        jax.tree.map(lambda leaf: leaf[row], _weighted(body, history))
        for body, (_, history) in zip(bodies, gained, strict=True)
    ]
    motion = jax.tree.map(lambda leaf: leaf[row], point.motion)
    none = np.zeros(equation.model.n_velocities)
    return jax.jit(_linearized)(
        equation.model, bodies, here, motion, none, StepFactors(1.0, 1.0), (none, none)
    )


@pytest.mark.parametrize("frame", [pytest.param(NODAL, id="nodal-fixed"), pytest.param(MEAN, id="mean-axis")])
@pytest.mark.slow
def test_a_complete_basis_has_no_error(frame):
    """But for that of Newton's iteration, which the residual holds as well."""
    system, run = spinning(frame)
    full = system.bodies_of(FullBody)["strip"]
    basis = reduction_basis(full.body, frame, CompleteBasis(), derivatives=NoDerivatives())
    small = replace(system, bodies=(Placed(project(full.body, basis)),))
    brief = replace(run, duration=0.2)
    solution = simulate(small, brief)
    equation = equation_of(system, small, {"strip": basis}, brief, solution)
    history = equation.histories(equation.first())["strip"]
    assert history.rms.max() < 1e-9 * np.abs(solution.bodies["strip"].coordinates).max()


@pytest.mark.slow
def test_once_more_about_the_corrected_motion_the_error_is_of_higher_order(spun):
    """Against the full run, place and phase included: what is left of 1e-4 m is a hundredth, then less."""
    system, small, bases, run, solution = spun
    undamped = [replace(each, body=replace(each.body, damping=None)) for each in system.bodies]
    system = replace(system, bodies=tuple(undamped))
    small, bases = reduced(system, 3, 3)
    solution = simulate(small, run)
    true = nodal_errors(system, small, simulate(system, run), solution)["strip"]
    equation = equation_of(system, small, bases, run, solution)
    first = equation.first()
    missed = []
    for found in (first, equation.again(first)):
        history = equation.histories(found)["strip"]
        apart = [rms((history.at_nodes(row) - true[row])[None])[0] for row in range(10, 101, 10)]
        missed.append(max(apart) / rms(true).max())
    assert rms(true).max() > 5e-5
    assert missed[0] < 0.1
    assert missed[1] < 0.01
    assert missed[1] < 0.2 * missed[0]
    corrected = equation.corrected(first, np.arange(101))
    apart = corrected[0].bodies[0].body.positions(corrected[1].bodies["strip"]) - small.bodies[
        0
    ].body.positions(solution.bodies["strip"])
    np.testing.assert_allclose(rms(apart), equation.histories(first)["strip"].rms, rtol=1e-3, atol=1e-12)
