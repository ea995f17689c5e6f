"""Rubin: attachment modes and free-interface modes [Wu2019] (33)-(38)."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.reduction import NoDerivatives, NoLoads, Rubin, reduce
from supple.reduction.bases.interface_columns import fixed_interfaces, motion_rows


def test_attachment_modes_balance_unit_interface_loads(strip_body, frame):
    """K Psi + D^T mu = B^T, D Psi = 0; in a mean-axis frame D^T mu are inertia forces: inertia relief."""
    basis = Rubin(n_modes=2).build(strip_body, frame)
    loaded = [i for i in strip_body.interfaces if i not in fixed_interfaces(strip_body, frame)]
    loads = motion_rows(loaded).T
    Psi = basis.vectors[:, : loads.shape[1]]
    D = frame.constraint(strip_body)
    residual = strip_body.stiffness @ Psi - loads
    multipliers = np.linalg.lstsq(D.T, residual, rcond=None)[0]
    np.testing.assert_allclose(residual, D.T @ multipliers, atol=1e-6)
    lengths = np.linalg.norm(D, axis=1)[:, None] * np.linalg.norm(Psi, axis=0)
    assert (np.abs(D @ Psi) <= 1e-12 * lengths).all()


def test_only_interfaces_free_in_the_frame_have_attachment_modes(strip_body, root_frame, mean_axis):
    assert Rubin(n_modes=2).build(strip_body, root_frame).vectors.shape[1] == 6 + 2
    assert Rubin(n_modes=2).build(strip_body, mean_axis).vectors.shape[1] == 12 + 2


def test_statics_under_interface_loads_are_exact_with_any_number_of_modes(strip_body, frame):
    loads = motion_rows(strip_body.interfaces).T
    exact = strip_body.constrained(frame.constraint(strip_body))
    expected = strip_body.expansion @ exact.solve(loads)
    for n_modes in (0, 3):
        reduced = reduce(
            strip_body, frame, Rubin(n_modes=n_modes), derivatives=NoDerivatives(), loads=NoLoads
        )
        motion = np.vstack([interface.motion for interface in reduced.interfaces])
        answer = reduced.nodal_basis @ np.linalg.solve(reduced.stiffness, motion.T)
        np.testing.assert_allclose(answer, expected, atol=1e-6 * np.abs(expected).max())


def test_statics_are_exact_at_an_averaging_interface_too(averaging_body, frame):
    loads = motion_rows(averaging_body.interfaces).T
    expected = averaging_body.constrained(frame.constraint(averaging_body)).solve(loads)
    reduced = reduce(averaging_body, frame, Rubin(n_modes=2), derivatives=NoDerivatives(), loads=NoLoads)
    motion = np.vstack([interface.motion for interface in reduced.interfaces])
    answer = reduced.nodal_basis @ np.linalg.solve(reduced.stiffness, motion.T)
    nodal = averaging_body.expansion @ expected
    np.testing.assert_allclose(answer, nodal, atol=1e-6 * np.abs(nodal).max())


def test_lowest_frequencies_are_exact(strip_body, frame, lowest_squares):
    reduced = reduce(strip_body, frame, Rubin(n_modes=4), derivatives=NoDerivatives(), loads=NoLoads)
    np.testing.assert_allclose(reduced.frequencies[:4] ** 2, lowest_squares(strip_body, frame, 4), rtol=1e-7)


def test_table_1_of_the_paper_in_both_frames(cantilever, root_frame, mean_axis):
    """10 linear columns: 10 modes, root clamped; 6 attachment and 4 free modes in a mean-axis frame."""
    clamped = Rubin(n_columns=10).build(cantilever, root_frame)
    free = Rubin(n_columns=10).build(cantilever, mean_axis)
    assert clamped.labels == tuple(f"free-interface mode {i + 1}" for i in range(10))
    assert free.labels[5:7] == ("attachment root rz", "free-interface mode 1")
    assert clamped.vectors.shape[1] == free.vectors.shape[1] == 10


def test_body_without_interfaces_is_refused(loose_body, mean_axis):
    with pytest.raises(ModelError, match="a Rubin basis needs interfaces, but body 'strip' has none"):
        Rubin(n_modes=1).build(loose_body, mean_axis)


@pytest.mark.parametrize("counts", [{}, {"n_modes": 3, "n_columns": 9}])
def test_one_count_must_be_given(counts):
    with pytest.raises(ModelError, match="give either n_modes"):
        Rubin(**counts)
