"""Scripts outside the package that no test runs import only names that exist."""

import ast
import importlib
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted(path for folder in ("benchmarks", "tools") for path in (ROOT / folder).rglob("*.py"))


def imported_names(path):
    """Module and name of each import from the package."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in {
            "supple",
            "supple_benchmarks",
        }:
            yield from ((node.module, each.name) for each in node.names)


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_what_a_script_imports_exists(path):
    for module, name in imported_names(path):
        assert hasattr(importlib.import_module(module), name) or find_spec(f"{module}.{name}"), (module, name)
