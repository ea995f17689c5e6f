"""The pages name only what exists: code that papers map to, files, and what the bibliography lists."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAPERS = ROOT / "docs" / "papers"
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


DOCUMENTED = [
    page.read_text(encoding="utf-8")
    for page in (*ROOT.glob("*.md"), *(ROOT / "examples").glob("*.md"), *(ROOT / "docs").rglob("*.md"))
    if page.name != "CHANGELOG.md"
]


def test_the_files_that_pages_name_exist():
    files = [
        path.as_posix()
        for folder in ("src", "tests", "benchmarks", "examples")
        for path in (ROOT / folder).rglob("*.py")
    ]
    named = {name for page in DOCUMENTED for name in re.findall(r"`((?:\w+/)*\w+\.py)`", page)}
    gone = [name for name in named if not any(file.endswith(f"/{name}") for file in files)]
    assert [name for name in gone if not name.endswith("/x.py")] == []  # x: of a recipe


def test_the_bibliography_holds_what_is_cited_and_nothing_else():
    key = re.compile(r"\[(\w+(?:19|20)\d\d|Radioss)\]")
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.py")]
    bibliography = (ROOT / "docs" / "bibliography.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^- \[(\w+)\]", bibliography, re.MULTILINE))
    cited = {name for text in [*sources, *DOCUMENTED] if text != bibliography for name in key.findall(text)}
    assert cited == listed
