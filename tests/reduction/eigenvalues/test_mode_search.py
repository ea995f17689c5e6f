from __future__ import annotations

import numpy as np
import pytest

from supple.reduction import Bisection, OneByOne, SearchStep

E = 1e-3


class Errors:
    """A trial whose errors are a function of the number of modes; it remembers what it was asked."""

    def __init__(self, error):
        self.error, self.asked = error, []

    def __call__(self, n_modes):
        self.asked.append(n_modes)
        return SearchStep(n_modes, np.array([0.1 * E, self.error(n_modes)]), E, "test", 0.0)


def power(rate, scale=1.0):
    return lambda n: scale * float(max(n, 1)) ** -rate


CURVES = {
    "steep": power(3.0),
    "usual": power(1.3),
    "slow": power(1.0),
    "staircase": lambda n: power(1.3)(n - n % 12),
    "nothing at first": lambda n: np.inf if n < 30 else power(1.3)(n),
    "a dip below": lambda n: 0.97 * E if n in (194, 195) else power(1.3)(n),
    "at once": lambda n: 0.5 * E,
}


@pytest.mark.parametrize("first", [0, 5])
@pytest.mark.parametrize("curve", CURVES)
def test_both_searches_give_the_same_answer(curve, first):
    one_by_one, bisection = Errors(CURVES[curve]), Errors(CURVES[curve])
    published = OneByOne().run(one_by_one, first, 2000)
    found = Bisection().run(bisection, first, 2000)
    assert found[-1].n_modes == published[-1].n_modes
    assert found[-1].first_failing is None
    assert sorted(step.n_modes for step in found) == sorted(set(bisection.asked)) == sorted(bisection.asked)
    assert [step.n_modes for step in published] == list(range(first, published[-1].n_modes + 1))
    assert all(step.first_failing for step in published[:-1])


def test_bisection_asks_for_little_and_never_for_many_modes():
    trial = Errors(power(1.3))
    steps = Bisection().run(trial, 5, 2000)
    assert len(trial.asked) < 0.2 * steps[-1].n_modes
    assert max(trial.asked) < 1.15 * steps[-1].n_modes


@pytest.mark.parametrize("search", [OneByOne(), Bisection()])
def test_where_nothing_passes_the_last_step_is_the_largest(search):
    steps = search.run(Errors(power(1.0)), 5, 40)
    assert steps[-1].n_modes == 40
    assert steps[-1].first_failing == 2


def test_a_step_names_the_first_failing_vibration():
    step = SearchStep(7, np.array([0.5, 1.0, 2.0, np.nan]), 1.0, "test", 0.0)
    assert step.first_failing == 3
    assert SearchStep(7, np.array([0.5, 1.0]), 1.0, "test", 0.0).first_failing is None
    assert step.errors.flags.writeable is False
    assert SearchStep(7, np.array([0.5, 0.75]), 1.0, "test", 0.0).largest == 0.75
