"""Craig-Bampton: constraint modes, then vibrations with every interface clamped [Han2020] (11)-(17)."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import CraigBampton, Guyan, NoDerivatives, NoLoads, reduce
from supple.reduction.bases.interface_columns import motion_rows


def test_fixed_interface_modes_are_held_and_vibrate(strip_body, frame):
    basis = CraigBampton(n_modes=3).build(strip_body, frame)
    modes, squares = basis.vectors[:, 6:], basis.frequencies[6:] ** 2
    B = motion_rows(strip_body.interfaces)
    np.testing.assert_allclose(B @ modes, 0.0, atol=1e-10)
    residual = strip_body.stiffness @ modes - strip_body.mass @ modes * squares
    multipliers = np.linalg.lstsq(B.T, residual, rcond=None)[0]
    np.testing.assert_allclose(
        residual, B.T @ multipliers, atol=1e-7 * np.abs(strip_body.stiffness @ modes).max()
    )


def test_clamped_frequencies_are_those_of_the_beam(strip_body, root_frame):
    """omega_1 = (4.7300 / L)^2 sqrt(EI / rho A) for a beam clamped at both ends."""
    basis = CraigBampton(n_modes=1).build(strip_body, root_frame)
    exact = 4.7300407**2 * np.sqrt(1.4e4 / (1.2 * 10.0**4))
    np.testing.assert_allclose(basis.frequencies[6], exact, rtol=0.03)


def test_static_columns_come_first_and_are_guyans(strip_body, frame):
    basis = CraigBampton(n_modes=2).build(strip_body, frame)
    guyan = Guyan().build(strip_body, frame)
    np.testing.assert_array_equal(basis.vectors[:, :6], guyan.vectors)
    assert np.isnan(basis.frequencies[:6]).all()
    assert basis.labels == (*guyan.labels, "fixed-interface mode 1", "fixed-interface mode 2")


def test_frequencies_fall_to_those_of_the_full_body(strip_body, frame, lowest_squares):
    """Ritz values approach from above, monotonically, with the number of modes."""
    exact = lowest_squares(strip_body, frame, 3)
    recipes = [CraigBampton(n_modes=n_modes) for n_modes in (0, 4, 8, 16)]
    reduced = [
        reduce(strip_body, frame, recipe, derivatives=NoDerivatives(), loads=NoLoads) for recipe in recipes
    ]
    errors = np.array([body.frequencies[:3] ** 2 / exact - 1.0 for body in reduced])
    assert (errors > -1e-7).all()
    # Modes of the other symmetry change nothing but round-off.
    assert (np.diff(errors, axis=0) < 1e-9).all()
    assert errors[-1].max() < 1e-3


def test_interface_that_the_frame_holds_leaves_fixed_interface_modes_alone(cantilever, root_frame):
    """[Wu2019] Table 1: no constraint modes when the frame sits at the only interface."""
    basis = CraigBampton(n_columns=10).build(cantilever, root_frame)
    assert basis.vectors.shape[1] == 10
    assert all(label.startswith("fixed-interface mode") for label in basis.labels)
    assert len(basis.dropped) == 6


def test_n_columns_counts_the_static_ones(strip_body, frame):
    basis = CraigBampton(n_columns=10).build(strip_body, frame)
    assert basis.vectors.shape[1] == 10
    assert basis.labels[-1] == "fixed-interface mode 4"


def test_too_few_columns_for_the_interfaces_are_refused(strip_body, frame):
    with pytest.raises(ModelError, match=r"n_columns = 5 is too few: .* need 6 static columns"):
        CraigBampton(n_columns=5).build(strip_body, frame)


def test_too_many_modes_are_refused(strip_body, frame):
    with pytest.raises(ModelError, match=r"5000, but body 'strip' has \d+ modes \(\d+ freedoms, 12 of"):
        CraigBampton(n_modes=5000).build(strip_body, frame)


@pytest.mark.parametrize("counts", [{}, {"n_modes": 3, "n_columns": 9}])
def test_one_count_must_be_given(counts):
    with pytest.raises(ModelError, match="give either n_modes"):
        CraigBampton(**counts)


def test_negative_counts_are_refused():
    with pytest.raises(ModelError, match="negative number of columns"):
        CraigBampton(n_modes=-2)
