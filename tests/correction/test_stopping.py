"""What differences of rounds say of an error, and which rounds were useless."""

from __future__ import annotations

import numpy as np
import pytest

from supple.correction.stopping import error_of_differences, is_useless


def test_rounds_that_shrink_by_one_rate_add_up():
    """Runs with errors e_k = 4^-k at right angles: d_k^2 = e_k^2 - e_(k+1)^2; the sum returns e_k."""
    errors = 4.0 ** -np.arange(4)
    differences = list(np.sqrt(-np.diff(errors**2)))
    for k in (1, 2):
        assert error_of_differences(differences[: k + 1]) == pytest.approx(errors[k])
    assert error_of_differences(differences[:1]) == differences[0]


@pytest.mark.parametrize("difference", [np.inf, 2.0, 1.0])
def test_rounds_that_do_not_shrink_say_nothing(difference):
    assert error_of_differences([1.0, difference]) == np.inf


def test_one_that_did_not_shrink_is_remembered_by_the_next():
    """The rate is the worse of the last two."""
    assert error_of_differences([1.0, 1.1, 0.01]) == np.inf
    told = error_of_differences([1.0, 0.9, 0.01])
    assert told == pytest.approx(0.9 * 0.1 / np.sqrt(1 - 0.9**2))


def test_a_sudden_fall_is_taken_for_chance():
    """After 1, 1/4, 1/16 a difference of 1e-9 is no error of 1e-9: the mean rate says 1e-3 of the last."""
    told = error_of_differences([1.0, 0.25, 0.0625, 1e-9])
    assert told == pytest.approx(0.0625 * 1e-3 / np.sqrt(1 - 0.25**2), rel=1e-6)


def test_a_run_that_broke_off_says_nothing_of_the_rate():
    assert error_of_differences([np.inf, 0.5]) == 0.5


def test_a_round_no_better_than_the_one_before_is_useless():
    assert is_useless([1.0, 0.5, 0.5])
    assert is_useless([1.0, np.inf])
    assert not is_useless([1.0])
    assert not is_useless([np.inf, 1.0])
    assert not is_useless([1.0, 0.5])
