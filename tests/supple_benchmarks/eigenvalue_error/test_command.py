from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from supple.cli.main import app
from supple.mesh import CellType
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors


@pytest.mark.slow
def test_the_command_prints_tables_and_writes_report_and_figures(tmp_path, monkeypatch):
    small = EigenvalueErrors(
        tolerances=(0.1,),
        cylinders=((CellType.TETRA4, 8),),
        rods=(),
        beams=((CellType.TETRA4, (2, 1, 8)),),
        candidates=40,
    )
    monkeypatch.setattr(EigenvalueErrors, "quick", lambda: small)
    target = tmp_path / "report.json"
    command = ["benchmark", "eigenvalue-error", "--quick"]
    result = CliRunner().invoke(app, [*command, "--json", str(target), "-o", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    for part in ("Fixed-interface modes kept", "Modes that each basis needs", "beam theory", "report.json"):
        assert part in result.output
    written = json.loads(target.read_text())
    assert written["bodies"][0]["tolerances"][0]["max_exact"] <= 0.1
    assert (tmp_path / "out" / "figure_4_cylinder_tet4.png").exists()
