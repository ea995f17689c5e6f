"""The programs printed in the README and the how-tos run as they stand."""

from __future__ import annotations

import ast
import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import supple as sp
from supple.errors import IdentifiabilityWarning
from supple.simulation import engines

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def programs(page):
    """The Python blocks of a page, in order."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), flags=re.MULTILINE | re.DOTALL)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder in which the programs run as in the repository's root, without writing there."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(page):
    """Run all programs of a page, one after the other, in one namespace."""
    namespace = {}
    for program in programs(page):
        exec(compile(program, page.name, "exec"), namespace)
    return namespace


@pytest.mark.slow
def test_ten_lines_print_the_number_and_draw_the_picture_that_the_readme_promises(here, capsys):
    run(ROOT / "README.md")
    printed = capsys.readouterr().out.strip()
    assert f"It prints `{printed}` and draws `blade.png`" in (ROOT / "README.md").read_text()
    assert (here / "blade.png").stat().st_size > 10_000


@pytest.mark.slow
def test_reduce_in_python(here):
    said = run(ROOT / "docs/how-to/reduce_in_python.md")
    strip = said["corrected"].bodies["strip"]
    assert said["displacement"].shape == (101, len(said["body"].nodes), 3)
    assert strip.estimated_error <= strip.rounds[-1].allowed
    assert said["together"].bodies["strip"].rounds[0].size < strip.rounds[0].size
    assert said["small"].r == said["motion"].bodies["strip"].coordinates.shape[1]
    assert said["shares"][0, 2] == pytest.approx(0.6131, rel=5e-3)  # of a clamped beam


@pytest.mark.slow
def test_calibrate(here):
    with pytest.warns(IdentifiabilityWarning, match="do not determine mass"):
        fit = run(ROOT / "docs/how-to/calibrate.md")["fit"]
    (deviation, _) = fit.uncertainty.deviations
    assert abs(fit.parameters["length"] - 0.8) < 3 * deviation
    assert deviation < 0.002
    assert [set(each) for each in fit.uncertainty.undetermined] == [{"mass"}]


@pytest.mark.slow
def test_flexible_machine(here):
    said = run(ROOT / "docs/how-to/flexible_machine.md")
    assert said["at_node"].shape == (201,)
    assert said["drift"] < 1e-3
    assert (here / "link.png").stat().st_size > 10_000


def test_fatigue(here):
    found = run(ROOT / "docs/how-to/fatigue.md")
    assert found["load"].ranges.shape == (2,)
    assert found["damage"].shape == (2,)
    assert found["life"].covered == pytest.approx(np.exp(-((4 / 9.6) ** 2)) - np.exp(-((25 / 9.6) ** 2)))


def test_a_method_of_your_own(here, monkeypatch):
    """The engine of the page meets the parabola, which its rule integrates exactly."""
    monkeypatch.setattr(engines, "_ENGINES", dict(engines._ENGINES))
    motion = run(ROOT / "docs/how-to/a_method_of_your_own.md")["motion"].bodies["stone"]
    np.testing.assert_allclose(motion.position[-1], [6.0, 0.0, 10.0 - 9.81 * 2.0**2 / 2], atol=1e-12)


@pytest.mark.parametrize("page", [page for page in PAGES if programs(page)], ids=lambda page: page.stem)
def test_what_a_page_imports_is_there(page):
    """Programs that need files or other codes, too: their imports, and the names they take from `sp`."""
    for program in programs(page):
        tree = ast.parse(program)
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and find_spec(node.module.split(".")[0]):
                exec(ast.unparse(node), {})
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "sp":
                getattr(sp, node.attr)
