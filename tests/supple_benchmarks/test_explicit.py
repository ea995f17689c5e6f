"""The quick form of the explicit benchmark: its keys, and what it must show."""

from __future__ import annotations

import json

import numpy as np
import pytest

from supple_benchmarks.explicit.perform import perform

pytestmark = [pytest.mark.slow, pytest.mark.soak]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("explicit")
    perform(True, folder / "report.json", folder)
    return json.loads((folder / "report.json").read_text())


def test_free_flight_keeps_what_it_must(report):
    own = report["free_flight"]
    assert own["links"] <= 1e-14
    assert own["angular_momentum"] <= 1e-10
    assert own["energy"] <= 2e-8
    assert own["attitude_order"] == pytest.approx(2.0, abs=0.15)
    assert own["published_scheme_brake"] == pytest.approx(1.0, abs=0.1)


def test_step_limits_are_sharp(report):
    own = report["step_limit"]
    assert (own["stable_at"], own["unstable_at"]) == (0.98, 1.02)
    assert own["ratio_to_27_clamped"] < 0.6


def test_multipliers_are_elimination(report):
    assert report["dual_against_primal"] <= 1e-11
    assert len(report["multi_time_step"]) == 8
    assert max(row["gap"] for row in report["multi_time_step"]) <= 1e-13


def test_the_taylor_bar_is_near_the_published_ones(report):
    assert report["taylor_bar"]["length"] == pytest.approx(21.5e-3, rel=0.03)
    assert report["taylor_bar"]["radius"] == pytest.approx(7.0e-3, rel=0.12)


def test_a_modal_rest_makes_the_crash_faster_and_changes_it_little(report):
    own = report["crash"]
    assert own["error"] <= 0.03
    assert own["speedup"] > 1
    assert np.isfinite(own["memory_ratio"])


def test_throughput_of_both_elements_is_told(report):
    assert {row["element"].split()[0] for row in report["throughput"]} == {"hexa8", "tetra4"}
