"""The machines of a newcomer: each example states what it expects, asserts it and draws it."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "calibrate_pendulum",
        "digital_twin",
        "docked_satellites",
        "nastran_plate",
        "reference_blade",
        "robot_arm",
        "satellite",
        "spinning_disc",
    ],
)
def test_an_example_meets_its_expectation_and_draws(name, tmp_path):
    picture = tmp_path / f"{name}.png"
    runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"](picture)
    assert picture.stat().st_size > 10_000


@pytest.mark.slow
def test_the_slider_crank_meets_its_expectation_and_draws(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / "slider_crank.py"), run_name="__main__")
    assert (tmp_path / "slider_crank.png").stat().st_size > 10_000
