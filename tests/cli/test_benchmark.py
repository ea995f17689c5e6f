"""`supple benchmark` finds its commands by entry point and loads only the one asked for."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest
from typer.testing import CliRunner

from supple.cli import benchmark
from supple.cli.benchmark import GROUP
from supple.cli.main import app

PUBLISHED = ("blade", "eigenvalue-error", "quadruple-pendulum", "rotating-beam", "slider-crank")


def call(*arguments):
    return CliRunner().invoke(app, ["benchmark", *arguments])


@pytest.fixture
def offered(monkeypatch):
    """Entry points as if packages had been installed that offer them; one of them cannot be loaded."""
    points = [
        EntryPoint("here", f"{__name__}:here", GROUP),
        EntryPoint("away", "no_such_package:away", GROUP),
    ]
    monkeypatch.setattr(benchmark, "entry_points", lambda group: points if group == GROUP else [])


def here(times: int = 1) -> None:
    """A benchmark of one's own."""
    print("ran " * times)


def test_published_benchmarks_are_listed_with_the_first_line_of_their_help():
    printed = call("--help").output
    for name in PUBLISHED:
        assert name in printed
    assert "The 61.5 m blade of [Wu2019]" in printed


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_published_benchmark_says_its_options(name):
    result = call(name, "--help")
    assert result.exit_code == 0
    for option in ("--quick", "--json", "--output", "--debug"):
        assert option in result.output


def test_another_packages_benchmark_runs_although_one_beside_it_is_broken(offered):
    assert "ran ran" in call("here", "--times", "2").output
    assert isinstance(call("away").exception, ModuleNotFoundError)


def test_a_name_of_two_benchmarks_is_refused(monkeypatch):
    """Whichever came last would run, and its numbers would pass for those of the other."""
    values = (f"{__name__}:here", "other_package:here")
    points = [EntryPoint("here", value, GROUP) for value in values]
    monkeypatch.setattr(benchmark, "entry_points", lambda group: points if group == GROUP else [])
    result = call("here")
    assert result.exit_code == 2
    assert f"several packages have a benchmark 'here': {values[0]} and {values[1]}" in " ".join(
        result.output.split()
    )


def test_unknown_benchmark_is_refused():
    result = call("blad")
    assert result.exit_code == 2
    assert "No such command 'blad'" in result.output
