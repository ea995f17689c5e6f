"""The files of sweeps in the examples and the how-to are valid, and mean what they say."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from supple.sweeps import make_plan, read_sweep_file

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", ["sweep_blade", "sweep_slider_crank"])
def test_27_designs_need_three_reductions(name):
    given = read_sweep_file(ROOT / "examples" / f"{name}.toml")
    plan = make_plan(given.case, given.table, given.output)
    assert plan.n_cases == 27
    assert np.bincount(plan.group).tolist() == [9, 9, 9]


def test_the_file_of_the_page_is_valid(tmp_path):
    page = (ROOT / "docs" / "how-to" / "sweeps.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "blade.toml").touch()
    (tmp_path / "wind.csv").write_text("load[0].law.file\na.csv\nb.csv\n")
    (tmp_path / "cases.toml").write_text(text)
    assert len(read_sweep_file(tmp_path / "cases.toml").table) == 2 * 64 * 3 * 3 * 3 * 6
