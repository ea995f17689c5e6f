"""The site's tree has the target of every link and every key of a case file; docstrings become numpydoc's."""

from __future__ import annotations

import re
import sys
from collections import Counter
from pathlib import Path

import pytest

from supple.cases.case_tables import CaseTables

SITE = Path(__file__).parents[1] / "tools" / "site"


@pytest.fixture(scope="module")
def tools():
    sys.path.insert(0, str(SITE))
    yield
    sys.path.remove(str(SITE))


@pytest.fixture(scope="module")
def tree(tools, tmp_path_factory):
    from assemble import assemble

    folder = tmp_path_factory.mktemp("site") / "tree"
    assemble(folder, folder / "no gallery")
    return folder


def test_links_of_the_tree_lead_to_files(tree):
    broken = []
    for page in tree.rglob("*.md"):
        for target in re.findall(r"\]\(([^()\s#]+)(?:#[^()\s]*)?\)", page.read_text("utf-8")):
            if "://" not in target and not (page.parent / target).exists():
                broken.append(f"{page.relative_to(tree)}: {target}")
    assert not broken
    assert len(list(tree.rglob("*.md"))) > 60


def test_the_navigation_names_every_page_of_the_documentation_once(tree):
    text = (SITE.parents[1] / "mkdocs.yml").read_text("utf-8")
    named = re.findall(r"[\w/-]+\.md", text.partition("\nnav:")[2])
    pages = {path.relative_to(tree).as_posix() for path in tree.rglob("*.md")}
    pages = {name for name in pages if not name.startswith(("repository/", "api/"))}
    assert {name for name in named if not name.startswith("api/")} == pages
    assert len(named) == len(set(named))


def test_the_reference_has_every_key_with_type_and_meaning(tree):
    """`[simulation] duration` is a row; keys that select a table are in its heading."""
    page = (tree / "reference" / "case_file.md").read_text("utf-8")
    lines = [line for line in page.splitlines() if line.startswith("| `")]
    rows = [[cell.strip() for cell in line.split(" | ")] for line in lines]
    listed = Counter(row[0].strip("| `") for row in rows)
    root = CaseTables.model_json_schema()
    keys = Counter(
        key
        for table in (root, *root["$defs"].values())
        for key, rule in table["properties"].items()
        if "const" not in rule
    )
    assert listed == keys
    assert not [row[0] for row in rows if not row[1] or ("[" not in row[1] and row[-1] == "|")]
    assert "| `duration` | number > 0 | a time | required | simulated time |" in page
    targets = set(re.findall(r"\{ #([\w-]+) \}", page))
    assert len(targets) == len(root["$defs"])
    assert set(re.findall(r"\]\(#([\w-]+)\)", page)) == targets


def test_a_clause_of_quantities_is_a_dimension(tools):
    from case_reference import dimension_and_meaning

    assert dimension_and_meaning("wall thickness, a length") == ("a length", "wall thickness")
    assert dimension_and_meaning("k, force per length; default: 0") == ("force per length", "k, default: 0")
    assert dimension_and_meaning("length of the name") == ("", "length of the name")


def test_entries_of_one_line_become_a_name_and_a_meaning(tools):
    pytest.importorskip("griffe")
    from docstrings import numpydoc

    written = numpydoc(
        "Turn it.\n\nParameters\n----------\nrate : float    rad/s,\n    of either sign\na, b : numbers\n"
        "Raises\n------\nModelError   no axis"
    )
    assert written.split("\n")[4:] == [
        *("rate", "    float    rad/s,", "    of either sign", "a, b", "    numbers", ""),
        *("Raises", "------", "ModelError", "    no axis", "", ""),
    ]
