"""What bases cost many runs, all judged together, is what they cost the runs one by one."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from error.equation.machines import NODAL, nodal_errors, reduced, rms, run_of, soft_strip, spinning

from supple.body import FullBody, RayleighDamping
from supple.error import estimate_batch_errors, estimate_error, state_batch_errors
from supple.error.check_run import check_run
from supple.errors import LockingWarning, ModelError
from supple.machine import GROUND, At, DeadForce, Fixed, Penalty, Placed, SlideStop, System, Table
from supple.quantities.quantity_of_interest import WholeBody
from supple.reduction import NoDerivatives, NormalModes, project, reduction_basis
from supple.simulation import simulate, simulate_batch

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")]

RUN = run_of(0.4)
TIMES = np.linspace(0, 0.4, 9)


def pushed(size):
    """A clamped strip under a force that comes and goes."""
    body = FullBody(soft_strip("strip", 1.0), NODAL, RayleighDamping(0.5, 2e-3))
    wall = Fixed(name="wall", first=GROUND, second=At("strip", "root"))
    force = size * np.sin(np.pi * TIMES / 0.4)[:, None] * [0.0, 0.2, 1.0]
    return System((Placed(body),), (wall,), (DeadForce(body="strip", at="tip", force=Table(TIMES, force)),))


@pytest.fixture(scope="module")
def batch():
    """Full and reduced cases of one body, and their runs."""
    wholes = [pushed(size) for size in (0.3, 0.6, 1.0)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        small, bases = reduced(wholes[0], 3, 3)
    cases = [replace(small, loads=whole.loads) for whole in wholes]
    return wholes, cases, bases, simulate_batch(cases, RUN).check().solutions


def test_together_they_are_told_as_one_by_one(batch):
    wholes, cases, bases, solutions = batch
    fulls = wholes[0].bodies_of(FullBody)
    together = estimate_batch_errors(cases, RUN, solutions, fulls)
    sizes = []
    for whole, small, solution, told in zip(wholes, cases, solutions, together, strict=True):
        alone = estimate_error(whole, small, bases, RUN, solution).bodies["strip"]
        own = told.bodies["strip"]
        assert own.estimate == pytest.approx(alone.estimate, rel=0.05)
        np.testing.assert_allclose(own.history, alone.history, atol=0.05 * alone.rms)
        sizes.append(own.rms)
    assert sizes[0] < 0.7 * sizes[1] < 0.49 * sizes[2]


def test_a_batch_of_one_is_the_run(batch):
    """The same space but for the instants, and the same march."""
    wholes, cases, bases, solutions = batch
    (told,) = estimate_batch_errors(cases[1:2], RUN, solutions[1:2], wholes[0].bodies_of(FullBody))
    alone = estimate_error(wholes[1], cases[1], bases, RUN, solutions[1]).bodies["strip"]
    assert told.bodies["strip"].rms == pytest.approx(alone.rms, rel=1e-2)


def test_results_carry_their_statements(batch):
    wholes, cases, _, solutions = batch
    fulls = wholes[0].bodies_of(FullBody)
    stated = state_batch_errors(cases, RUN, solutions, fulls)
    told = estimate_batch_errors(cases, RUN, solutions, fulls)
    for solution, own in zip(stated, told, strict=True):
        # The strip locks, so that a richer run states its error instead.
        of_basis = solution.bodies["strip"].error.basis.value
        assert of_basis == pytest.approx(own.bodies["strip"].estimate, rel=1e-3)
        assert solution.errors["strip"].at_least >= of_basis


def test_bodies_that_differ_are_refused(batch):
    wholes, cases, _, solutions = batch
    other, _ = reduced(wholes[1], 3, 3)
    with pytest.raises(ModelError, match="not the same object"):
        estimate_batch_errors([cases[0], other], RUN, solutions[:2], wholes[0].bodies_of(FullBody))


def test_an_estimate_of_a_body_that_locks_is_replaced_by_a_richer_run():
    """A strip with one mode that touches a stiff stop: the error is as large as the deformation."""
    body = FullBody(soft_strip("strip", 1.0, 3), NODAL, RayleighDamping(0.5, 1e-3))
    near = int(np.argmin(np.linalg.norm(body.nodes - [1 / 3, 0, 0], axis=1)))
    wall = Fixed(name="wall", first=GROUND, second=At("strip", "root"))
    stop = SlideStop(
        first=GROUND, second=At("strip", "tip"), axis=(0, 0, 1), lower=-1e-4, penalty=Penalty(stiffness=1e5)
    )
    times = np.linspace(0, 0.4, 41)
    force = -0.1 * np.sin(4 * times)[:, None] ** 2 * [0.0, 0.0, 1.0]
    push = DeadForce(body="strip", at=[near], force=Table(times, force))
    whole = System((Placed(body),), (wall,), (stop, push))
    basis = reduction_basis(body.body, NODAL, NormalModes(1), derivatives=NoDerivatives())
    small = replace(whole, bodies=(Placed(project(body.body, basis, damping=body.damping)),))
    run = run_of(0.4, 0.02, residual=1e-10)
    solution = simulate(small, run)
    fulls = whole.bodies_of(FullBody)
    (estimated,) = estimate_batch_errors([small], run, [solution], fulls)
    assert estimated.bodies["strip"].is_doubtful(np.inf)
    true = rms(nodal_errors(whole, small, simulate(whole, run), solution)["strip"]).max()
    assert estimated.bodies["strip"].estimate == pytest.approx(true, rel=1e-3)
    (stated,) = state_batch_errors([small], run, [solution], fulls)
    assert stated.errors["strip"].basis.how.startswith("a run with")
    assert stated.errors["strip"].basis.value == pytest.approx(true, rel=0.05)
    (stopped,) = state_batch_errors([small], run, [replace(solution, stopped="no convergence")], fulls)
    assert stopped.errors["strip"].basis is None


def test_an_estimate_that_has_not_converged_is_replaced_by_a_richer_run():
    """With one mode a strip that bends far has no equilibrium in reach: the error equation has no number."""
    whole, run = spinning(NODAL)
    small, _ = reduced(whole, 1, 0)
    solution, fulls = simulate(small, run), whole.bodies_of(FullBody)
    (unknown,) = estimate_batch_errors([small], run, [solution], fulls)
    assert not unknown.bodies["strip"].is_converged
    (stated,) = state_batch_errors([small], run, [solution], fulls)
    assert stated.errors["strip"].basis.how.startswith("a run with")
    true = rms(nodal_errors(whole, small, simulate(whole, run), solution)["strip"]).max()
    assert stated.errors["strip"].basis.value == pytest.approx(true, rel=0.05)


def test_a_richer_run_that_breaks_off_is_no_estimate(batch, monkeypatch):
    """The statement says so, and what to do."""
    wholes, cases, bases, solutions = batch
    monkeypatch.setattr(
        "supple.error.check_run.watched_run",
        lambda *_, **__: replace(solutions[0], stopped="no convergence at t = 0.1"),
    )
    fulls = wholes[0].bodies_of(FullBody)
    found = check_run(cases[0], RUN, solutions[0], fulls, bases, [WholeBody("strip")])[0]["strip"]
    assert found.value == np.inf
    assert found.how.startswith("no estimate: a run with 24 more modes and 12 more corrections stopped early")
    assert "shorter steps" in found.remedy
