"""Mode ranking by the moments of the interface's dynamic stiffness [LiaoBaiGao2007]."""

from __future__ import annotations

import numpy as np
import pytest

from supple.reduction import (
    CouplingMoment,
    coupling_moments,
    fixed_interface_component,
    fixed_interface_modes,
)


@pytest.fixture(scope="module")
def component(solid_body):
    return fixed_interface_component(solid_body, fixed_interface_modes(solid_body, 30))


def _trace(component):
    """Of M_b^-1 X: the moment that the modes of a component leave out."""
    return np.trace(np.linalg.solve(component.interface_mass, component.residual_flexibility))


def test_moments_make_up_what_the_residual_holds_without_them(component):
    np.testing.assert_allclose(
        np.sum(coupling_moments(component)), _trace(component.leading(0)) - _trace(component), rtol=1e-9
    )


def test_best_modes_leave_less_out_than_the_lowest(solid_body, component):
    """Keeping those of largest moment leaves the least: no other choice of as many leaves less."""
    best = np.argsort(-CouplingMoment(30).scores(solid_body, component))[:8]
    left = _trace(component.keeping(best))
    assert left < _trace(component.leading(8))
    for seed in range(20):
        other = np.random.default_rng(seed).permutation(30)[:8]
        assert left <= _trace(component.keeping(other))


def test_expansion_of_the_dynamic_stiffness(component):
    """s^2 sum p^T p / (kappa - s) = s^2 (X_0 + s X2_0 + ...) of the modes together."""
    s = 1e-3 * component.eigenvalues[0]
    P = component.participation
    exact = (P.T / (component.eigenvalues - s)) @ P
    none = component.leading(0)
    first = none.residual_flexibility - component.residual_flexibility
    second = none.residual_mass - component.residual_mass
    np.testing.assert_allclose(exact, first + s * second, atol=2e-6 * np.abs(exact).max())
