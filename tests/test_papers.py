"""The pages that map papers to code name only what exists."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

PAPERS = Path(__file__).parents[1] / "docs" / "papers"
NAME = re.compile(r"`(supple\w*(?:\.\w+)+):(\w+(?:\.\w+)*)`")


def rows_of(page):
    """Cells of each row below the table's head: paper, what it is, here, deviation."""
    lines = [
        line for line in (PAPERS / page).read_text(encoding="utf-8").splitlines() if line.startswith("|")
    ]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


ROWS = [
    pytest.param(row, id=f"{page.stem} {row[0]} {row[1]}")
    for page in sorted(PAPERS.glob("*.md"))
    for row in rows_of(page.name)
]


@pytest.mark.parametrize("page", ["wu2019.md", "han2020.md"])
def test_each_paper_has_its_rows(page):
    assert len(rows_of(page)) > 20


@pytest.mark.parametrize("row", ROWS)
def test_what_a_row_names_exists(row):
    assert len(row) == 4
    named = NAME.findall(row[2])
    assert named
    assert len(named) == row[2].count("`") / 2
    for module, path in named:
        found = importlib.import_module(module)
        for name in path.split("."):
            found = getattr(found, name)
