"""`supple sweep` as a user types it: a file, job arrays, the status, and the exit codes."""

from __future__ import annotations

import re

import pytest
from typer.testing import CliRunner

from supple.cli.main import app


def call(*arguments, code=0):
    """Output of a command, its lines joined."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


@pytest.fixture
def cases(pendulum):
    """A sweep of four cases in two shares, one of them impossible."""
    path = pendulum.with_name("cases.toml")
    path.write_text(
        'case = "pendulum.toml"\n[vary]\n"body.bob.rigid.mass" = [1.0, 2.0, -3.0, 4.0]\n'
        "[output]\ncases_per_share = 2\n"
    )
    return path


def test_jobs_share_a_sweep_and_the_status_says_how_far_it_is(cases, tmp_path):
    folder = tmp_path / "out"
    first = call("sweep", cases, "-o", folder, "--share", "1/2")
    assert "4 cases in 2 shares, one group of bodies and runs" in first
    assert "4 cases: 2 ran, 0 failed, 0 killed their process, 2 to do" in first
    assert "2 to do" in call("sweep", "status", folder, code=4)
    assert not (folder / "sweep.html").exists()
    second = call("sweep", cases, "-o", folder, "--share", "2/2", code=3)
    assert (folder / "sweep.html").exists()
    assert "Cases without results" in second
    assert "mass" in second
    assert "3 ran, 1 failed" in call("sweep", "status", folder, code=3)
    cases.write_text(cases.read_text().replace("4.0]", "5.0]"))
    assert "replace it with --force" in call("sweep", cases, "-o", folder, "--share", "1/2", code=2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--share", "3/2"], "such as 3/40"),
        (["--share", "half"], "such as 3/40"),
        (["--workers", "2", "--cluster", "tcp://host:1"], "give one of them"),
        (["--workers", "2", "--share", "1/2"], "without --workers, --cluster and --mpi"),
        (["--force", "--share", "1/2"], "then start all jobs without --force"),
    ],
)
def test_options_that_do_not_fit_are_refused(cases, tmp_path, options, message):
    assert message in call("sweep", cases, "-o", tmp_path / "out", *options, code=2)
    assert not (tmp_path / "out").exists()


def test_a_stopped_sweep_names_the_command_that_keeps_its_cases(cases, tmp_path, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("supple.cli.sweep.run_sweep", stopped)
    command = ("sweep", cases, "-o", tmp_path / "out")
    assert "the same command runs the rest" in call(*command, code=130)
    assert "the same command without --force runs the rest" in call(*command, "--force", code=130)


@pytest.mark.slow
def test_the_page_has_as_many_reports_as_it_is_asked_for(cases, tmp_path):
    folder = tmp_path / "out"
    call("sweep", cases, "-o", folder, "--share", "1/1", code=3)
    (folder / "sweep.html").unlink()
    assert "The page is" in call("sweep", "page", folder, "--reports", "1")
    (report,) = (folder / "cases").iterdir()
    assert f"cases/{report.name}" in (folder / "sweep.html").read_text(encoding="utf-8")


def test_a_folder_without_a_sweep_is_named(tmp_path):
    assert "has no sweep" in call("sweep", "status", tmp_path, code=2)
    assert "sweep CASES.toml -o FOLDER" in call("sweep", "--help")
