"""Weights of pairs: expected static amplitudes, and modal virtual work."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import (
    AmplitudeProduct,
    ModalVirtualWork,
    NormalModes,
    StaticLoad,
    UnitLoad,
    modal_derivatives,
    rayleigh_ritz,
)


@pytest.fixture(scope="module")
def case(cantilever, root_frame):
    basis = rayleigh_ritz(cantilever, root_frame, NormalModes(3).build(cantilever, root_frame))
    return cantilever, basis, modal_derivatives(cantilever, root_frame, basis)


def test_unit_load_weights_are_inverse_squares_of_frequencies(case):
    body, basis, derivatives = case
    w = basis.frequencies
    times = np.array([1, 2, 2, 1, 2, 1])
    expected = times / (w[[0, 0, 0, 1, 1, 2]] * w[[0, 1, 2, 1, 2, 2]]) ** 2
    np.testing.assert_allclose(AmplitudeProduct().weights(body, basis, derivatives), expected, rtol=1e-12)


def test_amplitudes_of_a_load_are_those_of_the_linear_static_answer(case):
    """With all load in the span of the modes, q = sum +-p_j phi_j solves K q = F."""
    body, basis, _ = case
    force = body.mass @ basis.vectors @ np.array([3.0, -2.0, 1.0])
    nodal = np.linalg.lstsq(body.expansion.T.toarray(), force, rcond=None)[0]
    amplitudes = StaticLoad(nodal).amplitudes(body, basis)
    np.testing.assert_allclose(amplitudes, np.array([3.0, 2.0, 1.0]) / basis.frequencies**2, rtol=1e-8)


def test_virtual_work_is_that_of_the_quadratic_force_on_the_derivative(case):
    """W = |(w theta_jk)^T (w f''(X_j, X_k))|, w = p_j p_k (twice for j < k)."""
    body, basis, derivatives = case
    weights = AmplitudeProduct(UnitLoad()).weights(body, basis, derivatives)
    forces = body.assembly.pair_forces(basis.vectors)
    work = np.abs(np.sum(weights * derivatives.vectors * weights * forces, axis=0))
    rank = ModalVirtualWork().rank(body, basis, derivatives)
    np.testing.assert_allclose(rank, work, atol=1e-8 * work.max())


def test_load_of_wrong_shape_is_refused(case):
    body, basis, _ = case
    with pytest.raises(
        ModelError, match=r"the load has shape \(4,\), but body 'strip' has \d+ nodal freedoms"
    ):
        StaticLoad(np.ones(4)).amplitudes(body, basis)


def test_load_that_moves_nothing_is_refused(case):
    body, basis, _ = case
    with pytest.raises(ModelError, match="excites no mode of body 'strip'"):
        StaticLoad(np.zeros(body.expansion.shape[0])).amplitudes(body, basis)
