"""What `supple run` says of its error: the table, the report, the result file; what the case can ask for."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.quantities import JointForceSensor, PositionSensor, StressSensor
from supple.storage import read_header, read_solution

QUANTITIES = """
[error]
of = [
  { kind = "deflection", at = "strip.TIP" },
  { kind = "stress", at = "strip.ROOT" },
  { kind = "joint-force", joint = "clamp" },
]
"""


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


@pytest.fixture
def case(case_folder):
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("duration = 0.4", "duration = 0.02"))
    return path


def with_errors(case, text):
    case.write_text(case.read_text().replace("[output]", f"{text}\n[output]"))


@pytest.mark.slow
def test_a_plain_run_says_what_it_looked_at_and_that_the_sum_is_at_least_that(case):
    out = case.parent / "out"
    output = call("run", case, "-o", out)
    assert "the same run with half the step" in output
    assert "not estimated" in output
    assert "at least" in output
    report = json.loads((out / "strip.json").read_text())
    stated = report["errors"]["strip"]
    assert set(stated["parts"]) == {"step", "newton", "model"}
    assert stated["total"] is None
    assert stated["at_least"] == pytest.approx(sum(part["value"] for part in stated["parts"].values()))
    assert stated["advice"] in output
    assert read_header(out / "strip.h5").complete
    assert read_solution(out / "strip.h5").bodies["strip"].error.plain() == stated


def test_without_errors_nothing_is_run_twice(case):
    out = case.parent / "out"
    output = call("run", case, "-o", out, "--no-errors")
    assert "the same run" not in output
    assert json.loads((out / "strip.json").read_text())["errors"] == {}
    assert read_solution(out / "strip.h5").bodies["strip"].error is None


def test_quantities_are_judged_besides_the_bodies(case):
    with_errors(case, QUANTITIES)
    read = read_case(case)
    deflection, stress, force = read.study.quantities
    assert isinstance(deflection, PositionSensor)
    assert isinstance(stress, StressSensor)
    assert force == JointForceSensor("force of clamp", "clamp")
    call("run", case, "-o", case.parent / "out")
    errors = json.loads((case.parent / "out" / "strip.json").read_text())["errors"]
    assert set(errors) == {"strip", "strip.TIP", "stress at strip.ROOT", "force of clamp"}
    assert all(each["at_least"] > 0 for each in errors.values())
    assert errors["stress at strip.ROOT"]["size"] > 1e5


def test_an_accuracy_may_be_that_of_a_joints_force(case):
    of = '{ kind = "joint-force", joint = "clamp" }'
    text = re.sub(
        r"reduction = .*\n",
        f'reduction = {{ basis = "craig-bampton", accuracy = {{ relative = 0.05, of = {of} }} }}\n',
        case.read_text(),
    )
    case.write_text(text)
    start = read_case(case).starts["strip"]
    assert start.target.of == JointForceSensor("force of clamp", "clamp")
    assert start.target.relative == 0.05


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('of = [{ kind = "joint-force", joint = "clasp" }]', "did you mean 'clamp'"),
        ('of = [{ kind = "deflection", at = "strap.TIP" }]', "there is no body named 'strap'"),
        ('of = [{ kind = "energy" }]', "energy"),
    ],
)
def test_mistakes_are_named(case, table, message):
    with_errors(case, f"[error]\n{table}\n")
    with pytest.raises(CaseError, match=message):
        read_case(case)
