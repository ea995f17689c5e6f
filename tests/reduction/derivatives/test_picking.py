"""Picking: the pairs of highest rank, in order, passing over those that add nothing."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import VON_KARMAN, HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import (
    AmplitudeProduct,
    ModalDerivatives,
    ModalVirtualWork,
    NormalModes,
    PickedDerivatives,
    modal_derivatives,
    pick,
    rayleigh_ritz,
)


@pytest.fixture(scope="module")
def case(cantilever, root_frame):
    basis = rayleigh_ritz(cantilever, root_frame, NormalModes(3).build(cantilever, root_frame))
    return cantilever, root_frame, basis, modal_derivatives(cantilever, root_frame, basis)


@pytest.mark.parametrize("criterion", [AmplitudeProduct(), ModalVirtualWork()])
def test_picked_columns_are_the_highest_ranked_derivatives(case, criterion):
    body, frame, basis, derivatives = case
    picked = PickedDerivatives(3, criterion=criterion).columns(body, frame, basis)
    order = np.argsort(-criterion.rank(body, basis, derivatives))
    ranked = [derivatives.labels[i] for i in order]
    assert list(picked.labels) == [label for label in ranked if label not in picked.dropped][:3]
    span = np.hstack([basis.vectors, picked.vectors])
    np.testing.assert_allclose(span.T @ (body.mass @ span), np.eye(6), atol=1e-9)
    chosen = derivatives.vectors[:, [derivatives.labels.index(label) for label in picked.labels]]
    outside = chosen - span @ (span.T @ (body.mass @ chosen))
    assert np.abs(outside).max() < 1e-9 * np.abs(chosen).max()


def test_dependent_candidates_are_passed_over_and_reported(case):
    body, _, basis, derivatives = case
    first = derivatives.vectors[:, :1]
    candidates = ModalDerivatives(
        np.hstack([first, 2 * first + basis.vectors[:, :1], derivatives.vectors[:, 1:2]]),
        derivatives.pairs[:3],
    )
    picked = pick(body, basis, candidates, 2, np.array([3.0, 2.0, 1.0]))
    assert picked.labels == ("derivative 1-1", "derivative 1-3")
    assert picked.dropped == ("derivative 1-2",)


def test_derivative_that_vanishes_is_passed_over_though_the_solve_leaves_round_off(root_frame):
    """Von Karman strains see no rotation in the plane: the second mode of the strip bends there, w = 0."""
    material = Isotropic(1e9, 0.0, 1000.0)
    model = shell_model(strip(10.0, 0.4, 24, 2), HomogeneousSection(material, 0.08), kinematics=VON_KARMAN)
    body = flexible_body("flat", model, (RigidInterface("root", "root"),))
    basis = rayleigh_ritz(body, root_frame, NormalModes(3).build(body, root_frame))
    picked = PickedDerivatives(6).columns(body, root_frame, basis)
    assert "derivative 2-2" in picked.dropped
    assert "derivative 1-1" in picked.labels
    assert "derivative 1-2" in picked.labels


def test_fewer_columns_when_no_independent_one_is_left(case):
    body, _, basis, derivatives = case
    candidates = ModalDerivatives(np.repeat(derivatives.vectors[:, :1], 3, axis=1), derivatives.pairs[:3])
    picked = pick(body, basis, candidates, 2, np.ones(3))
    assert picked.vectors.shape[1] == 1
    assert len(picked.dropped) == 2


@pytest.mark.parametrize("n", [7, -1])
def test_more_derivatives_than_pairs_are_refused(case, n):
    body, frame, basis, _ = case
    with pytest.raises(ModelError, match=f"requested {n} derivatives, but 3 linear columns have 6 pairs"):
        PickedDerivatives(n).columns(body, frame, basis)
