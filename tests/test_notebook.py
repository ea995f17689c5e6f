"""The example notebook: its cells are Python without outputs, and run from the mesh to the report."""

from __future__ import annotations

import ast
import json
import re
import shutil
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOK = EXAMPLES / "wing.ipynb"


def code_cells():
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


def test_its_cells_are_python_without_outputs():
    cells = code_cells()
    assert len(cells) > 5
    for cell in cells:
        ast.parse("".join(cell["source"]))
        assert cell["outputs"] == []
        assert cell["execution_count"] is None


def test_it_takes_names_that_are_there():
    import supple as sp

    text = "\n".join("".join(cell["source"]) for cell in code_cells())
    names = set(re.findall(r"\bsp\.(\w+)", text))
    assert len(names) > 15
    assert names <= set(dir(sp))


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """What each cell shows, by the first word of its last line; the folder that it ran in."""
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    folder = tmp_path_factory.mktemp("notebook")
    shutil.copy(EXAMPLES / "wing.inp", folder)
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    resources = {"metadata": {"path": str(folder)}}
    nbclient.NotebookClient(notebook, timeout=3600, kernel_name="python3", resources=resources).execute()
    return [cell.outputs for cell in notebook.cells if cell.cell_type == "code"], folder


@pytest.mark.slow
def test_it_runs_and_shows_tables_a_player_a_picture_and_no_error(outputs):
    every, folder = outputs
    results = [[one for one in cell if one.output_type == "execute_result"] for cell in every]
    assert [len(cell) for cell in results] == [1] * len(every)
    assert not [one for cell in every for one in cell if one.output_type in ("stream", "error")]
    plain = [cell[0].data["text/plain"] for cell in results]
    assert max(len(text.splitlines()) for text in plain) <= 10
    html = [cell[0].data.get("text/html", "") for cell in results]
    assert sum(text.startswith("<table>") for text in html) == 7
    assert sum(text.startswith('<iframe srcdoc="') for text in html) == 1
    assert sum(text.startswith('<img src="data:image/png;base64,') for text in html) == 1
    error = next(text for text in html if "Error of" in text)
    assert "not estimated" not in error
    assert (folder / "wing.png").stat().st_size > 10_000
    assert (folder / "wing.html").stat().st_size > 500_000


@pytest.mark.slow
def test_long_work_showed_a_bar_that_is_gone(outputs):
    """A line that was updated in place: what is left of it is empty, and no library was asked for."""
    bars = [one for cell in outputs[0] for one in cell if one.output_type == "display_data"]
    assert bars
    assert {one.data["text/plain"] for one in bars} == {""}
