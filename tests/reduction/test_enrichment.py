"""Enrichment: the directions that leave least of the given fields outside the basis."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    NoLoads,
    enrich,
    leading_directions,
    project,
    reduce,
    reduction_basis,
)


@pytest.fixture(scope="module")
def start(solid_body, root_frame):
    return reduction_basis(
        solid_body, root_frame, CraigBampton(n_modes=3), derivatives=CompressedDerivatives(2)
    )


@pytest.fixture(scope="module")
def fields(solid_body):
    """Fields of very different sizes, one of them a rigid motion in part."""
    rng = np.random.default_rng(0)
    return rng.standard_normal((solid_body.n, 6)) * 10.0 ** -np.arange(6) + solid_body.rigid_modes[:, :1]


STEPS = {"linear basis", "derivatives", "inertia", "tensors", "condensation", "locking"}


def test_columns_are_orthonormal_at_rest_in_the_frame_and_follow_the_old_ones(solid_body, start, fields):
    basis = enrich(solid_body, start, fields, 3).basis
    assert basis.r == start.r + 3
    np.testing.assert_allclose(basis.vectors[:, : start.r], start.vectors, rtol=0, atol=1e-9)
    gram = basis.vectors.T @ (solid_body.mass @ basis.vectors)
    np.testing.assert_allclose(gram, np.eye(basis.r), atol=1e-10)
    clamped = start.frame.constraint(solid_body) @ basis.vectors
    assert np.abs(clamped).max() < 1e-10 * np.abs(basis.vectors).max()


def test_what_is_missed_is_what_the_singular_values_left_out_say(solid_body, start, fields):
    """Eckart-Young: sum of squares outside the new basis = sum of the squared values not taken."""
    enriched = enrich(solid_body, start, fields, 2)
    V, R = enriched.basis.vectors, solid_body.rigid_modes
    D = start.frame.constraint(solid_body)
    seen = fields - R @ np.linalg.solve(D @ R, D @ fields)
    missed = seen - V @ (V.T @ (solid_body.mass @ seen))
    np.testing.assert_allclose(
        np.sum(missed * (solid_body.mass @ missed)), np.sum(enriched.singular_values[2:] ** 2), rtol=1e-8
    )


def test_a_field_inside_the_basis_adds_nothing(solid_body, start):
    inside = start.vectors @ np.ones((start.r, 1))
    enriched = enrich(solid_body, start, inside, 3)
    assert enriched.basis.r == start.r
    assert enriched.singular_values.size == 0


def test_directions_are_those_of_the_weighted_singular_value_decomposition(solid_body, start, fields):
    norms = np.sqrt(np.sum(fields * (solid_body.mass @ fields), axis=0))
    directions = leading_directions(fields, start.vectors, solid_body.mass, norms)
    root = np.linalg.cholesky(solid_body.mass.toarray()).T
    outside = fields - start.vectors @ (start.vectors.T @ (solid_body.mass @ fields))
    values = np.linalg.svd(root @ outside, compute_uv=False)
    np.testing.assert_allclose(directions.lengths, values, rtol=1e-8)


def test_labels_count_on(solid_body, start, fields):
    once = enrich(solid_body, start, fields[:, :2], 2).basis
    twice = enrich(solid_body, once, fields[:, 2:], 1).basis
    assert twice.report.corrections == ("correction 1", "correction 2", "correction 3")
    assert twice.report.linear == start.report.linear


def test_projecting_a_basis_is_what_reduce_does(solid_body, root_frame, start):
    once = project(solid_body, start)
    reduced = reduce(
        solid_body, root_frame, CraigBampton(n_modes=3), derivatives=CompressedDerivatives(2), loads=NoLoads
    )
    np.testing.assert_array_equal(once.quartic, reduced.quartic)
    assert set(once.report.seconds) == STEPS


def test_refuses_no_directions(solid_body, start, fields):
    with pytest.raises(ModelError, match="with 0 directions; give one or more"):
        enrich(solid_body, start, fields, 0)


def test_refuses_fields_of_another_size(solid_body, start, fields):
    with pytest.raises(ModelError, match="have shape"):
        enrich(solid_body, start, fields[1:], 2)
