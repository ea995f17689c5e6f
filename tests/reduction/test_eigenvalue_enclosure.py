from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, RigidInterface, flexible_body
from supple.errors import AccuracyError
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, cylinder
from supple.reduction import CraigBamptonFamily, enclose_eigenvalues

N = 10


@pytest.fixture(scope="module")
def body():
    """A square-symmetric cylinder: its bending eigenvalues come in pairs."""
    model = solid_model(cylinder(0.1, 1.0, 2, 1, 8, CellType.HEXA8), Isotropic(1e9, 0.3, 1000.0))
    return flexible_body("cylinder", model, [RigidInterface("root", "root")])


@pytest.fixture(scope="module")
def exact(body, lowest_squares):
    return lowest_squares(body, MeanAxisFrame(), 20)


@pytest.fixture(scope="module")
def trial(body):
    family = CraigBamptonFamily(body)
    return family.vectors(family.vibrations(30, 20))


def test_every_eigenvalue_is_enclosed_pairs_too(body, exact, trial):
    assert exact[1] / exact[0] - 1 < 1e-6
    enclosure = enclose_eigenvalues(body, trial, N, 1e-4)
    assert np.all(enclosure.lower <= exact[:N] * (1 + 1e-9))
    assert np.all(enclosure.upper >= exact[:N] * (1 - 1e-9))
    assert np.max(enclosure.upper / enclosure.lower - 1) < 1e-4
    assert enclosure.n_below == 6 + np.sum(exact < enclosure.shift)


@pytest.mark.parametrize("width", [1e-2, 1e-5, 1e-8])
def test_the_bounds_are_as_close_as_one_asks(body, exact, trial, width):
    enclosure = enclose_eigenvalues(body, trial, N, width)
    assert np.max(enclosure.upper / enclosure.lower - 1) <= width
    np.testing.assert_allclose(enclosure.lower, exact[:N], rtol=width + 1e-9)


def test_a_mode_that_the_trial_motions_lack_is_found(body, exact):
    """The count objects to the bounds until round-off has grown into the mode that was taken away."""
    family = CraigBamptonFamily(body)
    everything = family.vectors(family.vibrations(family.n_available, 22))
    enclosure = enclose_eigenvalues(body, np.delete(everything, 2, axis=1), N, 1e-6)
    np.testing.assert_allclose(enclosure.lower, exact[:N], rtol=1e-6)


def test_bounds_closer_than_round_off_are_refused(body, trial):
    with pytest.raises(AccuracyError, match=r"not be enclosed to 1e-20 \(bounds .* apart\); give more trial"):
        enclose_eigenvalues(body, trial, N, 1e-20)
