"""Craig-Bampton with residual modes [Han2020] (26)."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import CraigBampton, CraigBamptonResidual, NoDerivatives, NoLoads, reduce
from supple.reduction.bases.interface_columns import motion_rows


def test_residual_modes_are_held_and_orthogonal_to_the_vibrations(strip_body, frame):
    basis = CraigBamptonResidual(n_modes=3).build(strip_body, frame)
    residual, modes = basis.vectors[:, 6:18], basis.vectors[:, 18:]
    np.testing.assert_allclose(motion_rows(strip_body.interfaces) @ residual, 0.0, atol=1e-12)
    lengths = np.sqrt(np.sum(residual * (strip_body.mass @ residual), axis=0))
    assert (np.abs(modes.T @ (strip_body.mass @ residual)) < 1e-9 * lengths).all()


def test_columns_are_named_and_counted(strip_body, frame):
    basis = CraigBamptonResidual(n_columns=20).build(strip_body, frame)
    assert basis.labels[6] == "residual root ux"
    assert basis.labels[17:] == ("residual tip rz", "fixed-interface mode 1", "fixed-interface mode 2")
    assert np.isnan(basis.frequencies[:18]).all()
    assert len(basis.labels) == basis.vectors.shape[1] == basis.frequencies.size == 20


def test_frequencies_are_better_than_with_as_many_more_vibrations(solid_body, frame, lowest_squares):
    """18 coordinates beside the constraint modes, twelve of them residual modes or vibrations."""
    exact = lowest_squares(solid_body, frame, 4)
    errors = [
        reduce(solid_body, frame, recipe, derivatives=NoDerivatives(), loads=NoLoads).frequencies[:4] ** 2
        / exact
        - 1.0
        for recipe in (CraigBamptonResidual(n_modes=6), CraigBampton(n_modes=18))
    ]
    assert (errors[0] > -1e-9).all()
    assert errors[0].max() < 0.1 * errors[1].max()


def test_at_an_averaging_interface_too(averaging_body, frame, lowest_squares):
    exact = lowest_squares(averaging_body, frame, 4)
    reduced = reduce(
        averaging_body, frame, CraigBamptonResidual(n_modes=10), derivatives=NoDerivatives(), loads=NoLoads
    )
    errors = reduced.frequencies[:4] ** 2 / exact - 1.0
    assert (errors > -1e-9).all()
    assert errors.max() < 1e-3


def test_too_few_columns_are_refused(strip_body, frame):
    with pytest.raises(ModelError, match=r"n_columns = 10 is too few: .* need 18 static columns"):
        CraigBamptonResidual(n_columns=10).build(strip_body, frame)


def test_body_without_interfaces_is_refused(loose_body, mean_axis):
    with pytest.raises(ModelError, match="needs interfaces, but body 'strip' has none"):
        CraigBamptonResidual(n_modes=1).build(loose_body, mean_axis)


@pytest.mark.parametrize("counts", [{}, {"n_modes": 3, "n_columns": 9}])
def test_one_count_must_be_given(counts):
    with pytest.raises(ModelError, match="give either n_modes"):
        CraigBamptonResidual(**counts)
