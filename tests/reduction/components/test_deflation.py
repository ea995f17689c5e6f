"""The static response of the modes left out."""

from __future__ import annotations

import numpy as np

from supple.algebra import Eigenpairs, RitzModes
from supple.reduction import fixed_interface_modes, interface_shapes
from supple.reduction.bases.interface_columns import motion_rows
from supple.reduction.components.deflation import residual_response


def _first(modes, count):
    return RitzModes.of(Eigenpairs(modes.values[:count], modes.vectors[:, :count]))


def test_residual_is_the_sum_over_the_modes_left_out(solid_body):
    """Y = sum over them of phi (phi^T A) / kappa, to all digits however few they are."""
    B = motion_rows(solid_body.interfaces)
    every = fixed_interface_modes(solid_body, solid_body.n - len(B))
    A = solid_body.mass @ interface_shapes(solid_body)
    for count in (0, 10, every.values.size - 3):
        residual = residual_response(solid_body.constrained(B), solid_body.mass, _first(every, count), A)
        left = every.vectors[:, count:]
        amounts = (left.T @ A) / every.values[count:, None]
        np.testing.assert_allclose(residual.columns, left @ amounts, atol=1e-9 * np.abs(left @ amounts).max())
        np.testing.assert_allclose(residual.mass, amounts.T @ amounts, atol=1e-9 * residual.mass.max())
        flexibility = amounts.T @ (amounts * every.values[count:, None])
        np.testing.assert_allclose(residual.flexibility, flexibility, atol=1e-9 * flexibility.max())


def test_residual_is_orthogonal_to_the_modes_kept(solid_body):
    modes = fixed_interface_modes(solid_body, 20)
    clamped = solid_body.constrained(motion_rows(solid_body.interfaces))
    A = solid_body.mass @ interface_shapes(solid_body)
    residual = residual_response(clamped, solid_body.mass, modes, A)
    work = modes.vectors.T @ (solid_body.mass @ residual.columns)
    assert (np.abs(work) <= 1e-12 * np.sqrt(np.diag(residual.mass))).all()
