"""The tangent of a full body's own equations, its symmetric part, and the kept factor of a linear body."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, RayleighDamping
from supple.integrate import StepFactors
from supple.methods.floating.full.full_interior import prepare_interior
from supple.methods.floating.full.full_state import InteriorState
from supple.methods.floating.full.full_tangent import LARGEST_TURN, FullTangent

FACTORS = StepFactors(by_position=3e-5, by_velocity=7e-3)


def state(body, coordinates, rates, accelerations, spin=(0.3, -2.0, 9.0)):
    """Of a frame that turns and accelerates."""
    return InteriorState(
        rotation=np.eye(3),
        coordinates=coordinates,
        rates=rates,
        accelerations=accelerations,
        angular_velocity=np.array(spin),
        angular_acceleration=np.array([4.0, 1.0, -20.0]),
        acceleration=np.array([1.0, 2.0, 3.0]),
        frame_multipliers=np.zeros(6),
        time=0.0,
    )


@pytest.fixture(scope="module")
def motion(blade):
    return 1e-3 * np.random.default_rng(0).standard_normal((3, blade.n))


def interior_of(body, beta=0.0):
    return prepare_interior(0, FullBody(body, MeanAxisFrame(), RayleighDamping(0.3, beta)), ())


def dense(interior, point, factored):
    """The factored matrix, from its inverse."""
    return np.linalg.inv(factored.factor.solve(np.eye(interior.full.n_coordinates)))


def test_it_is_how_the_forces_follow_the_accelerations(blade, motion):
    """r(x + e d) - r(x - e d) = 2 e S d, for displacements b' x, rates g' x, accelerations x."""
    interior = interior_of(blade)
    q, v, a = motion
    d = np.random.default_rng(1).standard_normal(blade.n)

    def residual(e):
        moved = q + e * FACTORS.by_position * d, v + e * FACTORS.by_velocity * d, a + e * d
        forces = interior.forces(state(blade, *moved))
        return (forces.inertia + forces.internal + forces.applied)[6:]

    change = (residual(1e-2) - residual(-1e-2)) / 2e-2
    point = state(blade, *motion), FACTORS
    solved = interior.tangent.exact(*point).factor.solve(change)
    np.testing.assert_allclose(solved, d, atol=1e-6 * np.abs(d).max())


def test_the_symmetric_factor_is_of_the_symmetric_part(blade, motion):
    interior = interior_of(blade, beta=1e-4)
    point = state(blade, *motion), FACTORS
    whole = dense(interior, point, interior.tangent.exact(*point))
    symmetric = dense(interior, point, interior.tangent.symmetric(*point))
    scale = np.abs(whole).max()
    assert np.abs(whole - whole.T).max() > 1e-6 * scale  # or it would be no test
    np.testing.assert_allclose(symmetric, (whole + whole.T) / 2, atol=1e-9 * scale)


def test_the_factor_of_a_linear_body_is_kept_while_it_turns_little(blade, motion, monkeypatch):
    made = []
    original = FullTangent.exact

    def counted(self, *point):
        made.append(point)
        return original(self, *point)

    monkeypatch.setattr(FullTangent, "exact", counted)
    tangent = interior_of(blade.linearized()).tangent

    def at(spin, factors=FACTORS):
        return tangent.serving(state(blade, *motion, spin=(0.3, -2.0, spin)), factors)

    first = at(9.0)
    assert at(9.0 + 0.9 * LARGEST_TURN / FACTORS.by_velocity) is first
    assert len(made) == 1
    at(9.0 + 1.1 * LARGEST_TURN / FACTORS.by_velocity)
    assert len(made) == 2
    at(9.0, StepFactors(2 * FACTORS.by_position, FACTORS.by_velocity))
    assert len(made) == 3
    nonlinear = interior_of(blade).tangent
    nonlinear.serving(state(blade, *motion), FACTORS)
    nonlinear.serving(state(blade, *motion), FACTORS)
    assert len(made) == 5
