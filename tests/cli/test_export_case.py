"""`supple export`: the static problem of a case as a deck."""

from __future__ import annotations

import numpy as np
from typer.testing import CliRunner

from supple.cli.main import app
from supple.importers import read_mesh
from supple.mesh import CellType

WEIGHT = 7850.0 * 1.0 * 0.1 * 0.01 * 9.81


def exported(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


def test_a_case_is_written_and_its_load_printed(case_folder, tmp_path):
    """The clamped strip under its weight, whose moment about the root is half its length away."""
    deck = tmp_path / "strip-static.inp"
    result = exported(case_folder / "strip.toml", "-o", deck, "--abaqus")
    assert result.exit_code == 0, result.output
    assert f"{-WEIGHT:.6g}" in result.output
    assert f"{WEIGHT / 2:.5g}" in result.output
    mesh, again = read_mesh(case_folder / "strip.inp"), read_mesh(deck)
    np.testing.assert_array_equal(again.cells[CellType.TRIANGLE3], mesh.cells[CellType.TRIANGLE3])
    np.testing.assert_array_equal(again.nodes_of("SUPPLE_CLAMPED"), np.sort(mesh.nodes_of("ROOT")))
    assert "for Abaqus" in result.output


def test_the_deck_of_a_split_body_is_that_of_the_whole(case_folder, tmp_path):
    """The split concerns frames, not the model."""
    case = case_folder / "strip.toml"
    whole = exported(case, "-o", tmp_path / "whole.inp")
    case.write_text(case.read_text().replace("damping =", "split = { parts = 2 }\ndamping =", 1))
    result = exported(case, "-o", tmp_path / "split.inp", "--body", "strip")
    assert (whole.exit_code, result.exit_code) == (0, 0), result.output
    assert (tmp_path / "split.inp").read_text() == (tmp_path / "whole.inp").read_text()


def test_without_a_word_the_deck_is_for_calculix(case_folder, tmp_path):
    deck = tmp_path / "strip-static.inp"
    result = exported(case_folder / "strip.toml", "-o", deck, "--body", "strip", "--time", "0.1")
    assert result.exit_code == 0, result.output
    assert "TYPE=S6" in deck.read_text()
    assert "t = 0.1" in result.output


def test_what_the_deck_leaves_out_is_printed(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    spring = (
        '\n[[spring]]\nkind = "straight"\nfirst = "ground"\nsecond = "strip.root"\nstiffness = 1e3\n'
        "free_length = 0.0\nanchor = [0.0, 0.0, 1.0]\n"
    )
    text = case.read_text()
    assert "without the case's" not in exported(case, "-o", tmp_path / "deck.inp").output
    case.write_text(text + spring + "\n[spin]\nrate = 1.0\naxis = [0, 0, 1]\n")
    result = exported(case, "-o", tmp_path / "deck.inp")
    assert "without the case's springs (1), steady rotation" in " ".join(result.output.split())


POST = """
[[body]]
name = "post"
rigid = { mass = 1.0, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }
position = [0.6, 0, -0.8]

[[body.interface]]
name = "eye"
position = [0, 0, 0]

[[joint]]
kind = "fixed"
first = "ground"
second = "post.eye"

[[joint]]
kind = "ball"
first = "post.eye"
second = "strip.tip"
"""


def test_the_weight_of_an_assembled_body_is_along_its_new_axes(case_folder, tmp_path):
    """Assembly turns the strip about y until its tip is at (0.6, 0, -0.8)."""
    case = case_folder / "strip.toml"
    text = case.read_text().replace("duration", "assemble = true\nduration")
    text = text.replace('kind = "fixed"', 'kind = "revolute"\naxis = [0, 1, 0]')
    tip = '[[body.interface]]\nname = "tip"\nnodes = "TIP"\n\n[[joint]]'
    case.write_text(text.replace("[[joint]]", tip, 1) + POST)
    result = exported(case, "-o", tmp_path / "deck.inp", "--body", "strip")
    assert result.exit_code == 0, result.output
    assert f"{0.8 * WEIGHT:.6g}" in result.output
    assert f"{-0.6 * WEIGHT:.6g}" in result.output


OTHER = """
[[body]]
name = "other"
rigid = { mass = 1.0, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }

[[body.interface]]
name = "eye"
position = [0, 0, 0]
"""


def refused(case, tmp_path, *arguments):
    result = exported(case, "-o", tmp_path / "deck.inp", *arguments)
    assert result.exit_code != 0
    assert not (tmp_path / "deck.inp").exists()
    return " ".join(result.output.split())


def test_a_body_that_is_not_there_is_refused(case_folder, tmp_path):
    message = refused(case_folder / "strip.toml", tmp_path, "--body", "strap")
    assert "'strap' is none of the bodies with elements; did you mean 'strip'?" in message


def test_a_name_with_brackets_is_no_markup(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    case.write_text(
        case.read_text()
        .replace('name = "strip"', 'name = "arm[/x]"')
        .replace('"strip.root"', '"arm[/x].root"')
        .replace('"strip.TIP", ', "")
    )
    result = exported(case, "-o", tmp_path / "deck.inp")
    assert result.exit_code == 0, result.output
    assert "arm[/x]" in result.output


def test_a_run_is_written_from_its_result(case_folder, tmp_path):
    for name in ("run.csv", "run.vtkhdf", "run.h5"):
        result = exported(case_folder / "strip.toml", "-o", tmp_path / name)
        assert result.exit_code == 2
        assert "Run the case, then export the result" in " ".join(result.output.split())


def test_a_body_that_no_joint_holds_is_refused(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace('"strip.root"\n\n[sim', '"other.eye"\n\n[sim') + OTHER)
    assert "no joint constrains body 'strip'" in refused(case, tmp_path)


def test_two_bodies_with_elements_want_a_name(case_folder, tmp_path):
    case = case_folder / "strip.toml"
    text = case.read_text()
    start, end = text.index("[[body]]"), text.index("[[joint]]")
    case.write_text(text + "\n" + text[start:end].replace('name = "strip"', 'name = "second"'))
    assert "2 bodies with elements (strip, second); give one: --body NAME" in refused(case, tmp_path)
