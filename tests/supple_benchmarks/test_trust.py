"""The quick form of the trust benchmark: its keys, and that what is stated is the truth."""

from __future__ import annotations

import json

import pytest

from supple_benchmarks.trust.cases import CASES
from supple_benchmarks.trust.perform import coverage, perform
from supple_benchmarks.trust.trust_case import file_name

KEYS = {"name", "freedoms", "rounds", "accepted", "allowed", "parts", "true_total", "seconds", "full_seconds"}


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("trust")
    perform(True, folder / "report.json", folder)
    return json.loads((folder / "report.json").read_text())


def test_there_are_at_least_thirty_cases_of_different_names():
    assert len({file_name(case.name) for case in CASES}) == len(CASES) >= 30


def test_coverage_counts_from_the_second_round_of_each_body():
    def each(body, estimated, true):
        return {"body": body, "size": 5, "estimated": estimated, "true": true}

    case = {
        "rounds": [each("a", 9.0, 1.0), each("b", 9.0, 1.0), each("a", 1.2, 1.0), each("b", 0.4, 1.0)],
        "accepted": True,
        "stated_total": 1.0,
        "true_total": 2.5,
        "allowed": 2.0,
    }
    refused = {"rounds": [each("a", None, 1.0)], "accepted": False}
    told = coverage([case, refused])
    assert told["rounds"] == 2
    assert told["within_0.7_1.4"] == told["below_0.5"] == 0.5
    assert told["accepted"] == told["accepted_over_limit"] == 1
    assert told["sums_within_0.5_2"] == 0.0


@pytest.mark.slow
def test_what_is_stated_is_the_truth(report):
    assert KEYS <= set(report["cases"][0])
    assert all(case["accepted"] for case in report["cases"])
    told = report["coverage"]
    assert told["below_0.5"] == 0
    assert told["accepted_over_limit"] == 0
    assert told["sums_within_0.5_2"] == 1.0


@pytest.mark.slow
def test_what_is_stated_is_near_the_truth(report):
    assert report["coverage"]["within_0.7_1.4"] >= 0.95
