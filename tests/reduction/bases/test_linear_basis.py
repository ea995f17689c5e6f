"""The linear basis as modes of its own span (Rayleigh-Ritz), and what it drops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.errors import AccuracyError, ModelError
from supple.reduction import CraigBampton, Guyan, NormalModes, Rubin, rayleigh_ritz

RECIPES = [Guyan(), CraigBampton(n_modes=3), Rubin(n_modes=3), NormalModes(5)]


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: type(recipe).__name__)
def test_columns_vibrate_in_the_frame(strip_body, frame, recipe):
    """X^T M X = I, X^T K X = diag(omega^2), D X = 0."""
    basis = rayleigh_ritz(strip_body, frame, recipe.build(strip_body, frame))
    X = basis.vectors
    np.testing.assert_allclose(X.T @ (strip_body.mass @ X), np.eye(X.shape[1]), atol=1e-9)
    squares = basis.frequencies**2
    np.testing.assert_allclose(X.T @ (strip_body.stiffness @ X), np.diag(squares), atol=1e-8 * squares.max())
    assert (np.diff(squares) >= 0).all()
    D = frame.constraint(strip_body)
    lengths = np.linalg.norm(D, axis=1)[:, None] * np.linalg.norm(X, axis=0)
    assert (np.abs(D @ X) <= 1e-10 * lengths).all()


def test_span_is_that_of_the_raw_columns(strip_body, root_frame):
    raw = Rubin(n_modes=3).build(strip_body, root_frame)
    X = rayleigh_ritz(strip_body, root_frame, raw).vectors
    outside = raw.vectors - X @ (X.T @ (strip_body.mass @ raw.vectors))
    assert (np.linalg.norm(outside, axis=0) < 1e-8 * np.linalg.norm(raw.vectors, axis=0)).all()


def test_rank_deficient_columns_are_dropped_and_named(strip_body, root_frame):
    raw = NormalModes(3).build(strip_body, root_frame)
    a, b, _ = raw.vectors.T
    deficient = replace(raw, vectors=np.column_stack([a, b, 3 * a - 2 * b]), labels=("a", "b", "a and b"))
    basis = rayleigh_ritz(strip_body, root_frame, deficient)
    assert basis.labels == ("a", "b")
    assert basis.dropped == ("a and b",)


def test_rigid_motion_is_the_frames_and_dropped(strip_body, frame):
    raw = NormalModes(1).build(strip_body, frame)
    with_rigid = replace(
        raw, vectors=np.column_stack([strip_body.rigid_modes[:, 4], raw.vectors]), labels=("turn", "mode 1")
    )
    assert rayleigh_ritz(strip_body, frame, with_rigid).dropped == ("turn",)


def test_empty_basis_is_refused(cantilever, root_frame):
    with pytest.raises(ModelError, match="the linear basis of body 'strip' is empty"):
        rayleigh_ritz(cantilever, root_frame, Guyan().build(cantilever, root_frame))


def test_column_without_energy_is_refused(strip_body, root_frame):
    raw = NormalModes(2).build(strip_body, root_frame)
    no_stiffness = replace(strip_body, stiffness=0.0 * strip_body.stiffness)
    with pytest.raises(AccuracyError, match="stores no energy"):
        rayleigh_ritz(no_stiffness, root_frame, raw)
