"""`supple info` of decks: everything that is there, in print and as numbers; a machine of a deck."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cli.main import app
from supple.errors import ModelError

BAR = """*NODE
1, 0, 0, 0
2, 0.25, 0, 0
3, 0.5, 0, 0
4, 0.75, 0, 0
5, 1, 0, 0
9, 7, 7, 7
*ELEMENT, TYPE=B31, ELSET=BAR
1, 1, 2
2, 2, 3
3, 3, 4
4, 4, 5
*ELEMENT, TYPE=MASS, ELSET=TIP
10, 5
*MASS, ELSET=TIP
2.0
*NSET, NSET=ROOT
1
*BEAM SECTION, ELSET=BAR, MATERIAL=STEEL, SECTION=RECT
0.02, 0.02
0, 0, 1
*MATERIAL, NAME=STEEL
*ELASTIC
2.1E11, 0.0
*DENSITY
7850
*BOUNDARY
ROOT, 1, 6
"""


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


@pytest.fixture
def bar(tmp_path):
    path = tmp_path / "bar.inp"
    path.write_text(BAR)
    return path


def test_the_numbers_of_a_deck(bar):
    """3.14 kg of bar and 2 kg at its end; held at the root the tip mass swings at sqrt(3 E I / L^3 / m)."""
    numbers = bar.with_suffix(".json")
    shown = call("info", bar, "--json", numbers, "--modes", 4, "--held")
    for part in (
        "elements B31",
        "node set ROOT",
        "unused nodes",
        "1, dropped",
        "cards read",
        "concentrated masses │ 1 │",
    ):
        assert part in shown
    assert ", -0" not in shown
    found = json.loads(numbers.read_text())
    assert set(found) == {
        *("nodes", "elements", "mass", "centre", "inertia", "left_out", "frequencies_hz"),
    }
    assert found["nodes"] == 6
    assert found["elements"]["B31"] == 4
    assert found["left_out"] == []
    assert found["mass"] == pytest.approx(5.14)
    assert found["centre"] == pytest.approx([(3.14 * 0.5 + 2.0) / 5.14, 0, 0])
    second_moment = 0.02**4 / 12
    rayleigh = (3 * 2.1e11 * second_moment / (2.0 + 33 / 140 * 3.14)) ** 0.5 / 6.283185
    assert found["frequencies_hz"][0] == pytest.approx(rayleigh, rel=5e-3)
    call("info", bar, "--json", numbers, "--modes", 2)
    assert json.loads(numbers.read_text())["frequencies_hz"][0] > 3 * rayleigh  # elastic, of the free body


def test_a_deck_without_density_or_with_faults_ends_well(bar):
    bar.write_text(BAR.replace("*DENSITY\n7850\n", "").replace("*MASS, ELSET=TIP\n2.0\n", ""))
    assert "statics only; give the materials a density" in call("info", bar, "--modes", 3)
    bar.write_text(BAR.replace("2, 0.25, 0, 0", "2, 0, 0, 0"))
    assert "no mass: " in call("info", bar, "--modes", 3)


def test_walls_without_density_beside_a_mass_are_reported(bar):
    wall = "*ELEMENT, TYPE=S3, ELSET=WALL\n20, 3, 4, 9\n*SHELL SECTION, ELSET=WALL, MATERIAL=AL\n0.01\n"
    light = "*MATERIAL, NAME=AL\n*ELASTIC\n7E10, 0.3\n"
    bar.write_text(BAR + wall + light)
    assert "1 solids or shells lack mass" in (said := call("info", bar))
    assert "no density: WALL (1)." in said


def test_a_deck_without_sections_is_described_and_verified_as_a_mesh(tmp_path):
    """The nodes of its elements are used; a mesh in two parts is refused, as in a `shell` body."""
    mesh = tmp_path / "mesh.inp"
    whole = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,0\n*ELEMENT, TYPE=S3, ELSET=A\n1,1,2,3\n2,2,4,3\n"
    mesh.write_text(whole)
    said = call("info", mesh)
    assert "2 cells" in said
    assert "LEFT OUT" not in said
    assert "unused" not in said
    (tmp_path / "mesh.bdf").write_text(
        "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,1.,1.,0.\n"
        "CTRIA3,1,1,1,2,3\nCTRIA3,2,2,2,4,3\n"
    )
    said = call("info", tmp_path / "mesh.bdf")
    assert "Mesh" in said
    assert "LEFT OUT" not in said
    mesh.write_text(whole.replace("*ELEMENT", "5,5,0,0\n6,6,0,0\n7,5,1,0\n*ELEMENT") + "3,5,6,7\n")
    assert "2 disconnected parts" in call("info", mesh, code=2)


def test_json_is_of_decks(tmp_path):
    (tmp_path / "a.toml").touch()
    assert "--json, --modes and --held are for decks" in call("info", tmp_path / "a.toml", "--held", code=2)


def test_options_without_effect_or_that_lose_the_deck_are_refused(bar):
    text = bar.read_text()
    assert "--held is for frequencies" in call("info", bar, "--held", code=2)
    assert "it is the deck itself" in call("info", bar, "--json", bar, code=2)
    assert bar.read_text() == text


CASE = """
title = "a bar"
[[body]]
name = "bar"
mesh = "bar.inp"
abaqus = {{ {options} }}
frame = {{ kind = "nodal-fixed", interface = "root" }}
reduction = {{ basis = "none" }}
[[body.interface]]
name = "root"
nodes = "ROOT"
[[joint]]
kind = "fixed"
first = "ground"
second = "bar.root"
[simulation]
duration = 0.01
step = 0.001
output_step = 0.01
"""


def test_a_body_of_a_case_is_made_of_a_deck(bar):
    case = bar.parent / "case.toml"
    case.write_text(CASE.format(options=""))
    (body,) = read_case(case).flexible.values()
    along = body.rigid_modes[:, 0]
    assert along @ (body.mass @ along) == pytest.approx(5.14)
    bar.write_text(BAR + "*ELEMENT, TYPE=GAPUNI, ELSET=G\n30, 1, 5\n")
    with pytest.raises(ModelError, match=r"not read and would change the body: 1 \*ELEMENT, TYPE=GAPUNI"):
        _ = read_case(case).flexible
    case.write_text(CASE.format(options='leave_out = ["*ELEMENT, TYPE=GAPUNI"]'))
    assert len(read_case(case).flexible) == 1


def test_superelements_are_reported_beside_the_whole(tmp_path):
    """Two bars of 0.5 m, each with grids and elements 1, 2, ..; the whole has the mass of both."""
    halves = [
        f"GRID,1,,{x},0.,0.\nGRID,2,,{x + 0.5},0.,0.\nCBAR,1,7,1,2,0.,0.,1.\nPBAR,7,5,4.-4,1.-8,1.-8,1.-8\n"
        "MAT1,5,2.1+11,,.3,7850.\n"
        for x in (0.0, 0.5)
    ]
    (tmp_path / "bars.bdf").write_text(
        f"BEGIN BULK\nBEGIN SUPER=1\n{halves[0]}BEGIN SUPER=2\n{halves[1]}ENDDATA\n"
    )
    result = CliRunner().invoke(app, ["info", str(tmp_path / "bars.bdf"), "--json", str(tmp_path / "a.json")])
    assert result.exit_code == 0
    assert "superelement super_2" in result.output
    found = json.loads((tmp_path / "a.json").read_text())
    assert (found["nodes"], found["elements"]) == (3, {"CBAR": 2})
    assert found["mass"] == pytest.approx(3.14)
    own = found["superelements"]["super_2"]
    assert (own["nodes"], own["mass"]) == (2, pytest.approx(1.57))
    assert own["centre"] == pytest.approx([0.75, 0, 0])
