from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, sparse

from supple.algebra import mass_orthonormalize
from supple.errors import AccuracyError, ModelError


@pytest.fixture
def mass():
    factor = sparse.random_array((80, 80), density=0.05, rng=np.random.default_rng(0))
    return sparse.csc_array(factor @ factor.T + sparse.diags_array(np.logspace(-3, 3, 80)))


def defect(vectors, mass):
    return np.max(np.abs(vectors.T @ (mass @ vectors) - np.eye(vectors.shape[1])))


def test_columns_become_orthonormal_and_keep_their_span(mass):
    given = np.random.default_rng(1).standard_normal((80, 10)) * np.logspace(-12, 12, 10)
    basis, kept, dropped = mass_orthonormalize(given, mass)
    assert defect(basis, mass) < 1e-13
    np.testing.assert_array_equal(kept, np.arange(10))
    assert dropped.size == 0
    for count in range(1, 11):  # nested spans: earlier columns have precedence
        angles = linalg.subspace_angles(
            basis[:, :count], given[:, :count] / np.linalg.norm(given[:, :count], axis=0)
        )
        assert angles.max() < 1e-12


def test_dependent_columns_are_dropped_and_named(mass):
    a = np.random.default_rng(2).standard_normal((80, 4))
    given = np.column_stack(
        [a[:, 0], a[:, 1], a[:, 0] - 2 * a[:, 1], np.zeros(80), a[:, 2], 1e9 * a[:, 2], a[:, 3]]
    )
    basis, kept, dropped = mass_orthonormalize(given, mass)
    np.testing.assert_array_equal(kept, [0, 1, 4, 6])
    np.testing.assert_array_equal(dropped, [2, 3, 5])
    assert defect(basis, mass) < 1e-13


@pytest.mark.parametrize("distance", [1e-4, 1e-7])
def test_nearly_dependent_columns_come_out_orthonormal_all_the_same(mass, distance):
    a, b = np.random.default_rng(3).standard_normal((2, 80))
    basis, kept, _ = mass_orthonormalize(np.column_stack([a, a + distance * b]), mass)
    assert kept.size == 2
    assert defect(basis, mass) < 1e-13


def test_the_rank_tolerance_decides(mass):
    a, b = np.random.default_rng(4).standard_normal((2, 80))
    given = np.column_stack([a, a + 1e-6 * b])
    assert mass_orthonormalize(given, mass).kept.size == 2
    assert mass_orthonormalize(given, mass, rank_tolerance=1e-4).kept.size == 1


def test_what_a_projection_left_as_round_off_is_dropped(mass):
    noise = 1e-15 * np.random.default_rng(5).standard_normal((80, 1))
    assert mass_orthonormalize(noise, mass).kept.size == 1
    assert mass_orthonormalize(noise, mass, reference_norms=[1.0]).dropped.size == 1


def test_no_columns_give_no_basis(mass):
    basis, kept, dropped = mass_orthonormalize(np.zeros((80, 0)), mass)
    assert basis.shape == (80, 0)
    assert kept.size == dropped.size == 0


def test_the_argument_is_left_alone(mass):
    given = np.asfortranarray(np.random.default_rng(6).standard_normal((80, 3)))
    before = given.copy()
    mass_orthonormalize(given, mass)
    np.testing.assert_array_equal(given, before)


def test_what_cannot_be_orthonormalised(mass):
    with pytest.raises(ModelError, match=r"vectors have shape \(79, 2\); the mass matrix has 80 rows"):
        mass_orthonormalize(np.ones((79, 2)), mass)
    with pytest.raises(ModelError, match="NaN or infinite"):
        mass_orthonormalize(np.full((80, 1), np.nan), mass)
    with pytest.raises(ModelError, match=r"2 columns but reference norms of shape \(3,\)"):
        mass_orthonormalize(np.ones((80, 2)), mass, reference_norms=np.ones(3))
    with pytest.raises(
        ModelError, match=r"column 1 has the squared length -1.000e\+00: the mass is not definite"
    ):
        mass_orthonormalize(np.eye(2), np.diag([1.0, -1.0]))
    unsymmetric = np.array([[1.0, 0.5], [0.0, 1.0]])
    with pytest.raises(AccuracyError, match=r"M-orthonormal to .* only; check the mass matrix"):
        mass_orthonormalize(np.array([[1.0, 1.0], [0.0, 1.0]]), unsymmetric)
