"""Craig-Bampton's matrices, with residual modes and without."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import (
    CraigBampton,
    CraigBamptonResidual,
    NoDerivatives,
    NoLoads,
    craig_bampton_component,
    enhanced_component,
    fixed_interface_component,
    fixed_interface_modes,
    reduce,
    residual_component,
)

BUILDERS = [craig_bampton_component, residual_component, enhanced_component]


@pytest.fixture(scope="module")
def component(solid_body):
    return fixed_interface_component(solid_body, fixed_interface_modes(solid_body, 30))


def test_bar_under_its_own_inertia(bar):
    """u = (rho/E)(L x - x^2/2): X = (rho A)^2 L^3 / 3 EA, X2 = 2 (rho A)^3 L^5 / 15 (EA)^2."""
    component = fixed_interface_component(bar.body, fixed_interface_modes(bar.body, 0))
    m, EA, L = bar.mass_per_length, bar.axial_stiffness, bar.length
    np.testing.assert_allclose(component.interface_mass[0, 0], m * L, rtol=1e-12)
    np.testing.assert_allclose(component.residual_flexibility[0, 0], m**2 * L**3 / (3 * EA), rtol=1e-3)
    np.testing.assert_allclose(component.residual_mass[0, 0], 2 * m**3 * L**5 / (15 * EA**2), rtol=1e-3)


def test_fewer_modes_leave_the_residual_that_they_would_have_had(solid_body, component):
    fewer = component.leading(11)
    fresh = fixed_interface_component(solid_body, fixed_interface_modes(solid_body, 11))
    for name in ("residual_flexibility", "residual_mass"):
        expected = getattr(fresh, name)
        np.testing.assert_allclose(getattr(fewer, name), expected, atol=1e-9 * np.abs(expected).max())


def test_matrices_give_the_frequencies_of_the_bases(solid_body, mean_axis, component):
    for build, recipe in (
        (craig_bampton_component, CraigBampton(n_modes=9)),
        (residual_component, CraigBamptonResidual(n_modes=9)),
    ):
        reduced = reduce(solid_body, mean_axis, recipe, derivatives=NoDerivatives(), loads=NoLoads)
        spectrum = build(component.leading(9)).interfaces_free().spectrum[6:]
        np.testing.assert_allclose(spectrum, reduced.frequencies**2, rtol=1e-7)


@pytest.mark.parametrize("build", BUILDERS)
def test_ritz_eigenvalues_are_never_too_low(solid_body, component, exact_eigenvalues, added_mass, build):
    model = build(component.leading(10))
    free = model.interfaces_free().eigenvalues(16)[6:] / exact_eigenvalues(solid_body, 10)
    clamped = model.interfaces_fixed().eigenvalues(6) / exact_eigenvalues(solid_body, 6, clamped=True)
    loaded = model.interfaces_loaded(added_mass).eigenvalues(16)[6:]
    loaded = loaded / exact_eigenvalues(solid_body, 10, added_mass=added_mass)
    for ratios in (free, clamped, loaded):
        assert (ratios > 1.0 - 1e-9).all()
    assert free.max() > 1.0 + 1e-6


def test_residual_modes_raise_the_order_of_the_error(solid_body, component, exact_eigenvalues):
    """Errors of about the square of those without: first order is taken out, at every eigenvalue."""
    exact = exact_eigenvalues(solid_body, 5)
    plain, wide, enhanced = (
        build(component.leading(12)).interfaces_free().eigenvalues(11)[6:] / exact - 1.0 for build in BUILDERS
    )
    assert (wide < 3.0 * plain**2).all()
    # Kim and Lee's columns lie in the span of the residual modes' wider basis.
    assert (enhanced > wide - 1e-10).all()
    assert (enhanced < 30.0 * plain**2).all()


def test_all_modes_make_the_body_exact(solid_body, exact_eigenvalues, added_mass):
    every = fixed_interface_component(solid_body, fixed_interface_modes(solid_body, solid_body.n - 12))
    exact = exact_eigenvalues(solid_body, 40, added_mass=added_mass)
    for build in BUILDERS:
        model = build(every).interfaces_loaded(added_mass)
        np.testing.assert_allclose(model.eigenvalues(46)[6:], exact, rtol=1e-7)


def test_more_modes_than_there_are_cannot_be_kept(component):
    with pytest.raises(ModelError, match="31 modes requested of a component that has 30"):
        component.leading(31)


def test_body_without_interfaces_is_refused(loose_body, strip_body):
    with pytest.raises(ModelError, match="needs interfaces, but body 'strip' has none"):
        fixed_interface_component(loose_body, fixed_interface_modes(strip_body, 1))
    with pytest.raises(ModelError, match="a vibration with fixed interfaces needs interfaces, but body"):
        fixed_interface_modes(loose_body, 1)
