"""`supple static` and `supple modes`: equilibria and modes of case files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cli.main import app

BOB = """
title = "a bob on a rod"
gravity = [0.0, 0.0, -9.81]
units = { length = "m", mass = "kg", time = "s" }

[[body]]
name = "bob"
rigid = { mass = 2.0, inertia = [[0.05, 0, 0], [0, 0.05, 0], [0, 0, 0.05]] }
position = [0.6, 0.0, -0.8]

[[body.interface]]
name = "top"
position = [-0.6, 0.0, 0.8]

[[joint]]
name = "pivot"
kind = "ball"
first = "ground"
second = "bob.top"

SPIN
[simulation]
duration = 1.0
output_step = 0.1
step = 0.01
START

[output]
track = ["bob.top"]
animation = false
"""


@pytest.fixture
def run(tmp_path):
    def of(*arguments, spin="", start=""):
        case = tmp_path / "bob.toml"
        case.write_text(BOB.replace("SPIN", spin).replace("START", start))
        command = [arguments[0], str(case), "-o", str(tmp_path / "out"), *arguments[1:]]
        return CliRunner().invoke(app, command), tmp_path / "out"

    return of


@pytest.mark.slow
def test_a_pendulum_hangs_and_swings(run):
    result, folder = run("static")
    assert result.exit_code == 0, result.output
    numbers = json.loads((folder / "bob-static.json").read_text())
    assert np.linalg.norm(numbers["joints"]["pivot"]["last force"]) == pytest.approx(19.62, rel=1e-9)
    assert (folder / "bob-static.png").exists()
    result, folder = run("modes", "-n", "3")
    assert result.exit_code == 0, result.output
    modes = json.loads((folder / "bob-modes.json").read_text())["modes"]
    swing = np.sqrt(9.81 / (1 + 0.05 / 2)) / (2 * np.pi)
    assert [mode["frequency"] for mode in modes] == pytest.approx([0.0, swing, swing], abs=1e-8)


def test_a_conical_pendulum_rises_with_its_spin(run):
    """`cos a = g / l w^2`, tension `m w^2 l`: a ball's angular momentum about its centre does not change."""
    result, folder = run("static", spin="[spin]\nrate = 4.0\naxis = [0, 0, 1]\n")
    assert result.exit_code == 0, result.output
    numbers = json.loads((folder / "bob-static.json").read_text())
    force = np.linalg.norm(numbers["joints"]["pivot"]["last force"])
    assert force == pytest.approx(2.0 * 16.0, rel=1e-8)
    result, folder = run("modes", "--rates", "4:6:3", spin="[spin]\nrate = 4.0\naxis = [0, 0, 1]\n")
    assert result.exit_code == 0, result.output
    diagram = json.loads((folder / "bob-campbell.json").read_text())
    assert diagram["rates"] == [4.0, 5.0, 6.0]
    assert (folder / "bob-campbell.png").exists()


def test_a_run_from_the_equilibrium_does_not_swing(run):
    """The bob is placed aside; where its run starts in equilibrium it hangs."""
    result, folder = run("run", "--no-errors", spin="", start='start = "equilibrium"')
    assert result.exit_code == 0, result.output
    tracked = json.loads((folder / "bob.json").read_text())["joints"]["pivot"]
    assert tracked["largest force"] == pytest.approx(19.62, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "spin", "message"),
    [
        (("modes", "--rates", "0:2"), "", "FROM:TO:NUMBER"),
        (("modes", "--rates", "0:2:3"), "", "needs a spin"),
        (("static",), "[spin]\nrate = 1.0\naxis = [0, 0, 0]\n", "length zero"),
        (("static",), "[spin]\nrate = 1.0\naxis = [0, 0, 1]\nbodies = ['bop']\n", "there is no body 'bop'"),
    ],
)
def test_mistakes_are_named(run, arguments, spin, message):
    result, _ = run(*arguments, spin=spin)
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())
