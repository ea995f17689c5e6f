"""The space of an error: orthonormal, seen from the frame, without columns of round-off."""

from __future__ import annotations

import numpy as np
import pytest
from error.equation.machines import MEAN, NODAL, soft_strip

from supple.body import frame_projector
from supple.error.equation import error_space, modes_in_frame
from supple.reduction import CompressedDerivatives, CraigBampton, reduction_basis

FRAMES = {"nodal-fixed": NODAL, "mean-axis": MEAN}


@pytest.fixture(scope="module", params=FRAMES)
def start(request):
    """A body, its frame, a basis, its modes, and fields that bend it."""
    body, frame = soft_strip("strip", 1.0), FRAMES[request.param]
    basis = reduction_basis(body, frame, CraigBampton(3), derivatives=CompressedDerivatives(3)).vectors
    deformed = 0.05 * basis @ np.random.default_rng(0).standard_normal((basis.shape[1], 3))
    return body, frame, basis, modes_in_frame(body, frame, 12), deformed


def test_columns_are_orthonormal_and_hold_the_frame(start):
    body, frame, basis, modes, deformed = start
    fields = frame_projector(body, frame)(np.random.default_rng(1).standard_normal((body.n, 6)))
    space = error_space(modes, basis, fields, deformed)
    Z = space.vectors
    np.testing.assert_allclose(Z.T @ (body.mass @ Z), np.eye(space.size), atol=1e-9)
    D = frame.constraint(body)
    assert np.abs(D @ Z).max() < 1e-9 * np.linalg.norm(D, axis=1).max() * np.linalg.norm(Z, axis=0).max()
    np.testing.assert_array_equal(Z[:, : basis.shape[1]], basis)
    assert space.n_motion == basis.shape[1]


def test_modes_and_corrections_are_in_it(start):
    body, frame, basis, modes, deformed = start
    field = frame_projector(body, frame)(np.random.default_rng(1).standard_normal((body.n, 1)))
    Z = error_space(modes, basis, field, deformed).vectors
    for fields in (modes.vectors, field):
        left = fields - Z @ (Z.T @ (body.mass @ fields))
        assert np.abs(left).max() < 1e-6 * np.abs(fields).max()


def test_round_off_of_a_field_is_no_column(start):
    """A correction within the basis but for 1e-9 of itself: scaled up, it would turn the frame."""
    body, _, basis, modes, _ = start
    none = np.zeros((body.n, 0))
    noise = np.random.default_rng(2).standard_normal((body.n, 1))
    within = basis[:, :1] + 1e-9 * noise * np.linalg.norm(basis[:, 0]) / np.linalg.norm(noise)
    without = error_space(modes, basis, none, none).size
    assert error_space(modes, basis, within, none).size == without


def test_a_body_of_fewer_freedoms_has_all_its_modes():
    body = soft_strip("strip", 1.0, cells=2)
    modes = modes_in_frame(body, NODAL, 1000)
    assert modes.vectors.shape[1] == body.n - 6
