"""Free-interface modes, and the residual flexibility of the rest."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import AccuracyError, ModelError
from supple.reduction import (
    FreeInterfaceComponent,
    NoDerivatives,
    NoLoads,
    Rubin,
    free_interface_component,
    free_interface_modes,
    reduce,
    rubin_component,
)
from supple.reduction.components.free_interface_component import require_residual


@pytest.fixture(scope="module")
def component(solid_body):
    return free_interface_component(solid_body, free_interface_modes(solid_body, 30))


def test_flexibility_of_a_free_bar_is_a_third_of_a_clamped_ones(bar):
    """Tip receptance -cot(k L) / (EA k) = -1/(m L omega^2) + L / 3 EA + ...: inertia relief."""
    component = free_interface_component(bar.body, free_interface_modes(bar.body, 0))
    np.testing.assert_allclose(
        component.residual_flexibility[0, 0], bar.length / (3 * bar.axial_stiffness), rtol=1e-3
    )


def test_rigid_motions_come_first_and_move_the_interfaces_rigidly(bar):
    component = free_interface_component(bar.body, free_interface_modes(bar.body, 2))
    np.testing.assert_array_equal(component.eigenvalues[:6], 0.0)
    # The rigid part of the receptance at the root: 1 / total mass, and the nearness of the rotation centre.
    rigid = component.interface_motion[:, :6] @ component.interface_motion[:, :6].T
    np.testing.assert_allclose(rigid[0, 0], 1.0 / (bar.mass_per_length * bar.length), rtol=1e-9)
    np.testing.assert_allclose(rigid[1, 1], 4.0 / (bar.mass_per_length * bar.length), rtol=3e-3)


def test_fewer_modes_leave_the_residual_that_they_would_have_had(solid_body, component):
    fewer = component.leading(11)
    fresh = free_interface_component(solid_body, free_interface_modes(solid_body, 11))
    for name in ("residual_flexibility", "residual_mass"):
        expected = getattr(fresh, name)
        np.testing.assert_allclose(getattr(fewer, name), expected, atol=1e-9 * np.abs(expected).max())


def test_rubins_matrices_give_the_frequencies_of_his_basis(solid_body, mean_axis, component):
    reduced = reduce(solid_body, mean_axis, Rubin(n_modes=9), derivatives=NoDerivatives(), loads=NoLoads)
    spectrum = rubin_component(component.leading(9)).interfaces_free().spectrum[6:]
    np.testing.assert_allclose(spectrum, reduced.frequencies**2, rtol=1e-7)


def test_rubins_eigenvalues_are_never_too_low(solid_body, component, exact_eigenvalues, added_mass):
    model = rubin_component(component.leading(10))
    clamped = model.interfaces_fixed().eigenvalues(10) / exact_eigenvalues(solid_body, 10, clamped=True)
    loaded = model.interfaces_loaded(added_mass).eigenvalues(16)[6:]
    loaded = loaded / exact_eigenvalues(solid_body, 10, added_mass=added_mass)
    assert (clamped > 1.0 - 1e-9).all()
    assert (loaded > 1.0 - 1e-9).all()


def test_more_modes_than_there_are_cannot_be_kept(component):
    with pytest.raises(ModelError, match="31 modes requested of a component that has 30"):
        component.leading(31)


def test_body_with_too_few_modes_is_refused(solid_body):
    with pytest.raises(ModelError, match=r"n_modes = 500, but body 'block' has 60 modes .* 6 of them fixed"):
        free_interface_modes(solid_body, 500)


def test_body_without_interfaces_is_refused(loose_body):
    with pytest.raises(ModelError, match="a free-interface component needs interfaces, but body 'strip'"):
        free_interface_component(loose_body, free_interface_modes(loose_body, 1))


def test_interfaces_that_move_as_one_are_refused(component):
    pair = np.ones((2, 2))
    twins = FreeInterfaceComponent(
        component.eigenvalues, component.interface_motion[[0, 0]], 1e-6 * pair, 1e-9 * pair
    )
    with pytest.raises(AccuracyError, match="a method needs independent interfaces, but some have no"):
        require_residual(twins, "a method")


def test_all_modes_leave_no_residual_flexibility(solid_body):
    every = free_interface_component(solid_body, free_interface_modes(solid_body, solid_body.n - 6))
    with pytest.raises(AccuracyError, match="a method needs a residual flexibility, but 60 modes leave the"):
        require_residual(every, "a method")
    elastic = rubin_component(every).interfaces_free().spectrum[6:]
    np.testing.assert_allclose(elastic, every.eigenvalues[6:], rtol=1e-9)
