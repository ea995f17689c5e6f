"""Effective interface mass [KammerTriller1996]."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.reduction import (
    EffectiveInterfaceMass,
    effective_interface_masses,
    fixed_interface_component,
    fixed_interface_modes,
    interior_interface_mass,
)


@pytest.fixture(scope="module")
def every(solid_body):
    """All fixed-interface modes of the block."""
    return fixed_interface_component(solid_body, fixed_interface_modes(solid_body, solid_body.n - 12))


def test_masses_of_all_modes_make_up_the_interior_mass(solid_body, every):
    total = every.participation.T @ every.participation
    np.testing.assert_allclose(
        interior_interface_mass(solid_body, every), total, atol=1e-10 * np.abs(total).max()
    )


def test_shares_of_all_modes_sum_to_one(solid_body, every):
    shares = EffectiveInterfaceMass(54).scores(solid_body, every)
    assert (shares >= 0.0).all()
    np.testing.assert_allclose(np.sum(shares), 1.0, rtol=1e-9)
    assert np.sum(shares[:20]) < 1.0


def test_clamped_bar_has_the_effective_masses_of_the_textbook(bar):
    """Of the mass m L: axially 8/pi^2 in the first mode; in bending 0.6131, 0.1883 of a cantilever."""
    component = fixed_interface_component(bar.body, fixed_interface_modes(bar.body, 20))
    effective = component.participation**2 / (bar.mass_per_length * bar.length)
    np.testing.assert_allclose(np.max(effective[:, 0]), 8.0 / np.pi**2, rtol=2e-3)
    for direction in (1, 2):
        np.testing.assert_allclose(np.sort(effective[:, direction])[-2:], [0.1883, 0.6131], rtol=0.02)


def test_shares_do_not_depend_on_units_or_axes_of_the_interfaces(solid_body, every):
    total = interior_interface_mass(solid_body, every)
    axes = np.random.default_rng(0).standard_normal((12, 12)) * np.logspace(-3, 3, 12)
    other = replace(every, participation=every.participation @ axes)
    np.testing.assert_allclose(
        effective_interface_masses(other, axes.T @ total @ axes),
        effective_interface_masses(every, total),
        atol=1e-7,
    )
