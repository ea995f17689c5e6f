"""FMUs by FMPy: valid, the motion of the compiled march, from any folder, states brought back."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.compiled_c import needs_compiler
from fixtures.exported_machines import (
    STEP,
    blade,
    chain,
    driven_pair,
    servo_arm,
    slider_crank,
    stops_and_friction,
)

from supple.errors import ModelError
from supple.export.fmu.write_fmu import write_fmu
from supple.stepping import step_program

N = 200
MACHINES = (chain, driven_pair, servo_arm, slider_crank, stops_and_friction, blade)


@pytest.fixture(autouse=True)
def _quickly_compiled(monkeypatch):
    monkeypatch.setenv("CFLAGS", "-O0")


def driven(step, k):
    """Inputs (i,) of step k."""
    return 0.3 * np.sin(0.01 * k) * np.ones(len(step.inputs.variables))


def marched(step):
    """Outputs (N, o) of the compiled march."""
    now, rows = step.start, []
    for k in range(1, N + 1):
        now = step.compiled(now._replace(input=driven(step, k)), STEP * k)
        rows.append(np.asarray(now.output))
    return np.array(rows)


def written(machine, path, fmi):
    """The machine as it is stepped, and its FMU."""
    system, run, sensors, inputs = machine
    step = step_program(system, run, sensors, inputs)
    return step, write_fmu(path / f"machine{fmi}.fmu", step, "machine", fmi=fmi)


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("fmi", [3, 2])
@pytest.mark.parametrize("machine", MACHINES, ids=lambda each: each.__name__)
def test_an_fmu_is_valid_and_gives_the_motion_of_the_march(machine, fmi, tmp_path, monkeypatch):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    step, path = written(machine(), tmp_path, fmi)
    assert validate_fmu(str(path)) == []
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    names = [each.name for each in step.outputs.variables]
    kinds = [("time", float), *((each.name, float) for each in step.inputs.variables)]
    given = np.array([(STEP * k, *driven(step, k + 1)) for k in range(N + 1)], dtype=kinds)
    expected = marched(step)
    size = np.abs(expected).max(axis=0) + 1.0
    for _ in range(2):  # twice in one process
        found = fmpy.simulate_fmu(
            str(path),
            stop_time=N * STEP,
            step_size=STEP,
            output_interval=STEP,
            input=given if len(kinds) > 1 else None,
            output=names,
        )
        own = np.array([[row[name] for name in names] for row in found])[1 : N + 1]
        np.testing.assert_allclose(own / size, expected / size, atol=1e-8)


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("fmi", [3, 2])
def test_instances_stand_side_by_side_and_their_states_come_back(fmi, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    _, path = written(driven_pair(), tmp_path, fmi)
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path), unzipdir=str(tmp_path / "unzipped"))
    kind = fmpy.fmi3.FMU3Slave if fmi == 3 else fmpy.fmi2.FMU2Slave
    made = []
    for name in ("one", "other"):
        fmu = kind(guid=description.guid, unzipDirectory=folder, modelIdentifier="machine", instanceName=name)
        fmu.instantiate()
        if fmi == 2:
            fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        made.append(fmu)
    one, other = made
    reads, writes = ("getFloat64", "setFloat64") if fmi == 3 else ("getReal", "setReal")
    (motor,), outputs = [1], list(range(2, 2 + len(description.outputs)))

    def stepped(fmu, times, torque):
        getattr(fmu, writes)([motor], [torque])
        for k in times:
            fmu.doStep(k * STEP, STEP)
        return getattr(fmu, reads)(outputs)

    assert stepped(one, range(20), 2.0) != stepped(other, range(20), 0.0)
    kept = one.getFMUState()
    data = one.serializeFMUState(kept)
    after = stepped(one, range(20, 40), 1.0)
    one.setFMUState(kept)
    assert stepped(one, range(20, 40), 1.0) == after
    other.setFMUState(other.deserializeFMUState(data))
    assert stepped(other, range(20, 40), 1.0) == after
    other.reset()
    assert getattr(other, reads)([0]) == [0.0]


def test_another_version_is_refused(tmp_path):
    system, run, sensors, inputs = driven_pair()
    step = step_program(system, run, sensors, inputs)
    with pytest.raises(ModelError, match="choose 3 or 2"):
        write_fmu(tmp_path / "machine.fmu", step, "machine", fmi=1)
