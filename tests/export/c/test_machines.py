"""Machines in C against the compiled march, and against the sensors of a run."""

from __future__ import annotations

import shutil
import subprocess
from typing import Any

import numpy as np
import pytest
from fixtures.compiled_c import MachineInC, needs_compiler
from fixtures.exported_machines import EVERY, STEP, UNDRIVEN, chain, driven_pair, joined_line, linked, run

from supple.errors import ModelError, ResultFileError
from supple.export.c import blocks, separate_functions
from supple.export.c.machine_source import sensor_sizes, write_machine
from supple.machine import System
from supple.quantities import read_sensors
from supple.simulation import simulate
from supple.stepping import step_program

N = 1000
_FEW = pytest.mark.filterwarnings("ignore:.* modes are too few")
LINE = pytest.param(joined_line, marks=(pytest.mark.soak, _FEW))
"""Minutes: its program is long. Its few modes are those of both programs."""
AGREEMENT = {"length": 1e-12, "angle": 1e-12, "velocity": 1e-11, "angular velocity": 1e-11}
"""Over 1000 steps, of the largest value of a quantity in the machine"""
BY_STEP = 1e-8
"""The same of all others: accelerations and joint forces carry rounding of positions by `1/(beta h^2)`."""


def exported(machine, folder):
    """The machine as it is stepped, and in C."""
    system, its_run, sensors, inputs = machine
    step = step_program(system, its_run, sensors, inputs)
    write_machine(folder, step, "machine")
    return step, MachineInC(folder)


def both(step, in_c, n=N):
    """Outputs (n, o) of the compiled march and of the C under inputs that vary."""
    now, rows = step.start, []
    for k in range(1, n + 1):
        given = 0.3 * np.sin(0.01 * k) * np.ones(len(step.inputs.variables))
        now = step.compiled(now._replace(input=given), STEP * k)
        assert in_c.advance(STEP * k, given)
        rows.append((np.asarray(now.output), in_c.output))
    return np.moveaxis(np.array(rows), 1, 0)


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("machine", [*EVERY, LINE], ids=lambda each: each.__name__)
def test_c_gives_the_motion_of_the_compiled_march(machine, tmp_path):
    step, in_c = exported(machine(), tmp_path)
    assert not step.outputs.left_out
    exact, own = both(step, in_c)
    kinds = np.array([each.description.partition(",")[0] for each in step.outputs.variables])
    for kind in set(kinds):
        here = kinds == kind
        error, size = np.abs(own - exact)[:, here].max(), np.abs(exact)[:, here].max()
        assert error <= AGREEMENT.get(kind, BY_STEP) * size, kind


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("machine", [*UNDRIVEN, LINE], ids=lambda each: each.__name__)
def test_outputs_are_what_the_sensors_of_a_run_read(machine, tmp_path):
    system, its_run, sensors, _ = machine()
    step, in_c = exported((system, its_run, sensors, {}), tmp_path)
    readings = read_sensors(sensors, system, simulate(system, its_run))
    expected = np.column_stack([each.values for each in readings])
    assert [each.name for each in step.outputs.variables] == [
        name for each in readings for name in each.names
    ]
    own = [in_c.output]
    for time in its_run.times[1:]:
        assert in_c.advance(time)
        own.append(in_c.output)
    sizes = sensor_sizes(step.outputs.variables, expected)
    np.testing.assert_allclose(np.array(own) / sizes, expected / sizes, atol=1e-8)


@needs_compiler
@pytest.mark.slow
def test_the_written_test_passes_and_nothing_is_allocated(tmp_path):
    system, its_run, sensors, inputs = chain(2)
    write_machine(tmp_path, step_program(system, its_run, sensors, inputs), "two rods */")
    done = subprocess.run(["make", "test"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "largest difference" in done.stdout
    symbols = subprocess.run(
        [shutil.which("nm") or "nm", "-u", tmp_path / "machine.o"], capture_output=True, text=True, check=True
    ).stdout.split()
    of_libm = {"sin", "cos", "sincos", "sqrt", "pow", "atan2", "ceil", "fabs", "fmod", "floor"}
    own = {"memset", "memcpy", "memmove", "_GLOBAL_OFFSET_TABLE_", "U"}
    assert set(symbols) <= of_libm | own


@needs_compiler
@pytest.mark.slow
def test_a_long_function_in_parts_gives_the_same_numbers(tmp_path, monkeypatch):
    """Loops, branches and nested blocks divided into functions of ten lines, bit for bit."""
    monkeypatch.setattr(blocks, "LONGEST", 40)
    monkeypatch.setattr(separate_functions, "_LINES", 10)
    step, in_parts = exported(driven_pair(), tmp_path)
    assert (tmp_path / "machine.c").read_text().count("static SEPARATE") > 50
    monkeypatch.setattr(blocks, "LONGEST", 10**6)
    monkeypatch.setattr(separate_functions, "_LINES", 10**6)
    write_machine(tmp_path / "whole", step, "machine")
    whole = (tmp_path / "whole" / "machine.c").read_text()
    assert "static SEPARATE" not in whole
    for k in range(1, 200):
        given = 0.3 * np.sin(0.01 * k) * np.ones(len(step.inputs.variables))
        assert in_parts.advance(STEP * k, given)
    in_whole = MachineInC(tmp_path / "whole")
    for k in range(1, 200):
        given = 0.3 * np.sin(0.01 * k) * np.ones(len(step.inputs.variables))
        assert in_whole.advance(STEP * k, given)
    assert in_parts.state == in_whole.state


@needs_compiler
@pytest.mark.slow
def test_a_state_that_is_brought_back_goes_on_alike(tmp_path):
    step, in_c = exported(driven_pair(), tmp_path)
    both(step, in_c, 50)
    kept, time = in_c.state, in_c.time
    ends = []
    for _ in range(2):
        in_c.state = kept
        for k in range(1, 20):
            in_c.advance(time + STEP * k, [1.0])
        ends.append(in_c.output)
    np.testing.assert_array_equal(*ends)


def test_what_cannot_be_exported_is_refused():
    bodies, joints = linked(2)
    system = System(bodies, joints)
    with pytest.raises(ModelError, match="no output"):
        step_program(system, run(), [])
    sensors = driven_pair()[2][:1]
    with pytest.raises(ModelError, match="nothing in 'j0' varies"):
        step_program(system, run(), sensors, {"j0": joints[0]})


def test_a_makefile_of_another_project_is_not_replaced(tmp_path):
    (tmp_path / "Makefile").write_text("all:\n")
    step: Any = None  # not reached
    with pytest.raises(ResultFileError, match="Makefile: the file exists, was not written by this export"):
        write_machine(tmp_path, step, "machine")
    assert [path.name for path in tmp_path.iterdir()] == ["Makefile"]
