"""The sum of the parts, the largest of them with its remedy, and the way through JSON."""

from __future__ import annotations

import json

import numpy as np
import pytest

from supple.integrate import ErrorPart, ErrorStatement, FloatingMotion


def stated(**parts):
    return ErrorStatement("positions of body 'arm'", 0.5, **parts)


def part(value, remedy="mend it"):
    return ErrorPart(value, "a run", remedy)


def test_where_a_part_is_missing_the_error_is_at_least_the_sum_of_the_others():
    half = stated(step=part(3e-4), newton=part(1e-4))
    assert half.at_least == pytest.approx(4e-4)
    assert half.total is None
    assert half.plain()["total"] is None
    assert half.plain()["at_least"] == half.at_least
    assert half.missing == ("basis", "model")
    assert list(half.parts) == ["step", "newton"]


def test_the_largest_part_is_named_with_its_remedy():
    whole = stated(basis=part(1e-5), step=part(4e-4, "halve the step"), newton=part(1e-6), model=part(2e-6))
    assert whole.total == whole.at_least == pytest.approx(4.13e-4)
    assert whole.largest == "step"
    assert whole.advice == "the error of the step is 40 times that of the basis: halve the step"


def test_an_error_far_below_the_allowed_one_needs_no_remedy():
    small = stated(basis=part(1e-9), step=part(1e-9), newton=part(4e-7), model=part(0.0), allowed=1e-4)
    assert small.advice == "the sum is 0.004 of the allowed error"
    assert (
        "mend it"
        in stated(basis=part(0.0), step=part(0.0), newton=part(4e-5), model=part(0.0), allowed=1e-4).advice
    )


def test_a_part_without_a_number_leads_and_keeps_the_sum_from_any_limit():
    unknown = ErrorStatement("positions", 0.5, basis=part(np.inf), step=part(1e-3), allowed=1.0)
    assert unknown.largest == "basis"
    assert unknown.advice == "the error of the basis is unknown: mend it"
    assert not unknown.is_met


def test_an_exact_run_needs_no_advice():
    exact = stated(basis=part(0.0), step=part(0.0), newton=part(0.0), model=part(0.0))
    assert exact.largest is None
    assert exact.advice == ""
    assert exact.is_met


@pytest.mark.parametrize("value", [1.25e-5, np.inf])
def test_json_brings_it_back(value):
    one = ErrorStatement(
        "positions", 0.5, basis=part(value), newton=part(1e-6), allowed=1e-3, quantity="length"
    )
    assert ErrorStatement.from_plain(json.loads(json.dumps(one.plain()))) == one


def test_a_motion_knows_its_error_but_not_as_an_array():
    zeros = [np.zeros((2, 3)), np.zeros((2, 3, 3)), *(np.zeros((2, n)) for n in (1, 3, 3, 1, 3, 3, 1))]
    motion = FloatingMotion(*zeros)
    assert motion.error is None
    told = motion.with_error(stated(step=part(1.0)))
    assert told.error.at_least == 1.0
    assert told.at(slice(0, 1)).error is told.error
    assert told.arrays().keys() == motion.arrays().keys()
    assert motion.error is None
