"""Herting: constraint modes, inertia relief modes and free-interface modes [Herting1985]."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import Herting, NoDerivatives, NoLoads, Rubin, inertia_relief_modes, reduce
from supple.reduction.bases.interface_columns import motion_rows


def test_inertia_relief_modes_balance_rigid_accelerations(strip_body):
    B = motion_rows(strip_body.interfaces)
    relief = inertia_relief_modes(strip_body)
    np.testing.assert_allclose(B @ relief, 0.0, atol=1e-12 * np.abs(relief).max())
    residual = strip_body.stiffness @ relief - strip_body.mass @ strip_body.rigid_modes
    multipliers = np.linalg.lstsq(B.T, residual, rcond=None)[0]
    np.testing.assert_allclose(residual, B.T @ multipliers, atol=1e-8)


def test_clamped_bar_sags_under_its_inertia(bar):
    """u = (rho/E)(L x - x^2/2), at the tip rho L^2 / 2 E."""
    relief = bar.body.expansion @ inertia_relief_modes(bar.body)
    tip = np.argmax(bar.body.nodes[:, 0])
    expected = bar.mass_per_length * bar.length**2 / (2 * bar.axial_stiffness)
    np.testing.assert_allclose(relief[3 * tip, 0], expected, rtol=1e-3)


def test_body_is_that_of_rubins_basis_in_a_mean_axis_frame(solid_body, mean_axis):
    herting, rubin = (
        reduce(solid_body, mean_axis, recipe, derivatives=NoDerivatives(), loads=NoLoads)
        for recipe in (Herting(n_modes=5), Rubin(n_modes=5))
    )
    assert herting.r == rubin.r == 12 + 5
    np.testing.assert_allclose(herting.frequencies, rubin.frequencies, rtol=1e-7)


def test_statics_and_free_modes_are_exact(strip_body, mean_axis, lowest_squares):
    reduced = reduce(strip_body, mean_axis, Herting(n_modes=4), derivatives=NoDerivatives(), loads=NoLoads)
    exact = lowest_squares(strip_body, mean_axis, 4)
    np.testing.assert_allclose(reduced.frequencies[:4] ** 2, exact, rtol=1e-7)
    loads = motion_rows(strip_body.interfaces).T
    expected = strip_body.expansion @ strip_body.constrained(mean_axis.constraint(strip_body)).solve(loads)
    motion = np.vstack([interface.motion for interface in reduced.interfaces])
    answer = reduced.nodal_basis @ np.linalg.solve(reduced.stiffness, motion.T)
    np.testing.assert_allclose(answer, expected, atol=1e-6 * np.abs(expected).max())


def test_static_columns_come_first(strip_body, frame):
    basis = Herting(n_columns=14).build(strip_body, frame)
    assert basis.labels[6] == "inertia relief ux"
    assert basis.labels[11:] == ("inertia relief rz", "free-interface mode 1", "free-interface mode 2")
    assert np.isnan(basis.frequencies[:12]).all()
    assert basis.vectors.shape[1] == 14


def test_body_without_interfaces_is_refused(loose_body, mean_axis):
    with pytest.raises(ModelError, match="needs interfaces, but body 'strip' has none"):
        Herting(n_modes=1).build(loose_body, mean_axis)
    with pytest.raises(
        ModelError, match="an inertia relief mode needs interfaces, but body 'strip' has none"
    ):
        inertia_relief_modes(loose_body)


@pytest.mark.parametrize("counts", [{}, {"n_modes": 3, "n_columns": 9}])
def test_one_count_must_be_given(counts):
    with pytest.raises(ModelError, match="give either n_modes"):
        Herting(**counts)
