"""Condensed matrices of another program in case files: stations are grids, mistakes are named."""

import re

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight
from scipy.linalg import eigvalsh
from typer.testing import CliRunner

from supple.cases import read_case, run_case
from supple.cli.main import app
from supple.errors import CaseError, ModelError
from supple.export import write_dmig_punch
from supple.methods.intrinsic import CLAMPED, IntrinsicBody, intrinsic_modes

POINTS = straight(1.0, 6)
GRIDS = np.arange(11, 18)
CASE = """\
title = "wing"

[[body]]
name = "wing"
mesh = "wing.bdf"
matrices = { stiffness = "wing.pch", mass = "wing.pch" }
condense = { root = "base", paths = [[11, 12, 13, 14], [14, 15, 16, 17]] }
damping = { kind = "rayleigh", alpha = 6.0, beta = 0.0 }

[[body.interface]]
name = "base"
node_indices = [11]

[[body.interface]]
name = "engine"
node_indices = [14]

[[body.interface]]
name = "end"
node_indices = [17]

[[joint]]
name = "fuselage"
kind = "fixed"
first = "ground"
second = "wing.base"

[[load]]
kind = "force"
at = "wing.end"
vector = [0.0, 0.0, 5e-3]

[simulation]
duration = 5.0
output_step = 0.5
step = 0.02

[output]
track = ["wing.end", "wing.engine"]
pictures = false
animation = false
report = false
"""


@pytest.fixture(scope="module")
def line():
    return beam_line(POINTS, EA=1e3, EI=1.0, GJ=1.0, mass_per_length=1.3, radius=0.05)


@pytest.fixture
def wing(tmp_path, line):
    """Writes the case with changes; its matrices hold some of the grids."""

    def write(*changes, first=0):
        write_dmig_punch(
            tmp_path / "wing.pch",
            GRIDS[first:],
            6,
            KAAX=line.stiffness[6 * first :, 6 * first :],
            MAAX=line.mass[6 * first :, 6 * first :],
        )
        grids = [
            f"GRID,{grid},," + ",".join(f"{x:.6f}" for x in point)
            for grid, point in zip(GRIDS, POINTS, strict=True)
        ]
        sets = [f"ASET1,123456,{grid}" for grid in GRIDS[first:]]
        (tmp_path / "wing.bdf").write_text("\n".join(["BEGIN BULK", *grids, *sets, "ENDDATA"]) + "\n")
        text = CASE
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "wing.toml"
        path.write_text(text)
        return path

    return write


@pytest.mark.slow
def test_a_line_of_matrices_sags_as_a_cantilever(wing, tmp_path):
    """At rest, by P (3 L x^2 - x^3) / 6 EI; cubic beams are exact at their nodes."""
    result = run_case(read_case(wing()), tmp_path / "out", errors=False)
    for place, x in (("wing.end", 1.0), ("wing.engine", 0.5)):
        rest = 5e-3 * (3 * x**2 - x**3) / 6
        assert result.tracked[place].deflection[-1, 2] == pytest.approx(rest, rel=1e-3)


def test_matrices_are_beside_the_case_and_not_beside_the_grids(wing, line, tmp_path):
    case = wing(('"wing.bdf"', '"grids/wing.bdf"'))
    (tmp_path / "grids").mkdir()
    (tmp_path / "wing.bdf").rename(tmp_path / "grids" / "wing.bdf")
    doubled = {"KAAX": line.stiffness, "MAAX": 2 * line.mass}
    write_dmig_punch(tmp_path / "grids" / "wing.pch", GRIDS, 6, **doubled)  # of another model
    (placed,) = read_case(case).system.bodies
    assert placed.body.mass == pytest.approx(line.total_mass)


def test_a_root_that_was_clamped_gets_its_mass_back(wing, line):
    """Flying, the frequencies are those of the whole line."""
    row = "[" + ", ".join(["{:.17g}"] * 6) + "]"
    mass = ", ".join(row.format(*each) for each in line.mass[:6, :6])
    free = f'support = "free", root_mass = [{mass}], paths'
    joint = CASE[CASE.index("[[joint]]") : CASE.index("[[load]]")]
    (placed,) = read_case(wing(("paths", free), (joint, ""), first=1)).system.bodies
    assert isinstance(placed.body, IntrinsicBody)
    exact = np.sqrt(np.abs(eigvalsh(line.stiffness, line.mass))[6:])
    assert placed.body.modes.omega[6:] == pytest.approx(exact, rel=1e-5)
    assert placed.body.mass == pytest.approx(line.total_mass)


@pytest.mark.parametrize("condensed", ["paths", "released = true, paths"])
def test_the_check_of_a_case_tells_of_its_lines(wing, line, condensed):
    """A released line has the modes of the free one; the check gives those on its support all the same."""
    told = CliRunner().invoke(app, ["check", str(wing(("paths", condensed)))])
    assert told.exit_code == 0
    lowest = intrinsic_modes(line, CLAMPED).omega[0] / (2 * np.pi)
    output = " ".join(told.output.split())
    assert "condensed on 7 stations, mass 1.3;" in output
    assert f"lowest frequencies on its support {lowest:.4g}," in output


def test_faults_of_the_files_are_told_as_the_case_is_built(wing):
    with pytest.raises(ModelError, match=r"grid 17 of .* is on no load path"):
        _ = read_case(wing((", 17]]", "]]"), ("node_indices = [17]", "node_indices = [16]"))).system


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("paths = [[11, 12, 13, 14], [14, 15, 16, 17]]", 'tip = "end"', "needs paths = [[GRID, GRID, ..]]"),
        ("paths =", "stations = 7, paths =", "a body of matrices, condensed already, takes no stations"),
        ("[17]\n", "[18]\n", "grid 18 is on no load path"),
        ("[17]\n", "[16, 17]\n", "one station: give node_indices = [GRID]"),
        ("node_indices = [17]", 'node_indices = [17]\nkind = "averaging"', "and no kind"),
        ('root = "base"', 'root = "end"', "the root is the start of the paths, grid 11, not grid 17"),
        ('mass = "wing.pch"', 'mass = "wing.pch", rigid_tolerance = 1e-3', "are removed; remove the key"),
        ('mass = "wing.pch"', 'mass = "wing.pch", damping = "wing.pch"', "takes no damping matrix"),
        (
            'mass = "wing.pch"',
            'mass = "wing.pch", recovery = "wing.pch"',
            "has no points inside",
        ),
        (
            'mesh = "wing.bdf"\nmatrices = {',
            'superelement = { nodes = "wing.bdf", dofs_per_node = 6,',
            "the rows of a superelement have no grid labels: give a matrices body",
        ),
        (
            'matrices = { stiffness = "wing.pch", mass = "wing.pch" }',
            "nastran = {}",
            "a body of elements takes no paths; remove the key",
        ),
    ],
)
def test_mistakes_are_named(wing, old, new, message):
    path = wing((old, new))
    with pytest.raises(CaseError, match=re.escape(message)):
        read_case(path)
