"""`supple example` writes what its examples need; `supple new` writes a case that can be read and built."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fixtures.abaqus_text import abaqus_text
from fixtures.section_tables import prismatic
from typer.testing import CliRunner

from supple import cases
from supple.cases.read_case import read_case
from supple.cli.main import app
from supple.errors import ArgumentError, CaseError, MeshError, ModelError
from supple.export import write_beamdyn
from supple.importers import read_mesh, write_section_csv
from supple.mesh import CellType, block

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_every_example_is_listed_with_a_title():
    titles = cases.example_titles()
    assert set(titles) == {
        path.name for path in EXAMPLES.iterdir() if path.suffix in {".toml", ".py", ".ipynb"}
    }
    assert all(len(title) > 15 for title in titles.values())


@pytest.mark.parametrize("name", [path.stem for path in EXAMPLES.glob("*.toml")])
def test_a_written_example_has_every_file_that_it_names(name, tmp_path):
    files = cases.write_example(name, tmp_path)
    for path in files:
        assert path.read_bytes() == (EXAMPLES / path.name).read_bytes()
    if (tmp_path / f"{name}.toml").exists() and not name.startswith("sweep"):
        case = read_case(tmp_path / f"{name}.toml")
        assert all((tmp_path / named).exists() for named in case.files)


def test_a_program_brings_its_table(tmp_path):
    names = {path.name for path in cases.write_example("reference_blade", tmp_path)}
    assert names == {"reference_blade.py", "iea22_blade.csv", "iea22_blade.README.md"}


@pytest.mark.parametrize(
    ("name", "command"), [("wing.toml", "run"), ("sweep_blade.toml", "sweep"), ("robot_arm.py", "python")]
)
def test_the_command_of_an_example_is_that_of_its_file(name, command):
    assert command in cases.command_of_example(EXAMPLES / name).split()


def test_what_is_there_is_not_replaced(tmp_path):
    cases.write_example("pendulum", tmp_path)
    with pytest.raises(ArgumentError, match="exists already"):
        cases.write_example("pendulum", tmp_path)


def test_a_folder_without_an_example_is_refused(tmp_path):
    result = CliRunner().invoke(app, ["example", "-o", str(tmp_path)])
    assert result.exit_code == 2
    assert "give the name of an example as well" in result.output


def test_an_unknown_example_is_named(tmp_path):
    with pytest.raises(ArgumentError, match=r"no example 'pendulun', did you mean 'pendulum.toml'"):
        cases.write_example("pendulun", tmp_path)


ROBOT = """<mujoco model="robot"><worldbody><body name="link"><joint name="hip" axis="0 1 0" armature="0.1"/>
<geom type="box" size="0.1 0.1 0.5" pos="0 0 -0.5"/></body></worldbody>
<actuator><motor joint="hip"/></actuator></mujoco>"""


def test_a_new_case_of_a_robot_has_its_machine_and_a_drive_to_uncomment(tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(ROBOT, encoding="utf-8")
    result = CliRunner().invoke(app, ["info", "robot.xml"])
    assert "supple new robot.xml" in " ".join(result.output.split())
    with pytest.raises(CaseError, match=r"is not a case file.*write one: supple new robot.xml"):
        read_case("robot.xml")
    assert CliRunner().invoke(app, ["new", "robot.xml"]).exit_code == 0
    text = Path("robot.toml").read_text(encoding="utf-8")
    assert 'leave_out = ["actuators", "armature"]' in text
    first, last = text.index("# [[element]]"), text.index("# A flexible body")
    driven = text[:first] + text[first:last].replace("# ", "") + text[last:]
    Path("robot.toml").write_text(driven, encoding="utf-8")
    system = read_case("robot.toml").system
    assert [type(each).__name__ for each in (*system.joints, *system.loads)] == ["Revolute", "AngleServo"]
    assert system.bodies[0].body.mass == pytest.approx(1000 * 0.2 * 0.2 * 1.0)


@pytest.mark.parametrize(("mesh", "kind"), [("wing.inp", "shell"), ("rod.inp", "solid")])
def test_a_new_case_is_read_and_built(mesh, kind, tmp_path):
    path = tmp_path / "made.toml"
    cases.write_new_case(EXAMPLES / mesh, path)
    case = read_case(path)
    (body,) = case.tables.body
    assert body.kind == kind
    assert case.tables.joint[0].first == "ground"
    held = read_mesh(EXAMPLES / mesh).node_sets[body.interface[0].nodes]
    assert len(held) < len(case.flexible[body.name].nodes) / 2
    assert case.flexible[body.name].n > 0
    assert case.run.times[-1] == 1.0
    assert body.condense is not None  # both are slender
    assert (body.interface[0].nodes, body.interface[1].nodes) == ("ROOT", "TIP")
    assert case.tables.output.track == ("wing.tip" if kind == "shell" else "rod.tip",)


@pytest.mark.parametrize("name", ["blade.csv", "blade.dat"])
def test_a_new_case_of_a_section_table(name, tmp_path):
    """A uniform curve of 4 m and 3 kg/m; as CSV, and in BeamDyn's files, whose suffix is also Nastran's."""
    write = write_section_csv if name == "blade.csv" else lambda table, path: write_beamdyn(path, table)
    write(prismatic(n=9), tmp_path / name)
    case = tmp_path / "case.toml"
    told = [CliRunner().invoke(app, [what, str(tmp_path / name)]) for what in ("info", "check")]
    assert re.search(r"mass\s+│ 12 ", told[0].output)
    assert "a section table is not a complete model; write a case: supple new" in " ".join(
        told[1].output.split()
    )
    cases.write_new_case(tmp_path / name, case)
    read = read_case(case)
    (placed,) = read.system.bodies
    assert (placed.body.mass, placed.body.line.n) == (pytest.approx(12.0), 31)
    assert read.tables.output.track == ("blade.tip",)


@pytest.mark.parametrize(("cells", "stations"), [(6, 7), (10, 11), (40, 21)])
def test_a_coarse_slender_mesh_has_the_stations_that_it_supports(cells, stations, tmp_path):
    """A row of boxes: one more station than boxes is the most that `condense` accepts."""
    mesh = block(1.0, 0.1, 0.1, cells, 1, 1, CellType.HEXA8)
    (tmp_path / "row.inp").write_text(abaqus_text(mesh))
    cases.write_new_case(tmp_path / "row.inp", tmp_path / "row.toml")
    case = read_case(tmp_path / "row.toml")
    assert case.tables.body[0].condense.stations == stations
    (placed,) = case.system.bodies
    assert placed.body.line.n == stations


def test_first_order_tetrahedra_get_mid_edge_nodes(tmp_path):
    """The free bar bends at 22.373 / (2 pi L^2) sqrt(E I / m'); with the four-node cells 60 % above."""
    mesh = block(1.0, 0.05, 0.05, 20, 1, 1, CellType.TETRA4)
    (tmp_path / "bar.inp").write_text(abaqus_text(mesh))
    cases.write_new_case(tmp_path / "bar.inp", tmp_path / "bar.toml")
    case = read_case(tmp_path / "bar.toml")
    assert case.tables.body[0].solid.second_order
    body = case.flexible["bar"]
    assert list(body.model.mesh.cells) == [CellType.TETRA10]
    np.testing.assert_array_equal(body.model.mesh.node_ids[: mesh.n_nodes], mesh.node_ids + 1)
    found = np.sqrt(body.lowest_modes(7).values[6]) / (2 * np.pi)
    beam = 22.373 / (2 * np.pi) * np.sqrt(2.1e11 * 0.05**2 / 12 / 7850.0)
    assert found == pytest.approx(beam, rel=0.02)


def test_the_clamped_set_has_an_extent_and_the_tracked_one_is_apart(tmp_path):
    """A node cannot clamp a solid; a set of the clamped nodes does not move, a set near them moves little."""
    cube = block(1.0, 1.0, 1.0, 2, 2, 2, CellType.HEXA8)
    root = cube.nodes_of("root")
    near = np.flatnonzero(cube.nodes[:, 0] == 0.5)[:2]
    sets = {"corner": cube.nodes_of("tip")[:1], "root": root, "again": root[:3], "near": near}
    (tmp_path / "cube.inp").write_text(abaqus_text(replace(cube, node_sets=sets)))
    cases.write_new_case(tmp_path / "cube.inp", tmp_path / "cube.toml")
    case = read_case(tmp_path / "cube.toml")
    assert case.tables.body[0].interface[0].nodes == "ROOT"
    assert case.tables.output.track == ("cube.CORNER",)


def test_a_mesh_beside_the_case_is_named_relative_to_it(tmp_path):
    mesh = tmp_path / "rod.inp"
    mesh.write_bytes((EXAMPLES / "rod.inp").read_bytes())
    cases.write_new_case(mesh, tmp_path / "rod.toml")
    assert 'mesh = "rod.inp"' in (tmp_path / "rod.toml").read_text()
    with pytest.raises(ArgumentError, match="exists already"):
        cases.write_new_case(mesh, tmp_path / "rod.toml")


def test_cells_that_a_case_of_the_mesh_cannot_use_are_refused_with_a_remedy(tmp_path):
    rod = tmp_path / "rod.inp"
    rod.write_bytes((EXAMPLES / "rod.inp").read_bytes())
    case = tmp_path / "rod.toml"
    cases.write_new_case(rod, case)
    case.write_text(case.read_text().replace("solid = {", "shell = { thickness = 1.0,"))
    with pytest.raises(ModelError, match=r"TETRA10 cells: for solids give solid = "):
        assert read_case(case).flexible
    line = tmp_path / "line.msh"
    line.write_text(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 1 0 0\n$EndNodes\n"
        "$Elements\n1\n1 1 2 1 1 1 2\n$EndElements\n"
    )
    with pytest.raises(ArgumentError, match="no cross-sections of beams: give a deck"):
        cases.write_new_case(line, tmp_path / "line.toml")


def test_one_of_several_parts_of_a_mesh_is_a_body(tmp_path):
    """Two plates of 1 m2 that are not connected; one is the body, of 78.5 kg."""
    mesh = tmp_path / "two.inp"
    corners = [(left + x, y) for left in (0, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh.write_text(
        "*NODE\n"
        + "".join(f"{i},{x},{y},0\n" for i, (x, y) in enumerate(corners, 1))
        + "*ELEMENT, TYPE=S4, ELSET=A\n1,1,2,3,4\n*ELEMENT, TYPE=S4, ELSET=B\n2,5,6,7,8\n"
        + "*NSET, NSET=EDGE\n5,8\n"
    )
    with pytest.raises(MeshError, match="cells = 'CELL SET'"):
        cases.write_new_case(mesh, tmp_path / "two.toml")
    case = tmp_path / "two.toml"
    case.write_text(
        'title = "one of two"\n[[body]]\nname = "b"\nmesh = "two.inp"\ncells = "B"\n'
        "shell = { thickness = 0.01, youngs_modulus = 2e11, poissons_ratio = 0.3, density = 7850.0 }\n"
        'frame = { kind = "mean-axis" }\n[[body.interface]]\nname = "edge"\nnodes = "EDGE"\n'
        "[simulation]\nduration = 1.0\noutput_step = 0.1\nstep = 0.1\n"
    )
    body = read_case(case).flexible["b"]
    assert body.nodes[:, 0].tolist() == [2, 3, 3, 2]
    assert read_case(case).sources["b"].check(0).mass.mass == pytest.approx(78.5)


DECK = """\
CEND
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
CQUAD4,1,1,1,2,3,4
PSHELL,1,1,0.01,1
MAT1,1,7.+10,,0.3,2700.
ENDDATA
"""


def test_a_deck_brings_its_properties_and_a_body_without_sets_is_free(tmp_path):
    deck = tmp_path / "plate.bdf"
    deck.write_text(DECK)
    cases.write_new_case(deck, tmp_path / "plate.toml")
    case = read_case(tmp_path / "plate.toml")
    assert case.tables.body[0].kind == "nastran"
    assert not case.tables.joint
    assert '# nodes = "SET"' in (tmp_path / "plate.toml").read_text()


def test_a_deck_of_masses_and_springs_is_a_body(tmp_path):
    masses = "".join(f"GRID,{n},,{n}.,0.,0.\nCONM2,1{n},{n},,20.,,,,,+\n+,2.,,2.,,,2.\n" for n in (1, 2, 3))
    springs = "PBUSH,7,K,2.E6,3.E6,4.E6,5.E5,5.E5,5.E5\nCBUSH,21,7,1,2,,,,0\nCBUSH,22,7,2,3,,,,0\n"
    (tmp_path / "lump.bdf").write_text(masses + springs + "SPC1,1,123456,1\n")
    cases.write_new_case(tmp_path / "lump.bdf", tmp_path / "lump.toml")
    body = read_case(tmp_path / "lump.toml").flexible["lump"]
    assert np.trace(body.rigid_modes[:, :3].T @ body.mass @ body.rigid_modes[:, :3]) == pytest.approx(
        3 * 60.0
    )


@pytest.mark.parametrize(
    ("material", "length", "gravity", "second"),
    [
        ("7.+10,,0.3,2700.", "m", -9.81, 1.0),
        ("71000.,,0.3,2.7-9", "mm", -9810.0, 1.0),
        ("1.+7,,0.3,2.54-4", "in", -386.1, 1.0),
        ("71.,,0.3,2.7-6", "mm", -0.00981, 1000.0),  # with kg and ms
    ],
)
def test_the_units_of_a_deck_are_those_of_its_materials(material, length, gravity, second, tmp_path):
    deck = tmp_path / "plate.bdf"
    deck.write_text(DECK.replace("7.+10,,0.3,2700.", material))
    cases.write_new_case(deck, tmp_path / "plate.toml")
    case = read_case(tmp_path / "plate.toml")
    assert case.units.length == length
    assert case.tables.gravity[2] == gravity
    assert case.run.times[-1] == second
