"""The how-to page names every key and every choice of the schema, and the examples in the docs are valid."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from supple.cases import read_case, run_case
from supple.cases.case_tables import CaseTables
from supple.fem import Isotropic, solid_model
from supple.importers import read_mesh
from supple.mesh import CellType, block, cylinder

ROOT = Path(__file__).parents[2]


def words_of_the_schema():
    """Keys of all tables, and their fixed choices."""
    root = CaseTables.model_json_schema()
    for table in (root, *root["$defs"].values()):
        for key, rule in table["properties"].items():
            yield key
            yield from rule.get("enum", [])
            if "const" in rule:
                yield rule["const"]


@pytest.mark.parametrize("word", sorted({str(word) for word in words_of_the_schema()}))
def test_the_page_names_every_key_and_choice(word):
    page = (ROOT / "docs" / "how-to" / "case_file.md").read_text(encoding="utf-8")
    assert re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", page)


def test_the_script_of_the_page_runs(case_folder, monkeypatch):
    page = (ROOT / "docs" / "how-to" / "case_file.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    text = (case_folder / "strip.toml").read_text().replace("duration = 0.4", "duration = 0.004")
    (case_folder / "blade.toml").write_text(text)
    monkeypatch.chdir(case_folder)
    names: dict[str, Any] = {}
    exec(compile(script, "case_file.md", "exec"), names)
    assert names["solution"].times[-1] == 0.004


def test_the_example_of_the_mesh_page_is_a_valid_case(tmp_path):
    page = (ROOT / "docs" / "how-to" / "your_own_mesh.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "wing.inp").touch()
    (tmp_path / "wing.toml").write_text(text, encoding="utf-8")
    assert read_case(tmp_path / "wing.toml").tables.body[0].name == "wing"


def test_the_case_of_the_page_on_bulk_data_is_valid(tmp_path):
    page = (ROOT / "docs" / "how-to" / "from_bulk_data.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "satellite.bdf").touch()
    times = np.linspace(0, 40, 41)
    angles = 0.15 * (1 - np.cos(np.pi * np.minimum(times, 20) / 20))
    np.savetxt(tmp_path / "angle.csv", np.column_stack([times, angles]), delimiter=",")
    (tmp_path / "docked.toml").write_text(text, encoding="utf-8")
    assert [body.name for body in read_case(tmp_path / "docked.toml").tables.body] == ["first", "second"]


def test_the_examples_of_the_import_page_are_valid_cases(tmp_path):
    page = (ROOT / "docs" / "how-to" / "imported_models.md").read_text(encoding="utf-8")
    rest = '\ntitle = "arm"\n[simulation]\nduration = 1.0\noutput_step = 0.1\nstep = 0.1\n'
    for name in ("arm.bdf", "arm.pch", "arm.op4"):
        (tmp_path / name).touch()
    found = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    for text in found:
        title, simulation = rest.split("[simulation]")
        (tmp_path / "arm.toml").write_text(f"{title}\n{text}\n[simulation]{simulation}", encoding="utf-8")
        assert read_case(tmp_path / "arm.toml").tables.body[0].name == "arm"
    assert len(found) == 3


def test_the_imported_line_of_the_page_of_intrinsic_bodies_is_a_valid_case(tmp_path):
    page = (ROOT / "docs" / "how-to" / "intrinsic_body.md").read_text(encoding="utf-8")
    (text,) = [each for each in re.findall(r"```toml\n(.*?)```", page, re.DOTALL) if "paths" in each]
    for name in ("wing.bdf", "wing.pch"):
        (tmp_path / name).touch()
    joint = '[[joint]]\nkind = "fixed"\nfirst = "ground"\nsecond = "wing.root"\n'
    run = "[simulation]\nduration = 1.0\noutput_step = 0.1\nstep = 0.1\n"
    (tmp_path / "wing.toml").write_text(f'title = "wing"\n{text}\n{joint}{run}', encoding="utf-8")
    (body,) = read_case(tmp_path / "wing.toml").tables.body
    assert body.condense is not None
    assert body.condense.paths == ((1, 2, 3, 4), (2, 11, 12))


@pytest.mark.slow
def test_the_scripts_of_the_import_page_run(tmp_path, monkeypatch, bulk):
    """The bulk data and matrices of a block, written by the page's own function, give its two bodies."""
    mesh = block(1.0, 0.3, 0.2, 3, 1, 1, CellType.TETRA4)
    model = solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.bdf").write_text(bulk.text(mesh, *bulk.solid()))
    page = (ROOT / "docs" / "how-to" / "imported_models.md").read_text(encoding="utf-8")
    superelements, writer, script, *_ = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    bars = [
        f"BEGIN SUPER={n + 1}\nGRID,1,,{n},0,0\nGRID,2,,{n + 1},0,0\nCBAR,1,7,1,2,0.,0.,1.\n"
        "PBAR,7,5,4.-4,1.-8,1.-8,1.-8\nMAT1,5,2.1+11,,.3,7850.\n"
        for n in (0, 1)
    ]
    (tmp_path / "wing.bdf").write_text("BEGIN BULK\n" + "".join(bars).replace(",0,0", ",0.,0.") + "ENDDATA\n")
    exec(compile(superelements, "imported_models.md", "exec"), names)
    assert [joint.name for joint in names["wing"].joints] == ["wing node-2"]
    exec(compile(writer, "imported_models.md", "exec"), names)
    ids = np.arange(1, mesh.n_nodes + 1)
    freedoms = np.column_stack([np.repeat(ids, 3), np.tile([1, 2, 3], len(ids))])
    names["write_matrices"](
        "arm.h5", ids, mesh.nodes, freedoms, model.stiffness, model.mass, {"root": ids[:4]}
    )
    exec(compile(script.replace("arm.pch", "arm.h5"), "imported_models.md", "exec"), names)
    assert names["check"].is_accepted
    assert abs(names["same"].stiffness - names["arm"].stiffness).max() == 0


def test_the_blade_example_is_a_valid_case():
    case = read_case(ROOT / "examples" / "blade.toml").tables
    assert case.joint[0].law is not None
    assert case.simulation.duration == 20.0


def test_the_impact_example_and_page_are_valid_cases(tmp_path):
    case = read_case(ROOT / "examples" / "impact.toml")
    assert [body.name for body in case.tables.body] == ["rest", "nose"]
    joint = [case.meshes[name].nodes[case.meshes[name].node_sets["JOINT"]] for name in ("rest", "nose")]
    np.testing.assert_array_equal(*joint)
    page = (ROOT / "docs" / "how-to" / "explicit_impact.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "cars.inp").touch()
    (tmp_path / "cars.toml").write_text(text, encoding="utf-8")
    assert len(read_case(tmp_path / "cars.toml").tables.contact) == 2


def test_the_rod_of_the_examples_is_the_mesh_its_page_says():
    read, made = read_mesh(ROOT / "examples" / "rod.inp"), cylinder(0.02, 1.0, 2, 1, 12, CellType.TETRA10)
    np.testing.assert_allclose(read.nodes, made.nodes, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(read.cells[CellType.TETRA10], made.cells[CellType.TETRA10])
    for name in ("root", "tip"):
        np.testing.assert_array_equal(np.sort(read.nodes_of(name.upper())), np.sort(made.nodes_of(name)))


@pytest.mark.slow
def test_the_pendulum_example_pulls_at_its_joint_as_a_rigid_bar_does(tmp_path):
    """Let go level, a bar of weight W pulls at its lowest point with 2.5 W; the rod bends little."""
    text = (ROOT / "examples" / "pendulum.toml").read_text(encoding="utf-8")
    (tmp_path / "rod.inp").write_bytes((ROOT / "examples" / "rod.inp").read_bytes())
    (tmp_path / "pendulum.toml").write_text(
        text + "pictures = false\nanimation = false\nreport = false\n", encoding="utf-8"
    )
    run_case(read_case(tmp_path / "pendulum.toml"), tmp_path)
    numbers = json.loads((tmp_path / "pendulum.json").read_text(encoding="utf-8"))
    assert "10 eigenvalues, each within 0.1 %, none missed" in numbers["bodies"]["rod"]["eigenvalues"]
    weight = numbers["bodies"]["rod"]["mass"] * 9.81
    assert numbers["joints"]["ball"]["largest force"] == pytest.approx(2.5 * weight, rel=5e-3)


@pytest.mark.slow
def test_the_script_of_the_reduction_page_runs():
    page = (ROOT / "docs" / "how-to" / "reduce_in_python.md").read_text(encoding="utf-8")
    script = "\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    names: dict[str, object] = {}
    exec(compile(script, "reduce_in_python.md", "exec"), names)
    assert names["displacement"].shape == (101, 63, 3)


@pytest.mark.slow
def test_the_script_of_the_machine_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "how-to" / "flexible_machine.md").read_text(encoding="utf-8")
    script = "\n".join(re.findall(r"```python\n(.*?)```", page, re.DOTALL))
    names: dict[str, object] = {}
    exec(compile(script, "flexible_machine.md", "exec"), names)
    assert names["drift"] < 1e-3
    # A rigid rod on its pin bends most at a third of its length from there.
    mesh, stress = names["mesh"], names["everywhere"].von_mises(names["gamma"][names["instant"]])
    assert abs(mesh.nodes[stress.argmax(), 0] - 0.1) < 0.035
    assert (tmp_path / "link.png").exists()
