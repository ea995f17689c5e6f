"""Compression: the columns that miss least of the weighted derivatives (Eckart-Young in the M-norm)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from supple.body import NodalFixedFrame, RigidInterface, flexible_body
from supple.errors import ModelError
from supple.fem import BeamSection, Isotropic, shell_model
from supple.mesh import CellType, Mesh
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    ModalDerivatives,
    NoLoads,
    NormalModes,
    compress,
    modal_derivatives,
    rayleigh_ritz,
    reduce,
)


@pytest.fixture(scope="module")
def case(solid_body, root_frame):
    basis = rayleigh_ritz(solid_body, root_frame, NormalModes(4).build(solid_body, root_frame))
    return solid_body, root_frame, basis, modal_derivatives(solid_body, root_frame, basis)


def test_singular_values_and_columns_are_those_of_the_weighted_block(case):
    body, frame, basis, derivatives = case
    compressed = CompressedDerivatives(3).columns(body, frame, basis)
    root = linalg.cholesky(body.mass.toarray())
    weighted = derivatives.vectors * AmplitudeProduct().weights(body, basis, derivatives)
    outside = weighted - basis.vectors @ (basis.vectors.T @ (body.mass @ weighted))
    U, s, _ = np.linalg.svd(root @ outside, full_matrices=False)
    np.testing.assert_allclose(compressed.singular_values_kept, s[:3] / s[0], rtol=1e-8)
    np.testing.assert_allclose(compressed.singular_values_dropped, s[3:] / s[0], atol=1e-8)
    cosines = np.linalg.svd(U[:, :3].T @ root @ compressed.vectors, compute_uv=False)
    np.testing.assert_allclose(cosines, 1.0, rtol=1e-10)


def test_dropped_singular_values_measure_what_is_missed(case):
    body, _, basis, derivatives = case
    weights = AmplitudeProduct().weights(body, basis, derivatives)
    compressed = compress(body, basis, derivatives, 4, weights)
    V = np.hstack([basis.vectors, compressed.vectors])
    weighted = derivatives.vectors * weights
    missed = weighted - V @ (V.T @ (body.mass @ weighted))
    largest = compress(body, basis, derivatives, 1, weights).vectors.T @ (body.mass @ weighted)
    expected = np.linalg.norm(largest) ** 2 * np.sum(compressed.singular_values_dropped**2)
    np.testing.assert_allclose(np.sum(missed * (body.mass @ missed)), expected, rtol=1e-6)


def test_columns_are_orthonormal_and_outside_the_linear_basis(case):
    body, frame, basis, _ = case
    V = np.hstack([basis.vectors, CompressedDerivatives(10).columns(body, frame, basis).vectors])
    np.testing.assert_allclose(V.T @ (body.mass @ V), np.eye(V.shape[1]), atol=1e-9)


def test_no_more_columns_than_the_derivatives_span(case):
    body, _, basis, derivatives = case
    inside = ModalDerivatives(
        np.column_stack([derivatives.vectors[:, 0], derivatives.vectors[:, 0], basis.vectors[:, 1]]),
        derivatives.pairs[:3],
    )
    compressed = compress(body, basis, inside, 3, np.ones(3))
    assert compressed.vectors.shape[1] == 1
    assert compressed.labels == ("compressed derivative 1",)
    (why,) = compressed.dropped
    assert why.startswith("compressed derivatives 2 to 3 (all derivatives lie in 1 directions; the remainder")
    assert compress(body, basis, inside, 1, np.ones(3)).dropped == ()


def test_a_reduced_body_says_why_it_has_fewer_than_were_asked():
    """Ten pairs of a straight line of beams, bent in one plane, move it along its axis in a few ways."""
    points = np.column_stack([np.linspace(0.0, 1.0, 13), np.zeros(13), np.zeros(13)])
    cells = {CellType.LINE2: np.column_stack([np.arange(12), np.arange(1, 13)])}
    section = BeamSection(Isotropic(2.1e11, 0.3, 7850.0), 1e-4, 1e-9, 1e-9, 2e-9, orientation=[0, 1.0, 0])
    model = shell_model(Mesh(points, cells, {"root": np.array([0])}), section)
    body = flexible_body("arm", model, (RigidInterface("root", "root"),))
    reduced = reduce(
        body, NodalFixedFrame("root"), CraigBampton(4), derivatives=CompressedDerivatives(10), loads=NoLoads
    )
    count = len(reduced.report.derivatives)
    assert count < 10
    assert repr(reduced).startswith(f"<ReducedBody 'arm', {4 + count} coordinates")
    why = f"compressed derivatives {count + 1} to 10 (all derivatives lie in {count} directions"
    assert why in str(reduced.report)


def test_more_columns_than_pairs_are_refused(case):
    body, frame, basis, _ = case
    with pytest.raises(ModelError, match="requested 11 derivatives, but 4 linear columns have 10 pairs"):
        CompressedDerivatives(11).columns(body, frame, basis)
