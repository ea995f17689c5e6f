"""The kept factor of a linear full body: the same motion with fewer factorisations."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra.sparse_factor import SparseFactor
from supple.body import FullBody, MeanAxisFrame
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.multibody.full import full_interior
from supple.simulation import simulate


def swing(body):
    hinge = Ball(first=GROUND, second=At("blade", "root"))
    placed = Placed(FullBody(body, MeanAxisFrame()), angular_velocity=[0.3, -2.0, 1.0])
    return simulate(
        System(bodies=(placed,), joints=(hinge,), gravity=(0, 0, -9.81)),
        Run(duration=0.1, output_step=0.02, step=FixedStep(0.002), tolerances=Tolerances(1e-10)),
    )


@pytest.fixture
def count(monkeypatch):
    """Number of factorisations so far."""
    made = []
    original = SparseFactor.refactorize

    def counted(self, matrix):
        made.append(matrix)
        return original(self, matrix)

    monkeypatch.setattr(SparseFactor, "refactorize", counted)
    return lambda: len(made)


def test_a_linear_body_keeps_its_factor_and_its_motion(blade, count, monkeypatch):
    kept = swing(blade.linearized())
    few = count()
    monkeypatch.setattr(full_interior, "LARGEST_TURN", -1.0)
    anew = swing(blade.linearized())
    many = count() - few
    assert many >= kept.statistics.steps
    assert few < 0.2 * many
    for field in ("position", "rotation", "coordinates", "coordinate_accelerations"):
        expected = getattr(anew.bodies["blade"], field)
        np.testing.assert_allclose(
            getattr(kept.bodies["blade"], field), expected, atol=1e-7 * np.abs(expected).max()
        )


def test_a_nonlinear_body_is_factored_at_every_iteration(blade, count):
    solution = swing(blade)
    assert count() >= solution.statistics.iterations
