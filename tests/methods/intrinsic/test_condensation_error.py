"""A tolerance in, a body with its error out."""

import numpy as np
import pytest

from supple.body import AveragingInterface, RigidInterface, flexible_body
from supple.errors import AccuracyError, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.methods.intrinsic import (
    CLAMPED,
    FREE,
    LoadPath,
    NodeSetPath,
    accurate_condensation,
    condensation_error,
    condense,
)


@pytest.fixture(scope="module")
def shells():
    model = shell_model(strip(1.0, 0.05, 48, 2), HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 0.004))
    return flexible_body("strip", model, [RigidInterface("root", "root"), AveragingInterface("tip", "tip")])


def test_as_many_stations_are_taken_as_the_tolerance_asks_for(shells):
    loose = accurate_condensation(shells, "root", "tip", tolerance=0.05, n_frequencies=3)
    tight = accurate_condensation(shells, "root", "tip", tolerance=2e-3, n_frequencies=3)
    assert loose.body.line.n < tight.body.line.n
    for found, tolerance in ((loose, 0.05), (tight, 2e-3)):
        assert 0 < found.error.largest <= tolerance
        assert np.abs(found.error.relative).max() == found.error.largest


def test_the_error_is_that_of_the_body_on_its_support(shells):
    for support in (CLAMPED, FREE):
        body = condense(shells, LoadPath("root", "tip", 25), support=support, n_modes=8)
        assert condensation_error(shells, body, 3).largest < 0.01


def test_what_no_mesh_carries_is_an_error_with_what_was_reached(shells):
    with pytest.raises(
        AccuracyError, match=r"with 49 stations its lowest 2 frequencies have an error of .*1e-09"
    ):
        accurate_condensation(shells, "root", "tip", tolerance=1e-9, n_frequencies=2)
    with pytest.raises(ModelError, match="between 0 and 1"):
        accurate_condensation(shells, "root", "tip", tolerance=2.0)
    body = condense(shells, LoadPath("root", "tip", 7), n_modes=4)
    with pytest.raises(ModelError, match="has 4 elastic modes"):
        condensation_error(shells, body, 5)


def test_stations_enough_for_many_frequencies_are_taken(shells):
    """7 stations have 36 modes only."""
    found = accurate_condensation(shells, "root", "tip", tolerance=0.9, n_frequencies=40)
    assert found.body.line.n == 13
    assert len(found.error.exact) == 40


def test_the_root_must_be_an_interface(shells):
    along = shells.nodes[:, 0]
    sets = [np.flatnonzero(np.abs(along - x) < 0.06) for x in (0.0, 0.5)]
    body = condense(shells, NodeSetPath([*sets, "tip"]))
    with pytest.raises(ModelError, match="first station is not an interface of the body"):
        condensation_error(shells, body, 3)
