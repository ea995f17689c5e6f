"""MacNeal's method: Rubin's without the mass of the residual shapes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import AccuracyError
from supple.reduction import (
    MacNealComponent,
    free_interface_component,
    free_interface_modes,
    rubin_component,
)


@pytest.fixture(scope="module")
def component(solid_body):
    return free_interface_component(solid_body, free_interface_modes(solid_body, 30))


def test_eigenvalues_are_above_rubins_which_are_above_the_exact_ones(
    solid_body, component, exact_eigenvalues, added_mass
):
    """Less mass at the same stiffness: every eigenvalue higher (Weyl), and far less accurate."""
    parts = component.leading(14)
    macneal, rubin = MacNealComponent(parts), rubin_component(parts)
    for exact, n_rigid, matrices in (
        (exact_eigenvalues(solid_body, 8, clamped=True), 0, lambda m: m.interfaces_fixed()),
        (
            exact_eigenvalues(solid_body, 8, added_mass=added_mass),
            6,
            lambda m: m.interfaces_loaded(added_mass),
        ),
    ):
        errors = [matrices(m).eigenvalues(n_rigid + 8)[n_rigid:] / exact - 1.0 for m in (macneal, rubin)]
        assert (errors[0] > errors[1] - 1e-9).all()
        assert (errors[1] > -1e-9).all()
        assert errors[0].max() > 3.0 * errors[1].max()


def test_errors_only_fall_with_the_number_of_modes(component, added_mass):
    """Of a mode left out the mass is missing; kept, it has its mass."""
    spectra = [
        MacNealComponent(component.leading(n)).interfaces_loaded(added_mass).eigenvalues(12)[6:]
        for n in range(6, 31, 3)
    ]
    assert (np.diff(spectra, axis=0) <= 1e-9 * np.array(spectra[1:])).all()


def test_statics_are_exact(solid_body, component):
    """The stiffness seen by the interfaces when the modes follow: Guyan's."""
    K = MacNealComponent(component).interfaces_loaded(np.eye(12)).stiffness
    n = component.eigenvalues.size
    # Rigid motions need no force, so the modes' block is singular but consistent.
    condensed = K[n:, n:] - K[n:, :n] @ np.linalg.solve(K[:n, :n], K[:n, n:])
    shapes = solid_body.constrained(np.vstack([i.motion.toarray() for i in solid_body.interfaces])).solve(
        values=np.eye(12)
    )
    expected = shapes.T @ (solid_body.stiffness @ shapes)
    np.testing.assert_allclose(condensed, expected, atol=1e-7 * np.abs(expected).max())


def test_free_interfaces_see_the_free_modes(component):
    spectrum = MacNealComponent(component).interfaces_free().spectrum
    np.testing.assert_allclose(spectrum, component.eigenvalues, rtol=1e-12)


def test_all_modes_leave_nothing_to_join_the_interface_by(solid_body):
    every = free_interface_component(solid_body, free_interface_modes(solid_body, solid_body.n - 6))
    with pytest.raises(AccuracyError, match="MacNeal's method needs a residual flexibility"):
        MacNealComponent(every)
