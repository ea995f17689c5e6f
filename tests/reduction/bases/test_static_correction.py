"""Static correction: a basis that holds the static response to known loads."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame
from supple.errors import ModelError
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, Rubin, StaticCorrection, reduce


def tip_force(body):
    """A unit force across the strip at its last node."""
    load = np.zeros((len(body.nodes), body.dofs_per_node))
    load[-1, 2] = 1.0
    return load.ravel()


def static_answer(body, frame, load):
    """K x + D^T mu = F, D x = 0, dense."""
    D = frame.constraint(body)
    scale = body.stiffness.diagonal().max() / np.abs(D).max()
    matrix = np.block([[body.stiffness.toarray(), scale * D.T], [scale * D, np.zeros((6, 6))]])
    return np.linalg.solve(matrix, np.concatenate([body.expansion.T @ load, np.zeros(6)]))[: body.n]


@pytest.mark.parametrize(
    ("recipe", "frame"),
    [
        (CraigBampton(n_modes=2), NodalFixedFrame("root")),
        (Rubin(n_modes=2), NodalFixedFrame("root")),
        (Rubin(n_modes=2), MeanAxisFrame()),
    ],
    ids=["root clamped", "root clamped, free modes", "inertia relief"],
)
def test_the_reduced_body_answers_the_load_exactly(cantilever, frame, recipe):
    """V (V^T K V)^-1 V^T F is the full static deflection, with only two modes beside."""
    load = tip_force(cantilever)
    basis = StaticCorrection(recipe, load[:, None])
    reduced = reduce(cantilever, frame, basis, derivatives=NoDerivatives(), loads=NoLoads)
    gamma = np.linalg.solve(reduced.stiffness, reduced.nodal_basis.T @ load)
    exact = cantilever.expansion @ static_answer(cantilever, frame, load)
    np.testing.assert_allclose(reduced.nodal_basis @ gamma, exact, atol=1e-8 * np.abs(exact).max())


def test_without_correction_the_modes_miss_part_of_it(cantilever, root_frame):
    """So the test above can fail: two modes of a cantilever hold 99 % of a tip deflection, not all."""
    load = tip_force(cantilever)
    reduced = reduce(
        cantilever, root_frame, CraigBampton(n_modes=2), derivatives=NoDerivatives(), loads=NoLoads
    )
    gamma = np.linalg.solve(reduced.stiffness, reduced.nodal_basis.T @ load)
    exact = cantilever.expansion @ static_answer(cantilever, root_frame, load)
    assert np.abs(reduced.nodal_basis @ gamma - exact).max() > 1e-3 * np.abs(exact).max()


def test_columns_are_labelled(cantilever, root_frame):
    load = tip_force(cantilever)
    basis = StaticCorrection(CraigBampton(n_modes=1), np.column_stack([load, 2 * load])).build(
        cantilever, root_frame
    )
    assert basis.labels[-2:] == ("static response to load 1", "static response to load 2")
    assert np.isnan(basis.frequencies[-2:]).all()


def test_bad_loads(cantilever, root_frame):
    load = tip_force(cantilever)
    with pytest.raises(ModelError, match=r"loads of shape \(\d+,\); give \(\d+, k\)"):
        StaticCorrection(CraigBampton(n_modes=1), load).build(cantilever, root_frame)
    with pytest.raises(ModelError, match="a load is zero or not finite"):
        StaticCorrection(CraigBampton(n_modes=1), 0 * load[:, None]).build(cantilever, root_frame)
