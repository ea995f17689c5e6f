"""What a command writes is never what its case reads, and no two of its files are one."""

from __future__ import annotations

import pytest
from fixtures.bar_case import MOTOR, bar_case
from typer.testing import CliRunner

from supple.cases import read_case, run_case
from supple.cli.main import app
from supple.errors import CaseError
from supple.storage import read_reduced_body, write_reduced_body


def refused(*arguments):
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.exit_code == 2
    return done.output.replace("\n", "")


def test_a_case_named_as_the_file_of_its_body(case_folder):
    path = (case_folder / "strip.toml").rename(case_folder / "strip-reduced.toml")
    with pytest.raises(CaseError, match=r"file of body 'strip' would both be .*strip-reduced\.h5"):
        run_case(read_case(path), case_folder / "out")


@pytest.mark.parametrize("command", ["run", "reduce"])
def test_a_body_made_here_never_replaces_one_that_is_read(case_folder, linear, command):
    """Body 'other' is read from the file that body 'strip' would be kept in."""
    kept = write_reduced_body(case_folder / "strip-reduced.h5", linear)
    path = case_folder / "strip.toml"
    other = '[[body]]\nname = "other"\nreduced = "strip-reduced.h5"\n\n[simulation]'
    path.write_text(path.read_text().replace("[simulation]", other))
    said = refused(command, path, "-o", case_folder)
    assert f"cannot write {kept}: it is an input of {path} and would be lost" in said, said
    assert read_reduced_body(kept).stiffness.tobytes() == linear.stiffness.tobytes()


def test_a_deck_never_replaces_the_mesh(case_folder):
    mesh = (case_folder / "strip.inp").read_bytes()
    assert "it is an input of" in refused(
        "export", case_folder / "strip.toml", "-o", case_folder / "strip.inp"
    )
    assert (case_folder / "strip.inp").read_bytes() == mesh


def test_a_table_that_is_named_as_the_report_is(tmp_path):
    """Not even --force replaces what is read."""
    (tmp_path / "bar.toml").write_text(
        bar_case(0.2, 0.1, 0.1, joint=MOTOR.replace("angle.csv", "bar.json")), encoding="utf-8"
    )
    (tmp_path / "bar.json").write_text("0,0\n1,1\n", encoding="utf-8")
    with pytest.raises(CaseError, match=r"cannot write .*bar\.json: it is an input of .*"):
        run_case(read_case(tmp_path / "bar.toml"), tmp_path, force=True)
    assert (tmp_path / "bar.json").read_text(encoding="utf-8") == "0,0\n1,1\n"
