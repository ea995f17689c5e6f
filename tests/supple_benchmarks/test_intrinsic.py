"""The quick form of the intrinsic benchmark: its keys, and what it must show."""

import json

import numpy as np
import pytest

from supple_benchmarks.intrinsic.perform import perform
from supple_benchmarks.intrinsic.slender_box import LENGTH, slender_mode


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("intrinsic")
    perform(True, folder / "report.json", folder)
    return json.loads((folder / "report.json").read_text())


# The strip takes 4, 8 and 16 modes, the first too few on purpose.
pytestmark = [
    pytest.mark.slow,
    pytest.mark.soak,
    pytest.mark.filterwarnings("ignore::supple.errors.BasisWarning"),
]


def test_modes_are_orthonormal_and_energy_is_kept(report):
    assert max(report["orthonormality"].values()) <= 1e-11
    assert report["energy_drift"] < 1e-5


def test_beams_at_rest_are_those_of_theory_and_literature(report):
    assert report["elastica_order"] >= 1.9
    assert report["elastica"][-1]["nodes"] == 40
    assert report["elastica"][-1]["error"] <= 2e-5
    assert report["simo45"]["load"] == 600
    assert report["simo45"]["tip"] == pytest.approx([15.79, 47.23, 53.37], rel=0.01)


def test_the_box_has_the_low_frequencies_of_its_shells(report):
    low = {row["kind"]: abs(row["error"]) for row in reversed(report["box_beam"]["frequencies"])}
    assert low["flapwise"] < 5e-3
    assert low["chordwise"] < 5e-3
    assert low["torsion"] < 0.01
    assert low["axial"] < 5e-3
    rows = {row["kind"]: row for row in reversed(report["box_beam"]["frequencies"])}
    for row in rows.values():  # walls restrain warping, and beams do not
        assert row["shells"] == pytest.approx(row["beam"], rel=0.04 if row["kind"] == "torsion" else 5e-3)
    assert report["box_beam"]["small_from_linear"] < 1e-3
    assert report["box_beam"]["against_shells"][0]["error"] < 1e-3
    assert len(report["box_beam"]["tip"]["t"]) == len(report["box_beam"]["tip"]["u"])


def test_the_box_moves_in_the_modes_of_a_slender_beam_but_for_its_walls(report):
    study = report["box_beam"]["modes"]
    first = study["modes"][0]
    s = LENGTH * np.array(study["s"])
    velocity, _, _ = slender_mode(first["kind"], first["rank"], s)
    moment = slender_mode(first["kind"], first["rank"], 0.5 * (s[1:] + s[:-1]))[1]
    sign = np.sign(velocity[-1])
    assert first["velocity"] == pytest.approx(sign * velocity, abs=0.01 * np.abs(velocity).max())
    assert first["moment"] == pytest.approx(sign * moment, abs=0.01 * np.abs(moment).max())


def test_a_body_that_flies_moves_its_centre_as_newton_says_and_residual_modes_help(report):
    flying = report["u_beam"]
    assert flying["order"] == pytest.approx(2, abs=0.3)
    for row in flying["residualised"]:
        assert row["residualised_error"] < row["truncated_error"] / 3
    steps = {row["kept"]: row["dt_max"] for row in flying["stable_steps"]}
    assert list(steps.values()) == sorted(steps.values(), reverse=True)
    assert flying["residualised"][0]["dt_max"] == pytest.approx(steps[24])
    places = {key: np.array(flight["tip"]) for key, flight in flying["flight"].items()}
    apart = np.linalg.norm(places["stations"] - places["beam_elements"], axis=1)
    assert apart[:10].max() < 0.05 * np.linalg.norm(np.ptp(places["stations"], axis=0))


def test_intrinsic_modes_agree_with_the_elastica_where_one_frame_does_not(report):
    errors = {(row["method"], row["tip_rotation"]): row["error"] for row in report["agreement"]}
    assert max(errors["intrinsic", 0.29], errors["intrinsic", 0.87]) < 1e-3
    beyond = errors["floating", 0.87]  # None: no equilibrium at all
    assert beyond is None or beyond > 10 * errors["intrinsic", 0.87]


def test_the_cost_of_a_step_is_reported(report):
    assert {"modes", "nodes", "us_per_rk4_step", "tensor_us_per_rk4_step"} == set(report["speed"][0])
