"""The rounds of a self-correction in numbers, and the best of them."""

from __future__ import annotations

import numpy as np

from supple.error import Round, best_round, correction_numbers


def test_rounds_are_counted_body_by_body_and_unknown_errors_are_none(clamped_blade, make):
    def each(error):
        return Round(clamped_blade, make(), error, 0.25, np.ones(1), 2.0, allowed=1.0)

    first, second = correction_numbers([each(np.inf), each(0.5)])
    assert (first["round"], second["round"]) == (0, 1)
    assert (first["estimated_error"], second["estimated_error"]) == (None, 0.5)
    assert first["body"] == "blade"
    assert first["size"] == clamped_blade.r


def test_the_best_round_is_that_of_the_worst_body():
    def numbers(*errors):
        return [
            {"body": "b", "round": number, "estimated_error": error, "allowed": 1.0, "unconfirmed": False}
            for number, error in enumerate(errors)
        ]

    assert best_round(numbers(3.0, 2.0, None)) == 1
    assert best_round(numbers(None, None)) == 1
    other = [{"body": "c", "round": 1, "estimated_error": 9.0, "allowed": 1.0, "unconfirmed": False}]
    assert best_round(numbers(3.0, 2.0) + other) == 0


def test_an_error_that_no_second_run_confirms_is_not_the_best():
    rounds = [
        {"body": "b", "round": number, "estimated_error": error, "allowed": 1.0, "unconfirmed": number == 0}
        for number, error in enumerate((0.5, 3.0))
    ]
    assert best_round(rounds) == 1
