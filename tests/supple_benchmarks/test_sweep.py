"""The quick form of the benchmark of sweeps: its keys, its digits, and that nothing fails."""

from __future__ import annotations

import json

import pytest

from supple.sweeps import sweep_status
from supple_benchmarks.sweep.perform import perform
from supple_benchmarks.sweep.run import KILLED_CASES


@pytest.mark.slow
def test_the_quick_form_reports_what_it_measured(tmp_path):
    perform(True, tmp_path / "sweep.json", tmp_path)
    report = json.loads((tmp_path / "sweep.json").read_text())
    assert report["cases"] == 128
    assert report["equal_to_single"] < 10 * report["round_off"] < 1e-9
    assert report["seconds_to_read_a_column"] < 1.0
    assert set(report) >= {"seconds", "case_seconds_single", "per_core_efficiency", "memory_mib"}
    assert report["del_error"] < 1e-12
    assert report["gradient_error"] < 1e-6
    assert {key: report["kills"][key] for key in ("cases", "lost", "twice")} == {
        "cases": KILLED_CASES,
        "lost": 0,
        "twice": 0,
    }
    assert sweep_status(tmp_path / "all cores").exit_code == 0
