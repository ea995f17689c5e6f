"""The motion of a run in columns: what follows a condensed basis among them."""

from __future__ import annotations

import numpy as np
import pytest
from error.equation.machines import MEAN, NODAL, soft_strip

from supple.body import FullBody
from supple.error.equation import run_columns
from supple.integrate import FloatingMotion
from supple.reduction import (
    CompressedDerivatives,
    Condensation,
    CondensedQuartic,
    CraigBampton,
    PlainQuartic,
    project,
    reduction_basis,
)

TIMES = np.linspace(0, 1, 80)


def motion_of(r):
    """Smooth coordinates with exact rates and accelerations."""
    frequencies = 2.0 + np.arange(r)
    phase, size = np.outer(TIMES, frequencies), 0.05 / (1 + np.arange(r))
    none = np.zeros((len(TIMES), 3))
    return FloatingMotion(
        none,
        np.tile(np.eye(3), (len(TIMES), 1, 1)),
        size * np.sin(phase),
        none,
        none,
        size * frequencies * np.cos(phase),
        none,
        none,
        -size * frequencies**2 * np.sin(phase),
    )


@pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")
@pytest.mark.parametrize("frame", [NODAL, MEAN], ids=["nodal-fixed", "mean-axis"])
def test_what_follows_the_basis_is_in_the_columns(frame):
    """V gamma + z, with z and its derivatives as the condensation has them."""
    body = soft_strip("strip", 1.0)
    basis = reduction_basis(body, frame, CraigBampton(3), derivatives=CompressedDerivatives(2))
    motion = motion_of(basis.r)
    columns = run_columns(body, project(body, basis, quartic=CondensedQuartic()), basis, motion)
    z = Condensation(body, basis).bilinear
    gamma, rate, acceleration = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    exact = {
        "coordinates": (gamma, z(gamma, gamma)),
        "rates": (rate, 2 * z(gamma, rate)),
        "accelerations": (acceleration, 2 * (z(rate, rate) + z(gamma, acceleration))),
    }
    for name, (of_basis, following) in exact.items():
        told = columns.vectors @ getattr(columns, name).T
        left = told - basis.vectors @ of_basis.T - following
        assert np.linalg.norm(left) < 0.05 * np.linalg.norm(following), name
    np.testing.assert_allclose(
        columns.vectors.T @ (body.mass @ columns.vectors), np.eye(columns.vectors.shape[1]), atol=1e-9
    )
    small = project(body, basis, quartic=CondensedQuartic())
    shown = FullBody(body, frame).expand((columns.vectors @ columns.coordinates.T).T)
    shown += columns.rigid[:, None, :3] + np.cross(columns.rigid[:, None, 3:], body.nodes)
    condensed = small.expand(gamma) - small.expand_rates(0 * gamma, gamma)
    assert np.linalg.norm(shown - small.expand(gamma)) < 0.02 * np.linalg.norm(condensed)


@pytest.mark.filterwarnings("ignore::supple.errors.LockingWarning")
def test_plain_tensors_let_nothing_follow():
    body = soft_strip("strip", 1.0)
    basis = reduction_basis(body, NODAL, CraigBampton(3), derivatives=CompressedDerivatives(2))
    motion = motion_of(basis.r)
    columns = run_columns(body, project(body, basis, quartic=PlainQuartic()), basis, motion)
    assert columns.vectors is basis.vectors
    np.testing.assert_array_equal(columns.coordinates, motion.coordinates)
    assert not columns.rigid.any()
