"""The site's tree has every page and file that a page links to; entries of docstrings become numpydoc's."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

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
