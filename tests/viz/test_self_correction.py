"""The rounds of a self-correction are drawn, also those that could not be measured."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.viz import RoundErrors, plot_self_correction

ROUNDS = RoundErrors([10, 13, 16], [1e-3, 1e-5, 1e-7], [2e-3, 2e-5, 1e-7], [1e-6] * 3)


def test_one_panel_a_body(tmp_path, ink):
    one = plot_self_correction(tmp_path / "one.png", {"beam": ROUNDS})
    two = plot_self_correction(tmp_path / "two.png", {"upper": ROUNDS, "lower": ROUNDS})
    assert 0.01 < ink(one) < 0.5
    assert two.stat().st_size > one.stat().st_size


@pytest.mark.parametrize("unknown", [np.inf, None])
def test_rounds_that_were_not_measured_leave_a_gap(tmp_path, ink, unknown):
    gap = RoundErrors([10, 13], [unknown, unknown], [2e-3, 2e-5], [1e-6, 1e-6])
    assert ink(plot_self_correction(tmp_path / "gap.png", {"beam": gap})) > 0.01


def test_refuses_nothing_and_rounds_without_all_their_numbers(tmp_path):
    with pytest.raises(ModelError, match="give the rounds of at least one body"):
        plot_self_correction(tmp_path / "none.png", {})
    for sizes in ([], [10, 13]):
        with pytest.raises(ModelError, match="give one number of each kind per round"):
            RoundErrors(sizes, [1e-3] * min(len(sizes), 1), [2e-3] * len(sizes), [1e-6] * len(sizes))
