"""Small matrices that stand for a body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from supple.errors import AccuracyError, ModelError
from supple.reduction import ReducedMatrices, RitzComponent, interface_shapes
from supple.reduction.bases.interface_columns import motion_rows


def _complete(body):
    """The full body as a component: every coordinate a column."""
    B = motion_rows(body.interfaces)
    return RitzComponent(body.stiffness.toarray(), body.mass.toarray(), B)


def test_complete_component_is_the_body_however_its_interfaces_are_held(
    solid_body, exact_eigenvalues, added_mass
):
    component = _complete(solid_body)
    np.testing.assert_allclose(
        component.interfaces_free().eigenvalues(16)[6:], exact_eigenvalues(solid_body, 10), rtol=1e-7
    )
    np.testing.assert_allclose(
        component.interfaces_fixed().eigenvalues(10),
        exact_eigenvalues(solid_body, 10, clamped=True),
        rtol=1e-7,
    )
    np.testing.assert_allclose(
        component.interfaces_loaded(added_mass).eigenvalues(16)[6:],
        exact_eigenvalues(solid_body, 10, added_mass=added_mass),
        rtol=1e-7,
    )


def test_modes_solve_the_eigenproblem():
    rng = np.random.default_rng(1)
    root, other = rng.standard_normal((2, 6, 6))
    K, M = root @ root.T, other @ other.T + np.eye(6)
    values, vectors = ReducedMatrices(K, M).modes()
    np.testing.assert_allclose(vectors.T @ M @ vectors, np.eye(6), atol=1e-12)
    np.testing.assert_allclose(K @ vectors, M @ vectors * values, atol=1e-10 * values.max())
    np.testing.assert_allclose(values, linalg.eigh(K, M, eigvals_only=True), rtol=1e-9)


def test_repeated_columns_add_no_eigenvalue(solid_body):
    shapes = interface_shapes(solid_body)
    repeated = np.hstack([shapes, 3.0 * shapes[:, :2]])
    spectra = [
        ReducedMatrices(V.T @ solid_body.stiffness @ V, V.T @ solid_body.mass @ V).spectrum
        for V in (shapes, repeated)
    ]
    assert spectra[1].size == 12
    np.testing.assert_allclose(spectra[1][6:], spectra[0][6:], rtol=1e-8)


def test_indefinite_mass_is_refused():
    with pytest.raises(AccuracyError, match=r"the reduced mass is indefinite: .* is -1.0e\+00"):
        _ = ReducedMatrices(np.eye(2), np.array([[1.0, 2.0], [2.0, 1.0]])).spectrum


def test_dependent_forces_are_refused():
    mass = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    with pytest.raises(AccuracyError, match="residual shapes of 2 interface forces depend on one another"):
        _ = ReducedMatrices(np.diag([1.0, -1.0, -1.0]), mass, n_forces=2).spectrum


@pytest.mark.parametrize("count", [0, 3])
def test_only_eigenvalues_that_exist_can_be_asked_for(count):
    with pytest.raises(ModelError, match=f"{count} eigenvalues requested of a reduced body that has 2"):
        ReducedMatrices(np.eye(2), np.eye(2)).eigenvalues(count)
