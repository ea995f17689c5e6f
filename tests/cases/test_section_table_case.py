"""Section tables in case files: a line without a mesh, and the mistakes."""

import re

import numpy as np
import pytest
from fixtures.section_tables import prismatic
from typer.testing import CliRunner

from supple.cases import read_case, run_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.importers import write_section_csv
from supple.methods.intrinsic import CLAMPED, IntrinsicBody, intrinsic_modes, section_line

CASE = """\
title = "blade"

[[body]]
name = "blade"
section_table = "blade.csv"
condense = { root = "flange", tip = "end", stations = 9, modes = 20 }
damping = { kind = "modal", ratio = 0.5 }

[[body.interface]]
name = "flange"

[[body.interface]]
name = "middle"
node_indices = [4]

[[body.interface]]
name = "end"

[[joint]]
name = "hub"
kind = "fixed"
first = "ground"
second = "blade.flange"

[[load]]
kind = "force"
at = "blade.end"
vector = [0.0, 2.0, 0.0]

[simulation]
duration = 1.0
output_step = 0.25
step = 0.01

[output]
track = ["blade.end", "blade.middle"]
pictures = false
animation = false
report = false
"""


@pytest.fixture
def blade(tmp_path):
    def write(*changes):
        write_section_csv(prismatic(n=9), tmp_path / "blade.csv")
        text = CASE
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "case.toml"
        path.write_text(text)
        return path

    return write


def test_the_body_is_the_line_of_its_sections(blade):
    (placed,) = read_case(blade()).system.bodies
    body = placed.body
    assert isinstance(body, IntrinsicBody)
    line = section_line("blade", prismatic(), 9)
    exact = intrinsic_modes(line, CLAMPED).frequencies
    assert body.modes.frequencies[:20] == pytest.approx(exact[:20], rel=1e-6)
    assert {"flange": 0, "middle": 4, "end": 8}.items() <= dict(body.stations).items()


def test_it_is_drawn_as_beams_between_its_stations(blade):
    case = read_case(blade())
    drawn = case.drawn["blade"]
    np.testing.assert_allclose(drawn.mesh.nodes, case.system.bodies[0].body.nodes, atol=1e-12)
    (cells,) = drawn.mesh.cells.values()
    assert len(cells) == 8
    assert case.exported_meshes["blade"] is drawn.mesh
    assert not case.meshes
    with pytest.raises(CaseError, match="no body with elements to colour"):
        _ = read_case(blade(("pictures = false", 'colour = "von-mises"'))).system


@pytest.mark.slow
def test_it_comes_to_rest_where_its_flexibility_says(blade, tmp_path):
    result = run_case(read_case(blade()), tmp_path / "out", errors=False)
    line = section_line("blade", prismatic(), 9)
    load = np.zeros(6 * 8)
    load[-5] = 2.0
    rest = np.linalg.solve(line.stiffness[6:, 6:], load).reshape(8, 6)
    for place, station in (("blade.end", 8), ("blade.middle", 4)):
        found = result.tracked[place].deflection[-1]
        assert found == pytest.approx(rest[station - 1, :3], abs=1e-3 * np.abs(rest).max())


@pytest.mark.slow
def test_without_condense_it_is_a_chain_of_beams(blade, tmp_path):
    """In a floating frame; at rest where the line is."""
    path = blade(
        (CASE[CASE.index("condense") : CASE.index("damping")], 'frame = {kind = "mean-axis"}\n'),
        (
            "frame",
            'reduction = {basis = "craig-bampton", modes = 8, derivatives = {kind = "compressed", '
            "number = 4}}\nframe",
        ),
        ('name = "flange"', 'name = "flange"\nnodes = "root"'),
        ('name = "end"', 'name = "end"\nnodes = "tip"'),
        ("step = 0.01", 'step = 0.01\nstart = "equilibrium"'),
    )
    result = run_case(read_case(path), tmp_path / "out", errors=False)
    line = section_line("blade", prismatic(), 9)
    rest = np.linalg.solve(line.stiffness[6:, 6:], np.eye(48)[43] * 2.0).reshape(8, 6)
    for place, station in (("blade.end", 8), ("blade.middle", 4)):
        found = result.tracked[place].deflection[-1]
        assert found == pytest.approx(rest[station - 1, :3], abs=1e-2 * np.abs(rest).max())


def test_a_table_in_si_belongs_to_a_case_in_si(blade, tmp_path):
    """A CSV file has the units of the case."""
    units = 'units = { length = "mm", time = "s", force = "N" }\n\n[[body]]'
    assert read_case(blade(("[[body]]", units))).units.mass == "t"
    for suffix in ("dat", "yaml"):
        (tmp_path / f"blade.{suffix}").write_text("")
        path = blade(("[[body]]", units), ("blade.csv", f"blade.{suffix}"))
        with pytest.raises(CaseError, match="files are in m, kg and s, and units of the case mm, t: "):
            read_case(path)
        path.write_text(path.read_text().replace('"mm"', '"m"'))
        assert read_case(path).units.mass == "kg"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "said"), [("check", "9 stations, mass 12;"), ("info", "section_table"), ("static", "Stable")]
)
def test_commands_take_it(blade, command, said, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, [command, str(blade())])
    assert result.exit_code == 0
    assert said in " ".join(result.output.split())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("condense = {", "# condense = {", "a section_table body needs frame"),
        ("condense = {", "frame = { kind = 'mean-axis' } #", "an interface needs one of nodes"),
        ('"blade.csv"', '"case.toml"', "'case.toml' is not a section table: give one of .csv, .yaml"),
        ("stations = 9, ", "", "a body of a section table needs stations here"),
        ("stations = 9", "paths = [[1, 2]], stations = 9", "a body of a section table takes no paths"),
        (
            "node_indices = [4]",
            "node_indices = [9]",
            "station 9 does not exist: give one from 0 (the root) to 8",
        ),
        (
            "node_indices = [4]",
            "",
            "an interface between the ends is one station: give node_indices = [NUMBER]",
        ),
        ("node_indices = [4]", 'node_indices = [4]\nnodes = "x"', "is a station and takes no nodes"),
        ('name = "end"\n', 'name = "end"\nnode_indices = [8]\n', "'end' is an end of the line; remove"),
        ("condense = {", 'mesh = "blade.csv"\ncondense = {', "a section_table body takes no mesh"),
        ('"blade.csv"', '"none.csv"', "there is no file"),
    ],
)
def test_mistakes_are_named(blade, old, new, message):
    with pytest.raises(CaseError, match=re.escape(message)):
        read_case(blade((old, new)))
