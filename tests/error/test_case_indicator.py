"""The indicator in few columns, of many runs at once, against the true errors of their bases."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from error.equation.machines import NODAL, nodal_errors, reduced, rms, run_of, soft_strip

from supple.body import FullBody, RayleighDamping
from supple.error import case_indicators, indicator_body
from supple.error.error_estimate import ErrorEstimator
from supple.errors import LockingWarning
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System, Table
from supple.reduction import redamped
from supple.simulation import simulate, simulate_batch

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")]

RUN = run_of(0.3)
TIMES = np.linspace(0, 0.3, 9)
FORCES = (0.3, 0.6, 1.0)
DAMPINGS = (RayleighDamping(0.5, 2e-3), RayleighDamping(0.5, 4e-3), RayleighDamping(0.0, 1e-3))


def pushed(force, damping):
    """A clamped strip under a force that comes and goes."""
    body = FullBody(soft_strip("strip", 1.0), NODAL, damping)
    wall = Fixed(name="wall", first=GROUND, second=At("strip", "root"))
    table = Table(TIMES, force * np.sin(np.pi * TIMES / 0.3)[:, None] * [0.0, 0.2, 1.0])
    return System((Placed(body),), (wall,), (DeadForce(body="strip", at="tip", force=table),))


def test_it_is_the_error_where_the_columns_know_the_missing_motion(monkeypatch):
    """Of one body with three dampings; the columns know what the strongest push misses, and no other."""
    wholes = [pushed(*each) for each in zip(FORCES, DAMPINGS, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)
        small, bases = reduced(wholes[0], 3, 3)
    body = small.bodies[0].body
    cases = [
        replace(small, loads=whole.loads, bodies=(Placed(redamped(body, DAMPINGS[0], own)),))
        for whole, own in zip(wholes, DAMPINGS, strict=True)
    ]
    solutions = simulate_batch(cases, RUN).check().solutions
    stated = ErrorEstimator(wholes[2], RUN).assess(cases[2], bases, solutions[2])
    coordinates = solutions[2].bodies["strip"].coordinates
    full = wholes[0].bodies_of(FullBody)["strip"]
    known = indicator_body(full, body, bases["strip"], coordinates, stated.missed["strip"])
    dampings = [{"strip": own} for own in DAMPINGS]

    def indicated():
        return case_indicators(cases, RUN, solutions, {"strip": known}, dampings, at_rest=False)

    found = indicated()
    for whole, case, solution, own in zip(wholes, cases, solutions, found, strict=True):
        true = rms(nodal_errors(whole, case, simulate(whole, RUN), solution)["strip"]).max()
        assert own["strip"].error == pytest.approx(true, rel=0.1)
    assert found[2]["strip"].size > found[0]["strip"].size > 0
    # Of long runs the error takes longer steps: here twice those of the run.
    monkeypatch.setattr("supple.error.case_indicator.MOST_INSTANTS", 15)
    for own, coarse in zip(found, indicated(), strict=True):
        assert coarse["strip"].error == pytest.approx(own["strip"].error, rel=0.1)
