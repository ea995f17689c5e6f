"""The dual Craig-Bampton method [Rixen2004]."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import AccuracyError
from supple.reduction import (
    DualCraigBampton,
    MacNealComponent,
    free_interface_component,
    free_interface_modes,
    rubin_component,
)


@pytest.fixture(scope="module")
def component(solid_body):
    return free_interface_component(solid_body, free_interface_modes(solid_body, 40))


def test_every_interface_force_makes_one_eigenvalue_negative(component, added_mass):
    dual = DualCraigBampton(component.leading(10))
    clamped, loaded = dual.interfaces_fixed(), dual.interfaces_loaded(added_mass)
    assert clamped.n_forces == loaded.n_forces == 12
    assert np.sum(np.linalg.eigvalsh(clamped.stiffness) < 0.0) == 12
    assert (clamped.spectrum > 0.0).all()
    assert (np.abs(loaded.spectrum[:6]) < 1e-8 * loaded.spectrum[6]).all()
    assert clamped.r == 6 + 10 + 12
    assert loaded.r == 6 + 10 + 12 + 12


def test_eigenvalues_converge_with_the_number_of_modes(solid_body, component, exact_eigenvalues, added_mass):
    clamped = exact_eigenvalues(solid_body, 5, clamped=True)
    loaded = exact_eigenvalues(solid_body, 5, added_mass=added_mass)
    worst = []
    for n_modes in (10, 20, 40):
        dual = DualCraigBampton(component.leading(n_modes))
        errors = [
            dual.interfaces_fixed().eigenvalues(5) / clamped - 1.0,
            dual.interfaces_loaded(added_mass).eigenvalues(11)[6:] / loaded - 1.0,
        ]
        worst.append([np.abs(error).max() for error in errors])
    worst = np.array(worst)
    assert (worst[1:] < 0.3 * worst[:-1]).all()
    assert (worst[-1] < 1e-3).all()


@pytest.mark.parametrize("n_modes", [0, 5, 15, 40])
def test_exact_rubin_dual_and_macneal_come_in_this_order(
    solid_body, component, exact_eigenvalues, added_mass, n_modes
):
    """F^-1 - s F^-1 H F^-1 <= (F + s H)^-1 <= F^-1: so say all eigenvalues, beyond those of the modes too."""
    parts = component.leading(n_modes)
    methods = (rubin_component(parts), DualCraigBampton(parts), MacNealComponent(parts))
    for n_rigid, matrices, exact in (
        (0, lambda m: m.interfaces_fixed(), {"clamped": True}),
        (6, lambda m: m.interfaces_loaded(added_mass), {"added_mass": added_mass}),
    ):
        spectra = [matrices(method).spectrum[n_rigid:] for method in methods]
        common = min(spectrum.size for spectrum in spectra)
        rows = [exact_eigenvalues(solid_body, common, **exact), *(s[:common] for s in spectra)]
        assert (np.diff(rows, axis=0) >= -1e-9 * rows[0]).all()
        assert (rows[3] > rows[0] * (1.0 + 1e-9)).any()


def test_eigenvalues_only_fall_with_the_number_of_modes(component, added_mass):
    """Matrices for fewer modes are a principal part of those for more: eigenvalues interlace."""
    for matrices in (lambda m: m.interfaces_fixed(), lambda m: m.interfaces_loaded(added_mass)):
        spectra = np.array(
            [matrices(DualCraigBampton(component.leading(n))).eigenvalues(12)[6:] for n in range(6, 41, 2)]
        )
        assert (np.diff(spectra, axis=0) <= 1e-9 * spectra[1:]).all()


def test_it_is_better_than_macneals_method_from_the_same_ingredients(
    solid_body, component, exact_eigenvalues
):
    exact = exact_eigenvalues(solid_body, 5, clamped=True)
    parts = component.leading(20)
    dual, macneal = (
        method(parts).interfaces_fixed().eigenvalues(5) / exact - 1.0
        for method in (DualCraigBampton, MacNealComponent)
    )
    assert np.abs(dual).max() < np.abs(macneal).max()


def test_without_residual_mass_the_forces_can_be_eliminated_into_macneals_matrices(component):
    """Second row: B Phi eta = F f. So Lambda eta + (B Phi)^T F^-1 B Phi eta = omega^2 eta."""
    parts = component.leading(15)
    K = DualCraigBampton(parts).interfaces_fixed().stiffness
    n = parts.eigenvalues.size
    condensed = K[:n, :n] - K[:n, n:] @ np.linalg.solve(K[n:, n:], K[n:, :n])
    expected = MacNealComponent(parts).interfaces_fixed().stiffness
    np.testing.assert_allclose(condensed, expected, rtol=1e-7, atol=1e-9 * expected.max())


def test_all_modes_leave_no_force_a_flexibility(solid_body):
    every = free_interface_component(solid_body, free_interface_modes(solid_body, solid_body.n - 6))
    with pytest.raises(AccuracyError, match="the dual Craig-Bampton method needs a residual flexibility"):
        DualCraigBampton(every)
