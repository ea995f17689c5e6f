"""Lifetimes by Weibull's distribution: bins, seeds, and one case that stands for all."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.fatigue import Weibull, lifetime_of_cases

WIND = Weibull(11.28, 2.0)


def test_the_distribution():
    assert WIND.below([-1.0, 0.0, 11.28, np.inf]) == pytest.approx([0, 0, 1 - np.exp(-1), 1])
    assert WIND.quantiles(WIND.below([3.0, 11.0])) == pytest.approx([3.0, 11.0])
    speeds = np.linspace(0, 80, 4001)
    mean = np.trapezoid(1 - WIND.below(speeds), speeds)
    assert mean == pytest.approx(11.28 * np.sqrt(np.pi) / 2, rel=1e-6)


def test_cases_fill_the_covered_part_of_the_lifetime():
    speeds = np.repeat([4.0, 8.0, 14.0], [2, 3, 1])  # seeds
    durations = np.array([600, 600, 100, 200, 300, 600.0])
    life = lifetime_of_cases(speeds, durations, WIND, 6e8, cut_in=3.0, cut_out=25.0)
    assert life.covered == pytest.approx(WIND.below(25.0) - WIND.below(3.0), rel=1e-12)
    assert (life.repeats * durations).sum() == pytest.approx(life.covered * 6e8, rel=1e-12)
    bins = np.diff(WIND.below([3.0, 6.0, 11.0, 25.0]))
    assert np.bincount([0, 0, 1, 1, 1, 2], life.repeats * durations) == pytest.approx(bins * 6e8, rel=1e-12)
    assert life.repeats[2:5] == pytest.approx(life.repeats[2])  # each seed counts as often, not as long


def test_the_outer_bins_reach_as_far_out_as_in():
    life = lifetime_of_cases([6.0, 10.0, 12.0], 1.0, WIND, 1.0)
    assert life.covered == pytest.approx(WIND.below(13.0) - WIND.below(4.0), rel=1e-12)


def test_a_load_that_all_cases_share_is_that_of_the_lifetime():
    life = lifetime_of_cases([6.0, 6.0, 12.0], [600.0, 300.0, 600.0], WIND, 6e8, cut_in=0.0, cut_out=200.0)
    cycles = np.array([600.0, 300.0, 600.0])  # 1 Hz
    load = life.equivalent_load(np.full((3, 2), 7.0), 10, cycles, lifetime_cycles=6e8)
    assert load == pytest.approx([7.0, 7.0], rel=1e-9)
    assert life.equivalent_load(np.zeros((3, 1)), 10, cycles, 6e8) == 0
    assert life.damage(cycles / 6e8) == pytest.approx(1.0, rel=1e-9)


def test_the_load_of_a_lifetime_by_hand():
    life = lifetime_of_cases([5.0, 9.0], 100.0, WIND, 1e6, cut_in=4.0, cut_out=11.0)
    share = np.diff(WIND.below([4.0, 7.0, 11.0])) * 1e6
    expected = ((share[0] * 2.0**3 + share[1] * 5.0**3) / 1e7) ** (1 / 3)
    assert life.equivalent_load([2.0, 5.0], 3, 100.0, 1e7) == pytest.approx(expected, rel=1e-12)


def test_what_has_no_lifetime_is_refused():
    with pytest.raises(ModelError, match="the same speed"):
        lifetime_of_cases([8.0, 8.0], 600.0, WIND, 1.0)
    with pytest.raises(ModelError, match="beyond cut_in"):
        lifetime_of_cases([8.0, 30.0], 600.0, WIND, 1.0, cut_out=25.0)
    with pytest.raises(ModelError, match="positive"):
        lifetime_of_cases([8.0, 9.0], [600.0, 0.0], WIND, 1.0)
    with pytest.raises(ModelError, match="2 cases"):
        lifetime_of_cases([8.0, 9.0], 600.0, WIND, 1.0).damage([1.0])
    with pytest.raises(ModelError, match="not finite"):
        lifetime_of_cases([8.0, 9.0], 600.0, WIND, 1.0).damage([1.0, np.nan])
    life = lifetime_of_cases([8.0, 9.0], 600.0, WIND, 1.0)
    for exponent, reference, lifetime in (
        (0, 1.0, 1e7),
        (3, 1.0, -1),
        (3, [1.0, 0.0], 1e7),
        (3, [1.0] * 3, 1e7),
    ):
        with pytest.raises(ModelError, match="positive"):
            life.equivalent_load([1.0, 2.0], exponent, reference, lifetime)
    with pytest.raises(ModelError):
        Weibull(-1.0)
