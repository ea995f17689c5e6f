"""The page of a sweep is made of its folder; extremes lead to reports of their cases."""

import re

import numpy as np
import pytest
from fixtures.report_page import ReadPage
from fixtures.swept_pendulum import TABLE
from sweeps.test_sweep import Here

from supple.errors import ResultFileError
from supple.sweeps import (
    CaseTable,
    FatigueLoads,
    plan_sweep,
    read_sweep,
    sweep,
    sweep_extremes,
    write_sweep_report,
)
from supple.sweeps.plan import make_plan
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.sweep_report import _moves


def shown(path):
    """Text of the page, what its script reads, and its columns by name."""
    page = ReadPage(path)
    return page.text, page.head["sweep"], page.cases()


def test_the_page_holds_parameters_statistics_and_spectra(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, TABLE, folder, executor=Here(), fatigue=FatigueLoads(exponents=[4], channels=["joint *"]))
    text, sweep_data, columns = shown(write_sweep_report(folder))
    read = read_sweep(folder)
    assert list(columns["body.bob.rigid.mass"]) == list(read["body.bob.rigid.mass"].values)
    force = read.statistics.sel(channel="joint hinge.Fx")
    assert np.array_equal(columns["joint hinge.Fx, maximum (N)"], force.sel(statistic="maximum").values)
    load = force.sel(statistic="damage-equivalent range, m = 4").values
    assert np.array_equal(columns["joint hinge.Fx, damage-equivalent range, m = 4 (N)"], load)
    assert len(sweep_data["spectra"]) >= 1
    assert sweep_data["exponents"] == [4]
    assert sweep_data["reports"] == {}
    assert "6 cases of pendulum.toml: 6 ran." in text
    assert "6 cases without an estimate of their error: no body is elastic" in text
    assert set(read.no_estimate.values) == {text[text.index("no body is elastic") :].partition(".")[0]}
    assert "why no estimate" not in columns
    assert "residue as half cycles" in text


def test_failed_cases_are_named_with_their_cause(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, CaseTable({"body.bob.rigid.mass": [1.0, -1.0]}), folder, executor=Here())
    text, _, columns = shown(write_sweep_report(folder))
    assert columns["status"] == ["ran", "failed"]
    assert [bool(reason) for reason in columns["why no estimate"]] == [True, False]
    assert "1 ran, 1 failed" in text
    assert "mass" in re.search(r"<td>1</td><td>failed</td><td>(.*?)</td>", text, re.DOTALL).group(1)
    assert np.isnan(columns["joint hinge.Fx, maximum (N)"][1])


def test_a_sweep_that_begins_anew_has_no_page_of_the_former_one(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, CaseTable({"gravity[2]": [-9.81]}), folder, executor=Here(), seeds=["gravity[2]"])
    write_sweep_report(folder)
    assert {"sweep.html", "conditions.html"} <= {path.name for path in folder.iterdir()}
    plan_sweep(make_plan(pendulum, CaseTable({"gravity[2]": [-1.0]}), SweepOutput()), folder, force=True)
    assert not list(folder.glob("*.html"))


def test_extremes_are_those_of_the_data_set(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, TABLE, folder, executor=Here())
    read = read_sweep(folder)
    found = {(each.channel, each.statistic): each for each in sweep_extremes(folder)}
    assert ("joint hinge.Mx", "maximum") not in found  # zero in every case
    assert ("joint hinge.Fx", "minimum") in found
    largest = read.statistics.sel(channel="joint hinge.Fx", statistic="maximum").values
    extreme = found["joint hinge.Fx", "maximum"]
    assert (extreme.value, extreme.case) == (largest.max(), largest.argmax())
    times = read.statistics.sel(channel="joint hinge.Fx", statistic="time of maximum").values
    assert extreme.time == times[extreme.case]
    with pytest.raises(ResultFileError):
        sweep_extremes(tmp_path)


@pytest.mark.slow
def test_the_case_with_the_most_extremes_has_a_report(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, TABLE, folder, executor=Here())
    _, sweep_data, _ = shown(write_sweep_report(folder, n_reports=1))
    ((case, address),) = sweep_data["reports"].items()
    assert address == f"cases/{int(case):05}.html"
    text = (folder / address).read_text(encoding="utf-8")
    assert f"pendulum let go level, case {case}" in text
    mass = TABLE.row(int(case))["body.bob.rigid.mass"]
    assert f"body.bob.rigid.mass = {mass}" in text
    # A page written later keeps it; a sweep that begins anew does not.
    _, sweep_data, _ = shown(write_sweep_report(folder))
    assert sweep_data["reports"] == {case: address}
    sweep(pendulum, CaseTable({"gravity[2]": [-1.0]}), folder, executor=Here(), force=True)
    assert not (folder / address).exists()


BEAM = """\
*NODE
1, 0.0, 0.0, 0.0
2, 1.0, 0.0, 0.0
*ELEMENT, TYPE=B31, ELSET=ALL
1, 1, 2
*NSET, NSET=ROOT
1
*MATERIAL, NAME=STEEL
*ELASTIC
2e11, 0.3
*DENSITY
7800.0
*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION=RECT
0.02, 0.01
0.0, 0.0, 1.0
"""
BEAM_CASE = """\
title = "beam"

[[body]]
name = "beam"
mesh = "beam.inp"
abaqus = {}
frame = { kind = "mean-axis" }
reduction = { basis = "normal-modes", modes = 1 }

[simulation]
duration = 0.001
output_step = 0.001
step = 0.001
"""


def test_a_report_of_a_case_draws_beams_as_the_report_of_a_run_does(tmp_path):
    """A rectangular section: a prism of one element has 12 triangles."""
    (tmp_path / "beam.inp").write_text(BEAM)
    path = tmp_path / "beam.toml"
    path.write_text(BEAM_CASE)
    sweep(path, CaseTable({"gravity": [[0.0, 0.0, -9.81]]}), tmp_path / "out", executor=Here())
    write_sweep_report(tmp_path / "out", n_reports=1)
    page = ReadPage(tmp_path / "out" / "cases" / "00000.html")
    assert page.array(page.body("beam")["triangles"]).shape == (3, 12)


def test_round_off_of_a_unit_is_no_extreme():
    units = np.array(["N", "N", "N", "m", "m"], dtype=object)
    low = np.array([[-3.0, -1e-14, np.nan, 0.0, 2.0], [-5.0, 0.0, np.nan, -1e-12, 2.0]])
    high = np.array([[4.0, 1e-13, np.nan, 1e-12, 2.0], [1.0, 2e-14, np.nan, 0.0, 2.0]])
    assert _moves(units, low, high).tolist() == [True, False, False, False, False]
    assert _moves(units[:0], low[:, :0], high[:, :0]).tolist() == []
