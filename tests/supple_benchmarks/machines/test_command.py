"""The quick forms of the machines' benchmarks, as a user types them."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from supple.cli.main import app


@pytest.mark.soak
@pytest.mark.parametrize("name", ["quadruple-pendulum", "slider-crank"])
def test_quick_form_writes_report_figures_and_animation(name, tmp_path):
    target = tmp_path / "report.json"
    arguments = ["benchmark", name, "--quick", "--json", str(target), "-o", str(tmp_path)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    numbers = json.loads(target.read_text())
    assert numbers["benchmark"] == name
    assert [row["e"] for row in numbers["tolerances"]] == [0.1, 0.01]
    assert len({row["coordinates"] for row in numbers["tolerances"]}) == 1
    quantities = {"deformation", "position", "velocity", "acceleration", "stress", "strain"}
    for row in numbers["tolerances"] + numbers["with_attachment_modes"] + numbers["whole_bases"]:
        assert set(row["errors"]) == quantities
        assert row["steps"] > 0
    assert "energy_drift" in numbers["unreduced"]
    assert set(numbers["smaller_e_smaller_error"]["share_of_outputs"]) == {
        "tolerances",
        "with_attachment_modes",
        "whole_bases",
    }
    assert len(numbers["chaos"]["separations"]) == 2
    pictures = ("machine", "acceleration", "stress_strain", "deformation", "strain_error_whole_basis_1")
    for picture in (*(f"{each}.png" for each in pictures), f"{name}.gif"):
        assert (tmp_path / picture).stat().st_size > 10_000
