"""The three bodies of the mode-selection study."""

from __future__ import annotations

import pytest

from supple.mesh import CellType, RodCells
from supple_benchmarks.eigenvalue_error.mode_selection_study import (
    draw_studies,
    selection_studies,
    selection_table,
)
from supple_benchmarks.eigenvalue_error.problem import EigenvalueErrors


@pytest.fixture(scope="module")
def studies():
    coarse = RodCells(around=6, ring=1, shank=6, width=2, thickness=1)
    problem = EigenvalueErrors(cylinders=((CellType.TETRA4, 8),), rods=((CellType.TETRA4, coarse),))
    return list(selection_studies(problem, (10, 20), candidates=40))


def test_every_body_meets_every_rule(studies):
    assert [study.body for study in studies] == ["cylinder", "rod", "box"]
    for study in studies:
        rules = [rule["selection"] for rule in study.as_row()["rules"]]
        assert rules.count("lowest frequency") == rules.count("coupling moment") == 2


def test_table_has_a_line_for_each_body_and_rule_and_leaves_gaps(studies):
    _, heads, rows = selection_table(studies)
    assert heads == ["body", "basis", "10", "20"]
    assert len(rows) == 12
    by_rule = {(row[0], row[1]): row[2:] for row in rows}
    # Two interfaces have twelve residual modes, more than ten columns hold.
    assert by_rule["box", "lowest frequency, residual modes"][0] == ""
    assert by_rule["cylinder", "lowest frequency, residual modes"][0] != ""
    for quality in studies[0].qualities:
        written = by_rule["cylinder", quality.selection][[10, 20].index(quality.size)]
        assert abs(float(written) / (100 * quality.transfer_error) - 1.0) <= 0.05


@pytest.mark.slow
def test_pictures_are_named_after_the_bodies(studies, tmp_path):
    pictures = draw_studies(studies, tmp_path / "figures")
    assert [picture.name for picture in pictures] == [
        "mode_selection_cylinder.png",
        "mode_selection_rod.png",
        "mode_selection_box.png",
    ]
    assert all(picture.stat().st_size > 0 for picture in pictures)
