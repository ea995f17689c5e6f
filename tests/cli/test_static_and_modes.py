"""`supple static` and `supple modes`: equilibria and modes of case files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from fixtures.abaqus_text import abaqus_text
from typer.testing import CliRunner

from supple.body import FullBody
from supple.cases import read_case
from supple.cases.static_case import starting_system
from supple.cli.main import app
from supple.mesh import strip

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
    assert [mode["error"] for mode in modes] == [0.0] * 3  # a rigid body has no basis
    # Of 2 kg, m l^2 / (m l^2 + J) swings; the spin about the rod moves no mass.
    masses = np.sum([mode["effective_mass"] for mode in modes], axis=0)
    assert masses[:3] == pytest.approx([2 / 1.025, 2 / 1.025, 0.0], abs=1e-8)
    assert "Effective masses, of 2 kg" in result.output
    assert "1.9512 (97.6 %)" in result.output


@pytest.mark.slow
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


@pytest.mark.slow
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
        (("modes", "--rates", "0:2:3", "--time", "5"), "", "--time is for the modes at one speed"),
        (("static",), "[spin]\nrate = 1.0\naxis = [0, 0, 0]\n", "length zero"),
        (("static",), "[spin]\nrate = 1.0\naxis = [0, 0, 1]\nbodies = ['bop']\n", "there is no body 'bop'"),
    ],
)
def test_mistakes_are_named(run, arguments, spin, message):
    result, _ = run(*arguments, spin=spin)
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())


PLAIN = """\
pictures = false
report = false"""

STRIP = """
title = "a strip that turns"
units = { length = "m", mass = "kg", time = "s", force = "N" }

[[body]]
name = "strip"
mesh = "strip.inp"
shell = { thickness = 0.01, youngs_modulus = 1e9, poissons_ratio = 0.0, density = 1000.0 }
frame = FRAME
REDUCTION

[[body.interface]]
name = "root"
nodes = "ROOT"

[[joint]]
name = "hub"
kind = "prescribed-rotation"
first = "ground"
second = "strip.root"
axis = [0.0, 0.0, 1.0]
law = { kind = "constant", value = 0.0 }

[spin]
rate = RATE
axis = [0.0, 0.0, 1.0]

[simulation]
duration = 1.0
output_step = 0.1
step = 0.01

[output]
track = ["strip.TIP"]
animation = false
PICTURES
"""
AT_ROOT = '{ kind = "nodal-fixed", interface = "root" }'
UNIT = np.sqrt(1e9 * 0.01**2 / 12 / 1000.0)
RATE = 6.0 * UNIT
STRETCH = 1000.0 * RATE**2 / (3 * 1e9)


@pytest.fixture
def strip_run(tmp_path):
    def of(command, reduction="", frame=AT_ROOT, pictures=False):
        (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 8, 2)))
        case = tmp_path / "strip.toml"
        drawn = PLAIN.replace("false", str(pictures).lower())
        case.write_text(
            STRIP.replace("REDUCTION", reduction)
            .replace("PICTURES", drawn)
            .replace("FRAME", frame)
            .replace("RATE", repr(float(RATE)))
        )
        out = tmp_path / "out"
        result = CliRunner().invoke(app, [command, str(case), "-o", str(out)])
        assert result.exit_code == 0, result.output
        return json.loads((out / f"strip-{command}.json").read_text()), result.output, out

    return of


@pytest.mark.slow
def test_a_rest_reaches_its_accuracy_where_no_size_is_given(strip_run):
    """Five bending modes to begin with hold no stretch; the default accuracy is a thousandth."""
    numbers, output, _ = strip_run("static")
    x = numbers["tracked"]["strip.TIP"]["last position"][0]
    assert x - 1.0 == pytest.approx(STRETCH, rel=5e-3)
    assert numbers["errors"]["strip"]["rms"] < 1e-3 * STRETCH
    assert numbers["stable"] is True
    assert "Error of the basis at rest" in output


def test_a_rest_of_fixed_size_says_what_it_misses(strip_run):
    reduction = 'reduction = { basis = "craig-bampton", modes = 3, steady = false }'
    numbers, output, _ = strip_run("static", reduction)
    assert "warning: body 'strip': at rest a node is off by" in " ".join(output.split())
    missing = numbers["errors"]["strip"]
    x = numbers["tracked"]["strip.TIP"]["last position"][0]
    assert x - 1.0 + missing["worst"] == pytest.approx(STRETCH, rel=5e-3)
    assert missing["relative"] > 0.2
    tip = numbers["tracked"]["strip.TIP"]
    assert x - tip["error of position"][0] - 1.0 == pytest.approx(STRETCH, rel=5e-3)
    stretched = tip["last deflection"][0] - tip["error of deflection"][0]
    assert stretched == pytest.approx(STRETCH, rel=5e-3)
    assert " error of the basis, m" in " ".join(output.split())


def test_a_run_of_a_body_that_corrects_itself_starts_in_its_equilibrium(tmp_path):
    """Stretched by its spin, turning, with all its coordinates: what the bases of its rounds are to hold."""
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 8, 2)))
    path = tmp_path / "strip.toml"
    text = STRIP.replace("REDUCTION", "").replace("PICTURES", PLAIN).replace("FRAME", AT_ROOT)
    text = text.replace("RATE", repr(float(RATE)))
    path.write_text(text.replace("step = 0.01\n", 'step = 0.01\nstart = "equilibrium"\n'))
    case = read_case(path)
    (placed,) = starting_system(case).bodies
    assert isinstance(placed.body, FullBody)
    tip = list(case.place("strip.TIP").at)
    assert placed.positions()[tip, 0].mean() - 1.0 == pytest.approx(STRETCH, rel=5e-3)
    assert placed.twist[5] == pytest.approx(RATE, rel=1e-12)


def test_modes_reach_their_accuracy_and_name_their_axes(strip_run):
    numbers, output, _ = strip_run("modes")
    assert numbers["axes"] == "turning with the machine"
    assert "in axes turning with the machine" in " ".join(output.split())
    assert all(mode["error"] < 1e-3 for mode in numbers["modes"])
    # Out of the plane, at six times the unit speed: [Wright1982], table of hub radius 0.
    assert numbers["modes"][0]["frequency"] * 2 * np.pi == pytest.approx(7.3604 * UNIT, rel=5e-3)


@pytest.mark.slow
def test_what_is_no_mode_is_listed_so_and_not_drawn(strip_run):
    """Vibrations of the free strip, which is held at its root."""
    reduction = 'reduction = { basis = "normal-modes", modes = 8, steady = false }'
    numbers, output, folder = strip_run("modes", reduction, '{ kind = "mean-axis" }', pictures=True)
    assert "warning: the bases of the bodies: mode" in " ".join(output.split())
    errors = [mode["error"] for mode in numbers["modes"]]
    wrong = {number for number, error in enumerate(errors, start=1) if error is None or error >= 0.01}
    assert wrong
    drawn = {int(path.stem.rpartition("-")[2]) for path in folder.glob("strip-mode-*.png")}
    assert drawn == set(range(1, len(errors) + 1)) - wrong


@pytest.mark.slow
def test_a_diagram_over_speed_keeps_to_the_accuracy_and_names_its_axes(tmp_path):
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 8, 2)))
    case = tmp_path / "strip.toml"
    text = STRIP.replace("REDUCTION", "").replace("PICTURES", PLAIN).replace("FRAME", AT_ROOT)
    case.write_text(text.replace("RATE", repr(float(RATE))))
    command = ["modes", str(case), "-o", str(tmp_path), "-n", "2", "--rates", f"0:{RATE}:2"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    diagram = json.loads((tmp_path / "strip-campbell.json").read_text())
    assert diagram["axes"] == "turning with the machine"
    assert np.max(diagram["errors"]) < 1e-3
    flaps = 2 * np.pi * np.array(diagram["frequencies"])[:, 0] / UNIT
    assert flaps == pytest.approx([3.5160, 7.3604], rel=5e-3)  # [Wright1982], hub radius 0


def test_modes_beside_a_body_in_full_ask_for_a_size(tmp_path):
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 4, 2)))
    text = STRIP.replace("REDUCTION", "").replace("PICTURES", PLAIN).replace("FRAME", AT_ROOT)
    head, body, rest = text.partition("[[body]]")
    strip_table, joint, end = rest.partition("[[joint]]")
    whole = strip_table.replace('"strip"', '"whole"').replace(
        "[[body.inter", 'reduction = { basis = "none" }\n[[body.inter'
    )
    case = tmp_path / "strip.toml"
    case.write_text((head + body + strip_table + body + whole + joint + end).replace("RATE", "0.0"))
    result = CliRunner().invoke(app, ["modes", str(case), "-o", str(tmp_path)])
    assert result.exit_code == 2
    assert "with a body that is not reduced, no other reduction can correct itself" in " ".join(
        result.output.split()
    )
