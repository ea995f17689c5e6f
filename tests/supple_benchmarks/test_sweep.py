"""The quick form of the benchmark of sweeps: its keys, its digits, and that nothing fails."""

from __future__ import annotations

import json

import pytest

from supple.sweeps import sweep_status
from supple_benchmarks.sweep.perform import perform
from supple_benchmarks.sweep.run import CONTRACT, QUICK_CASES


@pytest.mark.slow
def test_the_quick_form_reports_what_it_measured(tmp_path):
    perform(True, tmp_path / "sweep.json", tmp_path)
    report = json.loads((tmp_path / "sweep.json").read_text())
    details = json.loads((tmp_path / "details.json").read_text())
    assert tuple(report) == CONTRACT
    assert report["cases"] == QUICK_CASES
    assert report["equal_to_single"] < 10 * details["round_off"] < 1e-9
    assert details["seconds_to_read_a_column"] < 1.0
    assert 0 < report["largest_estimate"] <= report["allowed"]
    assert report["run_again"] == 0
    assert report["del_error"] < 1e-12
    assert report["gradient_error"] < 1e-6
    assert {key: report["kills"][key] for key in ("cases", "lost", "twice")} == {
        "cases": QUICK_CASES,
        "lost": 0,
        "twice": 0,
    }
    assert sweep_status(tmp_path / "all cores").exit_code == 0
