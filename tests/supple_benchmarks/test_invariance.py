"""The quick form of the invariance benchmark: its keys, and what it must show."""

from __future__ import annotations

import json

import numpy as np
import pytest

from supple_benchmarks.invariance.perform import perform


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("invariance")
    perform(True, folder / "report.json", folder)
    assert (folder / "bending_error.png").is_file()
    return json.loads((folder / "report.json").read_text())


pytestmark = [pytest.mark.slow, pytest.mark.soak]


def test_condensed_bodies_do_not_lock_and_the_indicator_knows_the_others(report):
    for row in report["locking"]:
        of_tensors = 0.005 if "torsion" in row["case"] else 0.002
        assert row["error"] < row["error_linear"] + of_tensors
        assert row["case"] == "torsion" or row["error_linear"] < 2e-4
        if row["indicator"] > 0.02:
            assert 1 / 1.5 < row["indicator"] / row["error_before"] < 1.5


def test_ties_store_an_energy_of_sixth_order(report):
    energies = [row["energy"] for row in report["tie"]]
    np.testing.assert_allclose(np.log2(np.divide(energies[1:], energies[:-1])), 6.0, atol=0.1)
    assert all(row["energy"] < 0.01 * row["energy_linear"] for row in report["tie"])


def test_damping_does_not_know_the_frame(report):
    (row,) = report["damping"]
    assert row["frames_apart"] < 3e-3 < 0.1 < row["frames_apart_linear"]


def test_strips_follow_the_elastica(report):
    assert {row["element"] for row in report["curvature"]} == {"shell", "beam"}
    assert all(row["error"] < 1e-3 for row in report["curvature"])


def test_a_turned_frame_moves_the_tip_by_less_than_a_thousandth(report):
    assert len(report["turned_element"]) == 6
    assert all(row["tip_moved"] <= 1e-3 for row in report["turned_element"])


def test_strips_buckle_sideways_at_the_load_of_theory(report):
    assert all(abs(ratio - 1) < 0.02 for ratio in report["lateral_buckling"].values())


def test_a_swinging_box_follows_the_exact_beam(report):
    assert report["box_vibration"]["swing"] > 0.2
    assert report["box_vibration"]["error"] < 5e-3


def test_each_split_is_worth_more_than_a_third(report):
    errors = {row["k"]: row["error"] for row in report["split"] if row["frame"] == "nodal-fixed"}
    assert errors[2] < errors[1] / 3


def test_the_blade_rests_alike_in_both_frames(report):
    fixed, mean = (np.array(report["blade_static"][frame]) for frame in ("nodal-fixed", "mean-axis"))
    assert np.linalg.norm(mean - fixed) < 1e-3 * np.linalg.norm(fixed)
