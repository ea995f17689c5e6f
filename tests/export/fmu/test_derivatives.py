"""Directional derivatives of an FMU are the limits of differences of its own steps."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.compiled_c import needs_compiler
from fixtures.exported_machines import STEP, chain, driven_pair, servo_arm, slider_crank

from supple.export.fmu.write_fmu import write_fmu
from supple.stepping import step_program

WITH_INPUTS = [(driven_pair, 3), (driven_pair, 2), (servo_arm, 3), (slider_crank, 3)]
DIFFERENCE = 1e-4


def opened(machine, fmi, folder):
    """The FMU of a machine, at its start, its functions that read and set numbers, and its step."""
    fmpy = pytest.importorskip("fmpy")
    system, run, sensors, inputs = machine()
    step = step_program(system, run, sensors, inputs)
    path = write_fmu(folder / "machine.fmu", step, "machine", fmi=fmi)
    kind = fmpy.fmi3.FMU3Slave if fmi == 3 else fmpy.fmi2.FMU2Slave
    fmu = kind(
        guid=fmpy.read_model_description(str(path)).guid,
        unzipDirectory=fmpy.extract(str(path), unzipdir=str(folder / "own")),
        modelIdentifier="machine",
        instanceName="one",
    )
    fmu.instantiate()
    if fmi == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    reads, writes = ("getFloat64", "setFloat64") if fmi == 3 else ("getReal", "setReal")
    return fmu, getattr(fmu, reads), getattr(fmu, writes), step


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize(("machine", "fmi"), WITH_INPUTS, ids=lambda each: getattr(each, "__name__", each))
def test_derivatives_are_those_of_a_step(machine, fmi, tmp_path, monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O0")
    fmu, read, write, step = opened(machine, fmi, tmp_path)
    (given,) = step.start.input
    outputs = list(range(2, 2 + len(step.outputs.variables)))
    for k in range(20):
        write([1], [given + 1e-3 * k])
        fmu.doStep(k * STEP, STEP)
    before = fmu.getFMUState()

    def after(value):
        fmu.setFMUState(before)
        write([1], [value])
        fmu.doStep(20 * STEP, 2 * STEP)
        return np.array(read(outputs))

    value = given + 0.02
    difference = (after(value + DIFFERENCE) - after(value - DIFFERENCE)) / (2 * DIFFERENCE)
    after(value)
    found = np.array(fmu.getDirectionalDerivative(outputs, [1], [1.0]))
    assert np.abs(found).max() > 1e-6
    np.testing.assert_allclose(found, difference, rtol=1e-5, atol=1e-7 * np.abs(found).max())
    twice = np.array(fmu.getDirectionalDerivative(outputs, [1], [2.0]))
    np.testing.assert_allclose(twice, 2 * found, rtol=1e-12)


@needs_compiler
@pytest.mark.slow
def test_without_inputs_there_are_none(tmp_path, monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O0")
    fmu, *_ = opened(chain, 3, tmp_path)
    fmu.doStep(0.0, STEP)
    with pytest.raises(Exception, match="GetDirectionalDerivative"):
        fmu.getDirectionalDerivative([1], [1], [1.0])
