from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, sparse

from supple.body import (
    LinearRayleighDamping,
    ModalDamping,
    RayleighDamping,
    rayleigh_at_modes,
    rayleigh_from_ratios,
)
from supple.errors import ModelError


@pytest.fixture
def pair():
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal((2, 6, 6))
    return a @ a.T + np.eye(6), b @ b.T + 6 * np.eye(6)


def modal_ratios(damping, stiffness, mass):
    squares, modes = linalg.eigh(stiffness, mass)
    return np.sqrt(squares), modes.T @ damping.matrix(stiffness, mass) @ modes


def test_rayleigh_ratios_hold_at_both_frequencies(pair):
    omega = np.sqrt(linalg.eigh(*pair, eigvals_only=True))
    for ratios in (0.02, (0.02, 0.03)):
        damping = rayleigh_from_ratios(ratios, omega[0], omega[3])
        _, C = modal_ratios(damping, *pair)
        np.testing.assert_allclose(np.diag(C)[[0, 3]], 2 * np.broadcast_to(ratios, 2) * omega[[0, 3]])
        np.testing.assert_allclose(C - np.diag(np.diag(C)), 0, atol=1e-12)


def test_rayleigh_at_modes_takes_the_frequencies_of_a_body_that_is_held():
    """A chain of four masses, its first one held: ratios of modes 1 and 3 of what is left."""
    K = sparse.diags_array([[-1.0] * 3, [1.0, 2.0, 2.0, 1.0], [-1.0] * 3], offsets=[-1, 0, 1]).tocsc()
    M = sparse.eye_array(4).tocsc()
    damping = rayleigh_at_modes(K, M, np.eye(4)[:1], 0.02, (1, 3))
    held = K.toarray()[1:, 1:], M.toarray()[1:, 1:]
    omega, C = modal_ratios(damping, *held)
    np.testing.assert_allclose(np.diag(C)[[0, 2]], 2 * 0.02 * omega[[0, 2]])


def test_rayleigh_keeps_sparse_matrices_sparse(pair):
    K, M = (sparse.csc_array(matrix) for matrix in pair)
    C = RayleighDamping(0.1, 0.2).matrix(K, M)
    assert sparse.issparse(C)
    np.testing.assert_allclose(C.toarray(), 0.1 * pair[1] + 0.2 * pair[0])


def test_linear_rayleigh_damping_is_the_same_at_rest_and_does_not_follow_the_strain_rate(pair):
    damping = RayleighDamping(0.1, 0.2)
    linear = damping.linearized()
    assert linear == LinearRayleighDamping(0.1, 0.2)
    np.testing.assert_array_equal(linear.matrix(*pair), damping.matrix(*pair))
    assert (damping.retardation_time, linear.retardation_time) == (0.2, 0.0)
    assert ModalDamping(0.1).retardation_time == 0.0


@pytest.mark.parametrize("ratios", [0.05, [0.01, 0.02, 0.03], np.linspace(0, 0.5, 6)])
def test_modal_ratios_hold_in_every_mode(pair, ratios):
    omega, C = modal_ratios(ModalDamping(ratios), *pair)
    given = np.atleast_1d(ratios)
    expected = given[np.minimum(np.arange(6), given.size - 1)]
    np.testing.assert_allclose(C, np.diag(2 * expected * omega), atol=1e-12)


def test_modal_ratios_hold_in_the_lowest_modes_alone_where_so_many_are_asked_for(pair):
    omega, C = modal_ratios(ModalDamping([0.01, 0.02], n_modes=4), *pair)
    expected = np.array([0.01, 0.02, 0.02, 0.02, 0.0, 0.0])
    np.testing.assert_allclose(C, np.diag(2 * expected * omega), atol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: RayleighDamping(-1.0, 0.0), "alpha is -1.0; it must be zero or positive"),
        (lambda: LinearRayleighDamping(0.0, -2.0), "linear Rayleigh damping: beta is -2.0; it must be zero"),
        (lambda: RayleighDamping(0.0, np.nan), "beta is nan; it must be zero or positive"),
        (lambda: rayleigh_from_ratios(0.02, 3.0, 3.0), "two distinct positive frequencies, not 3.0 and 3.0"),
        (lambda: rayleigh_from_ratios(0.02, 0.0, 3.0), "two distinct positive frequencies, not 0.0 and 3.0"),
        (lambda: rayleigh_from_ratios((0.5, 0.01), 1.0, 2.0), "beta is -.*; it must be zero or positive"),
        (lambda: ModalDamping(-0.1), "modal damping ratios must be zero or positive"),
        (lambda: ModalDamping([]), "modal damping ratios must be zero or positive"),
        (lambda: ModalDamping([0.1, np.nan]), "modal damping ratios must be zero or positive"),
        (lambda: ModalDamping(0.1, n_modes=0), "n_modes is 0; damp at least one mode"),
        (lambda: ModalDamping(np.eye(2)), "modal damping ratios must be zero or positive"),
    ],
)
def test_damping_that_would_drive(make, message):
    with pytest.raises(ModelError, match=message):
        make()
