"""Where the libraries that draw are not installed: cases with pictures are refused, others run."""

from __future__ import annotations

import sys

import pytest

from supple.cases import modes_case, read_case, run_case, static_case
from supple.errors import CaseError


@pytest.fixture
def no_matplotlib(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)


@pytest.mark.parametrize("question", [run_case, static_case, modes_case])
def test_a_case_with_pictures_is_refused_before_it_is_computed(question, case_folder, no_matplotlib):
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("pictures = false", "pictures = true"))
    with pytest.raises(CaseError, match=r"need matplotlib.*pip install 'supple\[plot\]'.*pictures = false"):
        question(read_case(path), case_folder / "out")
    assert not (case_folder / "out").exists()


def test_a_case_without_pictures_needs_no_library_that_draws(case_folder, no_matplotlib):
    found = static_case(read_case(case_folder / "strip.toml"), case_folder / "out")
    assert found.tracked


def test_python_names_what_to_install(monkeypatch, no_matplotlib):
    for name in [name for name in sys.modules if name.startswith("supple.viz")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(ImportError, match=r"pip install 'supple\[plot\]'"):
        import supple.viz  # noqa: F401
