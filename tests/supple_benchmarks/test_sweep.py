"""The quick form of the benchmark of sweeps: its keys, its digits, and that nothing fails."""

from __future__ import annotations

import json

import pytest

from supple.sweeps import sweep_status
from supple_benchmarks.sweep.perform import perform


@pytest.mark.slow
def test_the_quick_form_reports_what_it_measured(tmp_path):
    perform(True, tmp_path / "sweep.json", tmp_path)
    report = json.loads((tmp_path / "sweep.json").read_text())
    assert report["cases"] == 192
    assert report["equal_to_single"] < 1e-10
    assert report["seconds_to_read_a_column"] < 1.0
    assert set(report) >= {"seconds", "case_seconds_single", "per_core_efficiency", "memory_mib"}
    assert sweep_status(tmp_path / "all cores").exit_code == 0
