"""A tolerance in a case file, a proof in what the commands print, write and simulate."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.algebra import lowest_modes
from supple.body import MeanAxisFrame
from supple.cases import read_case
from supple.cli.main import app
from supple.storage import read_reduced_body

N = 6
TOLERANCE = 1e-3
CONTROLLED = f'{{ basis = "error-controlled", tolerance = {TOLERANCE}, modes = {N} }}'
PROOF = (
    rf"{N} eigenvalues, each within 0\.1 %, none missed \(largest error 0\.0\d+ %, \d+ fixed-interface modes"
)


def call(*arguments, code=0):
    """Output of a command (errors included), its lines joined so that wrapping does not matter."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", re.sub("[│┃]", " ", result.output))


@pytest.fixture
def case(case_folder):
    """The clamped strip under its weight, reduced to a tolerance."""
    path = case_folder / "strip.toml"
    path.write_text(re.sub(r"reduction = .*", f"reduction = {CONTROLLED}", path.read_text()))
    return path


def with_keys(case, keys):
    case.write_text(case.read_text().replace(f"modes = {N} }}", f"modes = {N}, {keys} }}"))


def test_what_is_kept_has_the_eigenvalues_of_the_whole_body(case):
    output = call("reduce", case, "-o", case.parent)
    assert re.search(f"eigenvalues {PROOF}", output)
    reduced = read_reduced_body(case.parent / "strip-reduced.h5")
    assert re.search(f"eigenvalues {PROOF}", call("info", case.parent / "strip-reduced.h5"))
    body = read_case(case).flexible["strip"]
    exact = lowest_modes(body.stiffness, body.mass, N, constraint=MeanAxisFrame().constraint(body)).values
    errors = reduced.frequencies[:N] ** 2 / exact - 1
    assert np.all(errors > -1e-9)
    assert np.all(errors <= TOLERANCE)


def test_attachment_modes_join_the_vibrations_unless_told_otherwise(case):
    call("reduce", case, "-o", case.parent)
    assert read_reduced_body(case.parent / "strip-reduced.h5").r == N + 6
    with_keys(case, "attachment_modes = false")
    call("reduce", case, "-o", case.parent)
    assert read_reduced_body(case.parent / "strip-reduced.h5").r == N


def test_derivatives_of_the_vibrations_join_them(case):
    with_keys(case, 'derivatives = { kind = "compressed", number = 4 }')
    call("reduce", case, "-o", case.parent)
    report = read_reduced_body(case.parent / "strip-reduced.h5").report
    assert len(report.derivatives) == 4
    assert report.certificate is not None
    assert report.certificate.largest_error <= TOLERANCE


def test_a_linear_body_has_no_derivatives(case):
    with_keys(case, 'derivatives = { kind = "compressed", number = 4 }')
    case.write_text(case.read_text().replace("damping =", "linear = true\ndamping ="))
    assert "a linear body has no modal derivatives" in call("reduce", case, "-o", case.parent, code=2)


@pytest.mark.slow
def test_a_run_says_what_is_proven_and_bends_as_a_beam_does(case):
    """At rest the clamp carries the weight, and the tip hangs by w L^4 / (8 E I)."""
    weight, stiffness = 7850.0 * 0.1 * 0.01 * 9.81, 2.1e11 * 0.1 * 0.01**3 / 12
    with_keys(case, 'derivatives = { kind = "compressed", number = 3 }')  # bending draws the strip in
    output = call("run", case, "-o", case.parent / "out")
    assert re.search(f"strip: {PROOF}", output)
    assert len(re.findall(r"reducing body 'strip' \(150 freedoms\): \d+ modes, error 0\.0\d+ %", output)) == 1
    numbers = json.loads((case.parent / "out" / "strip.json").read_text())
    assert re.fullmatch(PROOF + r"\)", numbers["bodies"]["strip"]["eigenvalues"])
    hanging = numbers["tracked"]["strip.TIP"]["last deflection"][2]
    assert hanging == pytest.approx(-weight / (8 * stiffness), rel=1e-2)


def test_every_step_of_the_search_is_told_of_one_step_of_the_build(case):
    told: list[tuple[str, str]] = []
    system = read_case(case, lambda step, detail="": told.append((step, detail))).system
    (name,) = {step for step, detail in told if detail}
    steps = [detail for step, detail in told if step == name]
    assert steps[0] == ""
    certificate = system.bodies[0].body.report.certificate
    assert len(steps) == len(("it begins", *certificate.steps, "what was kept"))
    assert steps[-1].startswith(f"{certificate.n_fixed_interface_modes} modes, error ")


def test_more_eigenvalues_than_the_body_has_are_refused(case):
    case.write_text(case.read_text().replace(f"modes = {N}", "modes = 2000"))
    output = call("reduce", case, "-o", case.parent, code=2)
    assert "2000 eigenvalues requested of body 'strip', which has" in output
    assert "request fewer" in output
