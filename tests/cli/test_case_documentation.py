"""The how-to page names every key and every choice of the schema, and the examples in the docs are valid."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from supple.cli.case_schema import Case
from supple.cli.read_case import read_case

ROOT = Path(__file__).parents[2]


def words_of_the_schema():
    """Keys of all tables, and their fixed choices."""
    tables = [Case.model_json_schema(), *Case.model_json_schema()["$defs"].values()]
    for table in tables:
        for key, rule in table["properties"].items():
            yield key
            yield from rule.get("enum", [])
            if "const" in rule:
                yield rule["const"]


@pytest.mark.parametrize("word", sorted({str(word) for word in words_of_the_schema()}))
def test_the_page_names_every_key_and_choice(word):
    page = (ROOT / "docs" / "how-to" / "case_file.md").read_text(encoding="utf-8")
    assert re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", page)


def test_the_example_of_the_mesh_page_is_a_valid_case(tmp_path):
    page = (ROOT / "docs" / "how-to" / "your_own_mesh.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "wing.inp").touch()
    (tmp_path / "wing.toml").write_text(text, encoding="utf-8")
    assert read_case(tmp_path / "wing.toml").case.body[0].name == "wing"


def test_the_blade_example_is_a_valid_case():
    case = read_case(ROOT / "examples" / "blade.toml").case
    assert case.joint[0].law is not None
    assert case.simulation.duration == 20.0


@pytest.mark.slow
def test_the_script_of_the_reduction_page_runs():
    page = (ROOT / "docs" / "how-to" / "reduce_in_python.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, object] = {}
    exec(compile(script, "reduce_in_python.md", "exec"), names)
    assert names["displacement"].shape == (101, 63, 3)
