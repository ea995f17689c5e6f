"""Normal modes in a frame: K Phi + D^T mu = M Phi diag(omega^2), D Phi = 0."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from supple.errors import ModelError
from supple.reduction import CompleteBasis, NormalModes


def test_modes_satisfy_the_constrained_eigenproblem(strip_body, frame):
    basis = NormalModes(5).build(strip_body, frame)
    D = frame.constraint(strip_body)
    residual = strip_body.stiffness @ basis.vectors - strip_body.mass @ basis.vectors * basis.frequencies**2
    multipliers = np.linalg.lstsq(D.T, residual, rcond=None)[0]
    scale = np.abs(strip_body.stiffness @ basis.vectors).max()
    np.testing.assert_allclose(residual, D.T @ multipliers, atol=1e-7 * scale)
    np.testing.assert_allclose(basis.vectors.T @ (strip_body.mass @ basis.vectors), np.eye(5), atol=1e-9)


def test_mean_axis_modes_are_the_elastic_modes_of_the_free_body(solid_body, mean_axis):
    free = linalg.eigh(solid_body.stiffness.toarray(), solid_body.mass.toarray(), eigvals_only=True)
    frequencies = NormalModes(4).build(solid_body, mean_axis).frequencies
    np.testing.assert_allclose(frequencies**2, free[6:10], rtol=1e-8)


def test_cantilever_frequencies_are_those_of_the_beam(cantilever, root_frame):
    """omega = (beta L)^2 sqrt(EI / (rho A L^4)): first out of plane, first in plane, second out of plane."""
    frequencies = NormalModes(3).build(cantilever, root_frame).frequencies
    in_plane = 2.8e7 * 0.4**2 / 12
    exact = np.array([1.8751041, 1.8751041, 4.6940911]) ** 2 * np.sqrt(
        np.array([1.4e4, in_plane, 1.4e4]) / (1.2 * 10.0**4)
    )
    np.testing.assert_allclose(frequencies, exact, rtol=0.03)


def test_complete_basis_has_every_mode(strip_body, frame):
    n = strip_body.stiffness.shape[0]
    assert CompleteBasis().build(strip_body, frame).vectors.shape == (n, n - 6)


@pytest.mark.parametrize("n_modes", [-1, 10_000])
def test_impossible_numbers_of_modes_are_refused(strip_body, root_frame, n_modes):
    with pytest.raises(ModelError, match=rf"n_modes = {n_modes}, but body 'strip' has \d+ modes"):
        NormalModes(n_modes).build(strip_body, root_frame)
