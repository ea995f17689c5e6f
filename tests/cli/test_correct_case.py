"""Cases whose reductions correct themselves: what is printed, written and drawn; how they go on."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cli.main import app
from supple.error import CorrectionFolder
from supple.storage import read_header, read_reduced_body, read_solution


def call(*arguments, code=0):
    """Output of a command (errors included), its lines joined so that wrapping does not matter."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


# Pushed slowly, so that what the basis misses is static.
PUSHED = """
[[load]]
kind = "force"
at = "strip.TIP"
vector = [0.0, 0.0, 900.0]
law = { kind = "ramp", value = 1.0, duration = 0.4 }
"""


@pytest.fixture
def case(case_folder):
    """The strip with a reduction that corrects itself, pushed at its tip."""
    path = case_folder / "strip.toml"
    text = re.sub(r"reduction = .*\n", "", path.read_text())
    text = text.replace("_step = 0.002", "_step = 0.02").replace("step = 0.002", "step = 0.01")
    path.write_text(text.replace("[simulation]", PUSHED + "\n[simulation]"))
    return path


def accuracy(case, text):
    case.write_text(case.read_text().replace("damping =", f"reduction = {text}\ndamping =", 1))


@pytest.mark.slow
def test_a_case_without_sizes_corrects_itself(case):
    """Rounds in the output, the report, the result file and on disk; the accepted run is one of them."""
    case.write_text(case.read_text().replace("pictures = false", "pictures = true"))
    out = case.parent / "out"
    assert "shell, corrects itself; interfaces: root" in call("info", case)
    output = call("run", case, "-o", out)
    assert "Self-correction" in output
    assert "round 1, 14 coordinates: simulating" in output
    assert (out / "self_correction.png").stat().st_size > 0
    report = json.loads((out / "strip.json").read_text())
    rounds = report["self_correction"]
    assert [each["round"] for each in rounds] == list(range(len(rounds)))
    assert [each["size"] for each in rounds] == [10 + 4 * number for number in range(len(rounds))]
    keys = {"body", "round", "size", "estimated_error", "allowed", "indicator", "seconds", "useless"}
    keys |= {"unconfirmed"}
    assert set(rounds[0]) == keys
    assert rounds[-1]["estimated_error"] <= rounds[-1]["allowed"]
    deflection = np.linalg.norm(report["tracked"]["strip.TIP"]["largest deflection"])
    assert rounds[-1]["allowed"] == pytest.approx(1e-3 * deflection, rel=1e-2)
    stated = report["errors"]["strip"]
    assert set(stated["parts"]) == {"basis", "step", "newton", "model"}
    assert stated["total"] == pytest.approx(sum(part["value"] for part in stated["parts"].values()))
    assert stated["total"] <= stated["allowed"] == rounds[-1]["allowed"]
    assert stated["parts"]["basis"]["value"] == rounds[-1]["estimated_error"]
    assert read_solution(out / "strip.h5").bodies["strip"].error.plain() == stated
    assert "the same run with half the step" in output
    assert report["bodies"]["strip"]["coordinates"] == rounds[-1]["size"]
    header = read_header(out / "strip.h5")
    assert header.complete
    assert json.loads(str(header.metadata["self_correction"])) == rounds
    archive = CorrectionFolder(out / "self_correction", case=case.read_text())
    accepted = read_solution(archive.motion(rounds[-1]["round"]))
    np.testing.assert_array_equal(
        accepted.bodies["strip"].coordinates, read_solution(out / "strip.h5").bodies["strip"].coordinates
    )
    assert read_reduced_body(out / "strip-reduced.h5").r == rounds[-1]["size"]


@pytest.mark.slow
def test_an_error_that_is_not_met_keeps_the_rounds_and_names_the_best(case):
    accuracy(
        case, '{ basis = "craig-bampton", accuracy = { absolute = 2.5e-7, max_rounds = 1, instants = 5 } }'
    )
    out = case.parent / "out"
    output = call("run", case, "-o", out, code=2)
    assert (
        "did not reach the error 2.5e-07: all rounds are used up (max_rounds = 1). Estimated errors:"
        in output
    )
    archive = CorrectionFolder(out / "self_correction", case=case.read_text())
    assert f"the best round is in {archive.motion(1)}" in output
    assert read_header(archive.motion(1)).complete
    assert len(json.loads((out / "strip.json").read_text())["self_correction"]) == 2
    assert not (out / "strip.h5").exists()


@pytest.mark.slow
def test_a_correction_that_was_cut_off_goes_on_with_its_rounds(case):
    """What a run left behind that was killed after its second round began; then nothing is left to do."""
    accuracy(case, '{ basis = "craig-bampton", accuracy = { relative = 1e-2, instants = 5 } }')
    out = case.parent / "out"
    call("run", case, "-o", out)
    whole = json.loads((out / "strip.json").read_text())["self_correction"]
    assert "its run is complete" in call("run", case, "-o", out, "--resume", code=2)
    (out / "strip.h5").unlink()
    last = whole[-1]
    (out / "self_correction" / f"round-{last['round']}.h5").unlink()
    (out / "self_correction" / f"round-{len(whole)}.npz").unlink()
    output = call("run", case, "-o", out, "--resume")
    assert f"round {last['round']}, {last['size']} coordinates: simulating" in output
    assert "round 0, 10 coordinates: motion outside" not in output
    again = json.loads((out / "strip.json").read_text())["self_correction"]
    assert [each["size"] for each in again] == [each["size"] for each in whole]
    assert again[-1]["estimated_error"] == pytest.approx(whole[-1]["estimated_error"], rel=1e-6)


@pytest.mark.slow
def test_strict_judges_the_run_that_is_accepted(case):
    accuracy(case, '{ basis = "craig-bampton", accuracy = { relative = 0.1, instants = 5 } }')
    text = (
        case.read_text()
        .replace("900.0", "3000.0")
        .replace("alpha = 0.0, beta = 0.02", "alpha = 20.0, beta = 0.0")
    )
    case.write_text(text.replace('kind = "mean-axis"', 'kind = "nodal-fixed", interface = "root"'))
    assert "error: body 'strip' rotates by" in call(
        "run", case, "-o", case.parent / "out", "--strict", code=2
    )


@pytest.mark.slow
def test_loads_beyond_the_modes_of_a_fixed_size_are_named(case):
    """At 100 Hz the strip, held at its root, has three modes; clamped modes lie at 8, 53, 83 and 156 Hz."""
    accuracy(case, '{ basis = "normal-modes", modes = 1, steady = false }')
    text = case.read_text().replace('kind = "mean-axis"', 'kind = "nodal-fixed", interface = "root"')
    text = text.replace(
        'kind = "ramp", value = 1.0, duration = 0.4', 'kind = "sine", amplitude = 1e-3, frequency_hz = 100'
    )
    text = 'units = { time = "s" }\n' + text
    case.write_text(text.replace("output_step = 0.02", "output_step = 0.001"))
    output = call("run", case, "-o", case.parent / "out")
    assert "reach 100 Hz: of the 3 modes of body 'strip' up to there, 2 are missing" in output
    assert "Take at least 3 modes" in output
