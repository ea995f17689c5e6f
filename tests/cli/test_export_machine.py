"""`supple export --c` and `-o machine.fmu`: the machine of a case as C and as an FMU."""

from __future__ import annotations

import re
import subprocess
import zipfile

import numpy as np
import pytest
from fixtures.compiled_c import MachineInC, needs_compiler
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cases.result_machine import result_machine
from supple.cli.export_machine import chosen_inputs
from supple.cli.main import app
from supple.quantities import PositionSensor
from supple.storage import read_solution

PENDULUM = """
title = "a rod on a hinge, driven"
gravity = [0.0, -9.81, 0.0]
units = { length = "m", mass = "kg", time = "s" }

[[body]]
name = "rod"
rigid = { mass = 2.0, centre = [0.5, 0, 0], inertia = [[0.01, 0, 0], [0, 0.7, 0], [0, 0, 0.7]] }
[[body.interface]]
name = "eye"
position = [0.0, 0.0, 0.0]
[[body.interface]]
name = "tip"
position = [1.0, 0.0, 0.0]

[[joint]]
name = "hinge"
kind = "revolute"
first = "ground"
second = "rod.eye"
axis = [0, 0, 1]

[[element]]
name = "motor"
kind = "torque-between"
first = "ground"
second = "rod.eye"
axis = [0, 0, 1]
value = 3.0

[simulation]
duration = 0.1
output_step = 0.01
step = 0.005

[output]
track = ["rod.tip"]
"""


@pytest.fixture
def case(tmp_path):
    """The file of a driven pendulum."""
    (tmp_path / "rod.toml").write_text(PENDULUM)
    return tmp_path / "rod.toml"


def exported(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


@needs_compiler
@pytest.mark.slow
def test_a_machine_is_written_as_c_and_as_an_fmu(case, tmp_path, monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O0 -std=c99")
    result = exported(case, "--c", tmp_path / "c", "--input", "motor")
    assert result.exit_code == 0, result.output
    assert "hinge.angle" in result.output
    header = (tmp_path / "c" / "machine.h").read_text()
    assert "[0] motor" in header
    assert "[0] rod.tip.x (m)" in header
    subprocess.run(["make", "test"], cwd=tmp_path / "c", check=True, capture_output=True)
    result = exported(case, "-o", tmp_path / "rod.fmu", "--fmi", 2)
    assert result.exit_code == 0, result.output
    with zipfile.ZipFile(tmp_path / "rod.fmu") as archive:
        assert {"modelDescription.xml", "sources/machine.c", "sources/fmi2.c"} <= set(archive.namelist())


PUSHED = """
[[load]]
kind = "force"
at = "strip.TIP"
vector = [0.0, 0.0, 900.0]
law = { kind = "ramp", value = 1.0, duration = 0.4 }

[simulation]
start = "equilibrium"
"""


@needs_compiler
@pytest.mark.slow
def test_a_result_is_written_with_the_bases_and_the_rest_that_its_run_found(case_folder, tmp_path):
    path = case_folder / "strip.toml"
    text = re.sub(r"reduction = .*\n", "", path.read_text()).replace("[simulation]", PUSHED)
    path.write_text(text.replace("_step = 0.002", "_step = 0.02").replace("step = 0.002", "step = 0.01"))
    refused = exported(path, "--c", tmp_path / "c")
    assert "is reduced to an accuracy during its run" in " ".join(refused.output.split())
    ran = CliRunner().invoke(app, ["run", str(path), "-o", str(tmp_path / "out"), "--no-errors"])
    assert ran.exit_code == 0, ran.output
    result = tmp_path / "out" / "strip.h5"
    done = exported(result, "--c", tmp_path / "c")
    assert done.exit_code == 0, done.output
    found = result_machine(result)
    sensor = PositionSensor("tip", found.case.place("strip.TIP"))
    expected = sensor.values(found.system, read_solution(result))
    machine = MachineInC(tmp_path / "c")
    own = [machine.output[:3]]
    for time in found.run.times[1:]:
        assert machine.advance(time)
        own.append(machine.output[:3])
    moved = np.abs(expected - expected[0]).max()
    np.testing.assert_allclose(np.array(own) / moved, expected / moved, atol=1e-6)


def test_options_that_mean_nothing_are_refused(case, tmp_path):
    for arguments, message in (
        (("--c", tmp_path / "c", "--fmi", 2), "--fmi is not for a machine as C: remove it"),
        (
            ("--c", tmp_path / "c", "--no-stress", "--time", 1),
            "--time and --no-stress are not for a machine as C",
        ),
        (("-o", tmp_path / "rod.fmu", "--case", case), "--case is not for an FMU"),
        (("-o", tmp_path / "rod.inp", "--allow-code"), "--allow-code is not for the deck of a case's body"),
    ):
        done = exported(case, *arguments)
        assert done.exit_code == 2
        assert message in " ".join(done.output.split())


def test_mistakes_are_told_with_the_remedy(case, tmp_path):
    both = exported(case, "--c", tmp_path / "c", "-o", tmp_path / "rod.fmu")
    assert both.exit_code
    assert "one of them" in both.output
    unknown = exported(case, "--c", tmp_path / "c", "--input", "moter")
    assert unknown.exit_code
    assert "motor" in unknown.output
    assert "give the file to write" in exported(case).output
    assert "remove it" in exported(case, "-o", tmp_path / "rod.inp", "--input", "motor").output


PARAMETERS = """
[[parameter]]
name = "mass"
path = "body.rod.rigid.mass"
unit = "kg"
[[parameter]]
name = "fall"
path = "gravity[1]"
unit = "m/s2"
"""


@needs_compiler
@pytest.mark.slow
def test_numbers_that_a_case_names_are_parameters(case, tmp_path, monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O0")
    case.write_text(PENDULUM + PARAMETERS)
    result = exported(case, "-o", tmp_path / "rod.fmu", "--input", "motor")
    assert result.exit_code == 0, result.output
    with zipfile.ZipFile(tmp_path / "rod.fmu") as archive:
        text = archive.read("modelDescription.xml").decode()
    assert 'name="mass" valueReference="1" description="body.rod.rigid.mass" causality="parameter"' in text
    assert 'unit="m/s2" start="-9.81"' in text


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("body.rod.rigid.weight", "not a number in this file"),
        ("body.rod.rigid", "not a number in this file"),
        ("simulation.step", "the run or the program"),
    ],
)
def test_what_is_no_number_of_the_march_is_refused(case, tmp_path, path, message):
    case.write_text(f'{PENDULUM}\n[[parameter]]\nname = "p"\npath = "{path}"\n')
    result = exported(case, "-o", tmp_path / "rod.fmu")
    assert result.exit_code != 0
    assert message in " ".join(result.output.split())


@pytest.mark.parametrize(
    ("element", "unit"),
    [
        ('kind = "angle-servo"\nlaw = { kind = "constant", value = 0.1 }\nstiffness = 5.0', "rad"),
        ('kind = "slide-servo"\nlaw = { kind = "constant", value = 0.1 }\nstiffness = 5.0', "mm"),
        ('kind = "hinge-friction"\nvalue = 2.0\nwidth = 0.1', "N mm"),
        ('kind = "slide-friction"\nvalue = 2.0\nwidth = 0.1', "N"),
        ('kind = "force-between"\nvalue = 2.0', "N"),
        ('kind = "motor"\nspeeds = [0.0, 9.0]\ntorques = [2.0, 1.0]', ""),
    ],
)
def test_an_input_has_the_unit_of_the_law_it_replaces(case, element, unit):
    text = PENDULUM.replace('length = "m", mass = "kg"', 'length = "mm", mass = "t"')
    text = text.replace('"revolute"', '"cylindrical"')
    case.write_text(text.replace('kind = "torque-between"', element).replace("value = 3.0\n", ""))
    found = read_case(case)
    _, units = chosen_inputs(found, found.system, ["motor"])
    assert units == {"motor": unit}


@needs_compiler
def test_a_linear_machine_is_written_from_its_equilibrium(case, tmp_path):
    text = case.read_text().replace("duration", 'start = "equilibrium"\nduration').replace("3.0", "0.5")
    case.write_text(text)
    target = tmp_path / "machine.fmu"
    done = CliRunner().invoke(app, ["export", str(case), "-o", str(target), "--linear", "--input", "motor"])
    assert done.exit_code == 0, done.output
    with zipfile.ZipFile(target) as archive:
        assert "resources/linear.bin" in archive.namelist()
        assert 'name="motor"' in archive.read("modelDescription.xml").decode()
