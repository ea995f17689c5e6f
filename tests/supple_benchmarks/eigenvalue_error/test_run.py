"""The acceptance figures of the eigenvalue-error benchmark, on meshes that take seconds."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from supple.mesh import CellType, RodCells
from supple.storage import write_json
from supple_benchmarks.eigenvalue_error.beam_frequencies import beam_frequencies
from supple_benchmarks.eigenvalue_error.figures import draw_figures
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors
from supple_benchmarks.eigenvalue_error.report import report, tables
from supple_benchmarks.eigenvalue_error.run import run_eigenvalue_errors

pytestmark = pytest.mark.slow

ROD = RodCells(around=9, ring=1, shank=8, width=3, thickness=1)
PROBLEM = EigenvalueErrors(
    cylinders=((CellType.TETRA4, 28),),
    rods=((CellType.TETRA4, ROD),),
    beams=((CellType.TETRA10, (3, 1, 20)), (CellType.TETRA4, (3, 1, 20))),
    candidates=40,
)


@pytest.fixture(scope="module")
def results():
    return list(run_eigenvalue_errors(PROBLEM, lambda label: lambda share: None))


@pytest.fixture(scope="module")
def beams():
    return beam_frequencies(PROBLEM)


def every(results):
    return [one for result in results for one in result.results]


def test_every_exact_error_is_within_the_tolerance_and_certified(results):
    assert [result.case.name for result in results] == ["cylinder", "rod"]
    for one in every(results):
        assert one.exact.max() <= one.tolerance
        assert one.proven.max() <= one.tolerance
        assert np.all(one.proven >= one.exact - 1e-9)
        assert one.counted
        assert one.same_answer


def test_at_ten_percent_the_estimates_alone_are_not_safe(results):
    loose = results[0].results[0]
    assert loose.effectivity("sharp").min() < 0.95


def test_at_small_tolerances_the_sharper_estimates_are_sharp(results):
    for one in every(results):
        if one.tolerance > 0.01:
            continue
        assert one.effectivity("sharp").min() > 0.999
        assert np.median(one.effectivity("sharp")) < 1.05
        assert abs(np.median(one.effectivity("two_term")) - 1) < 0.01
        assert one.effectivity("lower").max() < 1.001
        assert one.estimated_modes["lower"] <= one.estimated_modes["two_term"] <= one.estimated_modes["sharp"]
        assert one.estimated_modes["sharp"] <= one.estimated_modes["paper"]


def test_few_eigen_solves(results):
    for one in every(results):
        if one.tolerance < 0.01:
            assert len(one.steps) < 0.5 * one.n_one_by_one


@pytest.mark.slow
def test_the_cylinder_of_ten_node_tetrahedra_keeps_far_fewer_modes_than_published():
    problem = replace(
        PROBLEM, tolerances=(0.001,), cylinders=((CellType.TETRA10, 28),), rods=(), candidates=40
    )
    (result,) = run_eigenvalue_errors(problem, lambda label: lambda share: None)
    (one,) = result.results
    assert result.cells == 3528
    assert one.exact.max() <= 0.001
    assert one.effectivity("sharp").min() > 0.999
    assert one.modes <= 0.65 * one.estimated_modes["paper"]


def test_ten_node_tetrahedra_agree_with_beam_theory_and_four_node_ones_are_stiff(beams):
    assert {(row.element, row.motion) for row in beams} == {
        (element, motion) for element in ("tet10", "tet4") for motion in ("bending", "torsion")
    }
    for row in beams:
        if row.element == "tet10":
            assert abs(row.stiffness_error) < 0.002
        else:
            assert row.stiffness_error > 0.05


def test_report(results, beams, tmp_path):
    write_json(tmp_path / "report.json", report(results, beams))
    written = json.loads((tmp_path / "report.json").read_text())
    cylinder = written["bodies"][0]
    assert {key: written[key] for key in cylinder} == cylinder
    assert (cylinder["body"], cylinder["element"], cylinder["cells"]) == ("cylinder", "tet4", 3528)
    assert [one["e"] for one in cylinder["tolerances"]] == [0.1, 0.01, 0.001]
    assert [one["modes_published"] for one in cylinder["tolerances"]] == [35, 58, 446]
    for one in cylinder["tolerances"]:
        assert one["max_exact"] <= one["e"]
        assert one["certified_by_counts"] is True
        assert one["certified_by_enclosure"] is True
        assert {"modes", "modes_paper", "max_estimated", "seconds", "seconds_one_by_one"} <= one.keys()
        assert [len(one["effectivity"][name]) for name in ("lower", "paper", "sharp", "two_term")] == [30] * 4
    assert {"basis", "e", "size"} <= cylinder["bases"][0].keys()
    assert "Craig-Bampton" in {basis["basis"] for basis in cylinder["bases"]}
    assert set(written["why_counts_differ"]) == {"modes", "modes_paper", "modes_published"}
    assert "processor" in written["machine"]


def test_tables_and_figures(results, beams, tmp_path):
    for _, heads, rows in tables(results, beams):
        assert rows
        assert all(len(row) == len(heads) for row in rows)
    pictures = draw_figures(results, tmp_path)
    assert [picture.name for picture in pictures] == ["figure_4_cylinder_tet4.png", "figure_4_rod_tet4.png"]
    assert all(picture.stat().st_size > 10_000 for picture in pictures)
