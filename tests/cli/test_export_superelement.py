"""`supple export` of a reduced body for other programs."""

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cli.main import app
from supple.export import interface_form, write_beamdyn
from supple.importers import SectionTable, read_section_table
from supple.storage import read_reduced_body


def exported(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


@pytest.fixture(scope="module")
def strip_file(tmp_path_factory):
    """The strip of the case, reduced once and kept in its own file."""
    from fixtures.strip_case import filled

    folder = filled(tmp_path_factory.mktemp("strip"))
    result = CliRunner().invoke(app, ["reduce", str(folder / "strip.toml"), "-o", str(folder)])
    assert result.exit_code == 0, result.output
    return folder / "strip-reduced.h5"


MARKS = {
    "x.op4": "1P,3E24.16",
    "x.pch": "DMIG    KAAX",
    "x.dmig": "QSET1",
    "x.sid": "new modal",
    "x.fem": "** RECORD GROUP 18",
}


@pytest.mark.parametrize("name", MARKS)
def test_a_reduced_body_is_written_by_the_ending_with_its_frequencies(strip_file, tmp_path, name):
    result = exported(strip_file, "-o", tmp_path / name)
    assert result.exit_code == 0, result.output
    assert MARKS[name] in (tmp_path / name).read_text()
    body = read_reduced_body(strip_file)
    in_its_frame = name in ("x.sid", "x.fem")
    held = body.frequencies / (2 * np.pi) if in_its_frame else interface_form(body).frequencies(["root"])
    assert f"{held[0]:.6g}" in result.output
    assert ("the linear part" in result.output) == (name != "x.sid")


def test_the_units_of_a_case_are_printed(strip_file, tmp_path):
    case = strip_file.parent / "strip.toml"
    in_mm = strip_file.parent / "in_mm.toml"
    in_mm.write_text('units = { length = "mm", mass = "t", time = "s" }\n' + case.read_text())
    for name, expected in (
        ("x.sid", "mm, t, s; Modelica reads m, kg, s"),
        ("x.op4", "units of the case: mm, t, s\n"),
    ):
        result = exported(in_mm, "-o", tmp_path / name)
        assert result.exit_code == 0, result.output
        assert expected in result.output


def test_a_deck_with_the_superelement_is_for_calculix_or_abaqus(strip_file, tmp_path):
    for arguments, mark in (((), "*EQUATION"), (("--abaqus",), "*MATRIX ASSEMBLE")):
        result = exported(strip_file, "-o", tmp_path / "x.inp", "--superelement", *arguments)
        assert result.exit_code == 0, result.output
        assert mark in (tmp_path / "x.inp").read_text()


def test_a_model_with_the_name_of_the_cards_is_not_replaced(strip_file, tmp_path):
    (tmp_path / "arm.bdf").write_text("GRID,1\n")
    refused = exported(strip_file, "-o", tmp_path / "arm.op4")
    assert "arm.bdf: the file exists, was not written by this export" in " ".join(refused.output.split())
    assert (tmp_path / "arm.bdf").read_text() == "GRID,1\n"
    assert not (tmp_path / "arm.op4").exists()
    for _ in range(2):  # its own cards are replaced
        assert exported(strip_file, "-o", tmp_path / "x.op4").exit_code == 0


def test_the_parts_of_a_split_body_are_written_by_their_names(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace("damping =", "split = { parts = 2 }\ndamping =", 1))
    refused = exported(case, "-o", tmp_path / "x.pch", "--body", "strip")
    said = "split divides body 'strip' into strip-1, strip-2; give one of these parts, or remove split"
    assert said in " ".join(refused.output.split())
    assert exported(case, "-o", tmp_path / "x.pch", "--body", "strip-1").exit_code == 0


def test_exudyn_takes_the_linear_part(strip_file, tmp_path):
    assert exported(strip_file, "-o", tmp_path / "x.npz").exit_code == 0
    with np.load(tmp_path / "x.npz", allow_pickle=True) as file:
        np.testing.assert_array_equal(file["stiffnessMatrixReduced"], read_reduced_body(strip_file).stiffness)


def test_what_cannot_be_written_is_refused(strip_file, tmp_path):
    for name, arguments, message in (
        ("x.mnf", (), "MNF is a closed format of Adams; write .op4 or .pch"),
        ("x.dat", (), "give the case file for .dat"),
        ("x.op4", ("--superelement",), "--superelement is for a deck (.inp)"),
        ("x.op4", ("--times", "0:1:3"), "is not for a superelement: remove it (its options: --body)"),
        ("x.op4", ("--body", "other"), "contains the body 'strip' alone: remove --body"),
        ("x.op4", ("--abaqus",), "--abaqus is not for a superelement"),
        ("x.inp", ("--superelement", "--time", "1"), "--time is not for a deck with a superelement"),
    ):
        result = exported(strip_file, "-o", tmp_path / name, *arguments)
        assert result.exit_code != 0
        assert message in " ".join(result.output.split())
        assert not (tmp_path / name).exists()


def test_of_a_case_the_interface_that_no_joint_holds_is_where_a_tower_begins(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    text = case.read_text()
    tip = '[[body.interface]]\nname = "top"\nnodes = "TIP"\n\n[[joint]]'
    case.write_text(
        text.replace("[[joint]]", tip).replace('"rubin", modes = 4', '"craig-bampton", modes = 4')
    )
    result = exported(case, "-o", tmp_path / "x.dat")
    assert result.exit_code == 0, result.output
    assert "at top, all other interfaces clamped" in (tmp_path / "x.dat").read_text()
    upright = case.read_text()
    case.write_text('units = { length = "mm", mass = "t", time = "s" }\n' + upright)
    small = exported(case, "-o", tmp_path / "y.dat")
    assert "units of the case are mm, t, s, and OpenFAST reads m, kg, s" in " ".join(small.output.split())
    case.write_text(upright.replace('name = "strip"\n', 'name = "strip"\nrotation = [0, -1.57, 0]\n', 1))
    lying = exported(case, "-o", tmp_path / "y.dat")
    assert "mesh axes of body 'strip', and ExtPtfm needs z upwards" in " ".join(lying.output.split())
    case.write_text(text)
    refused = exported(case, "-o", tmp_path / "y.dat")
    assert "0 interfaces of 'strip' are not joined to the ground" in " ".join(refused.output.split())
    unknown = exported(case, "-o", tmp_path / "y.op4", "--body", "strap")
    assert "'strap' is none of the reduced bodies; did you mean 'strip'" in " ".join(unknown.output.split())


def test_bushings_to_the_ground_are_in_the_superelement_of_a_pile(case_folder, tmp_path):
    """A push along the axis of the body, which lies along y: the bushing's 2 kN/m, and the bar's 210 MN/m."""
    case = case_folder / "strip.toml"
    top = '[[body.interface]]\nname = "top"\nnodes = "TIP"\n\n[[element]]'
    soil = 'kind = "bushing"\nstiffness = [1e3, 2e3, 4e3, 1e2, 1e2, 1e2]\ndamping = [0, 0, 0, 0, 0, 0]'
    text = case.read_text().replace("[[joint]]", top).replace('kind = "fixed"', soil)
    text = text.replace('"rubin", modes = 4', '"craig-bampton", modes = 4')
    turned = 'name = "strip"\nrotation = [0, 0, 1.5707963267948966]\n'
    case.write_text(text.replace('name = "strip"\n', turned, 1))
    result = exported(case, "-o", tmp_path / "x.dat")
    assert result.exit_code == 0, result.output
    assert "root on springs" in " ".join(result.output.split())
    lines = (tmp_path / "x.dat").read_text().splitlines()
    first = lines.index("!Stiffness Matrix") + 2
    stiffness = np.array([row.split()[:6] for row in lines[first : first + 6]], dtype=float)
    assert np.linalg.inv(stiffness)[0, 0] == pytest.approx(1 / 2e3 + 1 / 2.1e8, rel=1e-6)


BLADE = """\
title = "blade"

[[body]]
name = "blade"
section_table = "given.dat"
condense = { root = "root", tip = "tip", stations = 9 }

[[body.interface]]
name = "root"

[[body.interface]]
name = "tip"

[[joint]]
kind = "fixed"
first = "ground"
second = "blade.root"

[simulation]
duration = 0.1
output_step = 0.01
step = 0.01
"""


def test_a_body_of_sections_is_written_for_beamdyn(tmp_path):
    """Sections along z, in the case from BeamDyn's own files: written and read back alike."""
    s = np.linspace(0.0, 1.0, 6)
    stiffness = np.array([np.diag([1e8, 1.2e8, 3e9, 4e8, 2e8, 1e8]) * (1.2 - k) for k in s])
    inertia = np.array([np.diag([50.0, 50.0, 50.0, 8.0, 4.0, 12.0]) * (1.2 - k) for k in s])
    places = np.column_stack([0 * s, 0 * s, 20.0 * s])
    table = SectionTable(places, np.tile(np.eye(3), (6, 1, 1)), stiffness, inertia)
    write_beamdyn(tmp_path / "given.dat", table)
    (tmp_path / "blade.toml").write_text(BLADE)
    result = exported(tmp_path / "blade.toml", "-o", tmp_path / "again.dat")
    assert result.exit_code == 0, result.output
    assert "frequencies for comparison, on its support" in (tmp_path / "again_blade.dat").read_text()
    first, second = (read_section_table(tmp_path / f"{name}.dat") for name in ("given", "again"))
    for name in ("positions", "axes", "stiffness", "inertia"):
        mine, its = getattr(first, name), getattr(second, name)
        np.testing.assert_allclose(its, mine, rtol=1e-9, atol=1e-9 * abs(mine).max())


@pytest.mark.parametrize(
    ("damping", "said", "written"),
    [
        ('kind = "rayleigh", alpha = 0.0, beta = 0.003', "written to", ["1", *["0.003"] * 6]),
        ('kind = "rayleigh", alpha = 0.1, beta = 0.003', "no damping was written", ["0", *["0"] * 6]),
        ('kind = "modal", ratio = 0.01', "no damping was written", ["0", *["0"] * 6]),
    ],
)
def test_damping_by_strain_rate_is_that_of_beamdyn(tmp_path, damping, said, written):
    """BeamDyn's mu is the ratio of damping to stiffness of each strain, in s."""
    stiffness = np.diag([1e9, 1e9, 1e10, 2e8, 2e8, 1e8])[None].repeat(3, axis=0)
    inertia = np.diag([50.0, 50.0, 50.0, 0.5, 0.5, 1.0])[None].repeat(3, axis=0)
    places = np.linspace(0, 1, 3)[:, None] * np.array([0, 0, 20.0])
    table = SectionTable(places, np.tile(np.eye(3), (3, 1, 1)), stiffness, inertia)
    write_beamdyn(tmp_path / "given.dat", table)
    case = BLADE.replace("stations = 9 }", f"stations = 9 }}\ndamping = {{ {damping} }}")
    (tmp_path / "blade.toml").write_text(case)
    result = exported(tmp_path / "blade.toml", "-o", tmp_path / "again.dat")
    assert said in " ".join(result.output.split())
    lines = (tmp_path / "again_blade.dat").read_text().splitlines()
    kind = next(k for k, line in enumerate(lines) if "damp_type" in line)
    assert [lines[kind].split()[0], *lines[kind + 4].split()] == written


def test_the_blade_file_of_the_case_is_not_replaced(tmp_path):
    """BeamDyn's primary file names its blade file: the target may be new and the file beside it not."""
    one = np.eye(6)[None].repeat(3, axis=0)
    places = np.linspace(0, 1, 3)[:, None] * np.array([0, 0, 20.0])
    write_beamdyn(tmp_path / "other.dat", SectionTable(places, np.tile(np.eye(3), (3, 1, 1)), one, one))
    (tmp_path / "other.dat").rename(tmp_path / "given.dat")
    before = (tmp_path / "other_blade.dat").read_text()
    (tmp_path / "blade.toml").write_text(BLADE)
    refused = exported(tmp_path / "blade.toml", "-o", tmp_path / "other.dat")
    assert "other_blade.dat: it is an input of" in " ".join(refused.output.split())
    assert (tmp_path / "other_blade.dat").read_text() == before


def test_the_frequencies_of_a_released_blade_are_those_on_its_support(tmp_path):
    """A uniform cantilever, which BeamDyn clamps: beta^2 sqrt(EI / m) / L^2, almost without shear."""
    places = np.linspace(0, 1, 4)[:, None] * np.array([0, 0, 20.0])
    stiffness = np.diag([1e9, 1e9, 1e10, 2e8, 2e8, 1e8])[None].repeat(4, axis=0)
    inertia = np.diag([50.0, 50.0, 50.0, 0.5, 0.5, 1.0])[None].repeat(4, axis=0)
    table = SectionTable(places, np.tile(np.eye(3), (4, 1, 1)), stiffness, inertia)
    write_beamdyn(tmp_path / "given.dat", table)
    (tmp_path / "blade.toml").write_text(BLADE.replace("stations = 9", "stations = 9, released = true"))
    result = exported(tmp_path / "blade.toml", "-o", tmp_path / "again.dat")
    title = (tmp_path / "again_blade.dat").read_text().splitlines()[1]
    first = float(title.rpartition(": ")[2].split(",")[0])
    assert "on its support" in title, result.output
    assert first == pytest.approx(1.8751**2 * np.sqrt(2e8 / 50.0) / 20.0**2 / (2 * np.pi), rel=0.02)
