"""`supple benchmark blade --quick`: the whole chain on a coarse blade, and the keys that scripts read."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from supple.cli.main import app

pytestmark = [pytest.mark.slow, pytest.mark.soak]

CONTRACT = {
    "mesh": {"nodes", "triangles", "mass", "frequencies_hz"},
    "full": {"frame", "linear", "iterations", "seconds", "simulated_s"},
    "roms": {
        "frame",
        "basis",
        "derivatives",
        "size",
        "omega",
        "max_rms",
        "max_rms_over_tip",
        "iterations",
        "seconds",
        "speedup_online",
        "speedup_with_offline",
    },
    "self_correcting": {"case", "frame", "round", "size", "estimated_error", "true_error", "seconds"},
    "batch": {"cases", "seconds", "cases_per_s", "device"},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blade")
    arguments = ["benchmark", "blade", "--quick", "--json", str(folder / "x.json"), "-o", str(folder)]
    result = CliRunner().invoke(app, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return folder


@pytest.fixture(scope="module")
def report(folder):
    return json.loads((folder / "x.json").read_text())


def test_keys_are_those_that_scripts_read(report):
    for key, wanted in CONTRACT.items():
        rows = report[key] if isinstance(report[key], list) else [report[key]]
        assert rows
        for row in rows:
            assert wanted <= row.keys(), key
    for frame in ("nodal-fixed", "mean-axis"):
        assert {"basis_s", "tensors_s"} <= report["offline"][frame].keys()


def test_the_coarse_blade_is_still_the_blade(report):
    """17 740 kg; 0.675, 1.463 and 2.370 Hz on the fine mesh."""
    assert report["mesh"]["mass"] == pytest.approx(17740, rel=0.02)
    assert report["mesh"]["frequencies_hz"][:3] == pytest.approx([0.675, 1.463, 2.370], rel=0.03)


def test_derivatives_beat_as_many_linear_columns(report):
    for frame in ("nodal-fixed", "mean-axis"):
        errors = {
            (rom["size"], rom["derivatives"], rom["tensors"]): rom["max_rms"]
            for rom in report["roms"]
            if rom["frame"] == frame
        }
        assert errors[25, "picked", "condensed"] < 0.5 * errors[25, "none", "plain"]


def test_self_correction_meets_its_error_and_knows_it(report):
    """A two-hundredth of the tip's amplitude in three rounds, fewer coordinates than a fixed basis."""
    for frame in ("nodal-fixed", "mean-axis"):
        rounds = [row for row in report["self_correcting"] if row["frame"] == frame]
        last = rounds[-1]
        assert last["reached"]
        assert last["round"] <= 3
        assert last["size"] < 25
        assert last["true_error"] <= last["allowed"]
        known = [row["estimate_over_truth"] for row in rounds if row["estimated_error"] is not None]
        assert last["estimate_over_truth"] in known
        assert all(0.7 < ratio < 1.4 for ratio in known)


def test_batch_equals_single_runs(report):
    assert report["batch"]["largest_difference"] < 1e-10


def test_pictures_and_motions_are_there(folder):
    names = {path.name for path in folder.iterdir()}
    assert {"mesh.png", "modes.png", "derivatives.png", "self_correction.png", "blade.gif"} <= names
    assert len(list((folder / "motions").glob("full_*.h5"))) == 2
