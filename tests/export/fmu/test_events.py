"""Events of an FMU: it returns where a stop is struck or left, and the motion is the same."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.compiled_c import needs_compiler
from fixtures.exported_machines import run

from supple.body import RigidBody
from supple.export.fmu.write_fmu import write_fmu
from supple.machine import Placed, Prismatic, SlideStop, System
from supple.machine.forces.penalty import Penalty
from supple.quantities import JointMotionSensor
from supple.stepping import step_program

GRAVITY, HEIGHT, STIFFNESS, MASS = 9.81, 0.3, 1e4, 2.0


@pytest.fixture(scope="module")
def falling():
    """A body that falls along a guide on a stop."""
    body = RigidBody("block", MASS, np.zeros(3), np.eye(3) * 0.01, {"face": np.zeros(3)})
    stop = SlideStop(
        first="ground",
        second="block.face",
        axis=(0, 0, 1),
        lower=-HEIGHT,
        penalty=Penalty(stiffness=STIFFNESS),
    )
    guide = Prismatic(first="ground", second="block.face", axis=(0, 0, 1), name="guide")
    system = System([Placed(body)], [guide], loads=[stop], gravity=np.array([0, 0, -GRAVITY]))
    return step_program(system, run(), [JointMotionSensor("guide", "guide")])


@needs_compiler
@pytest.mark.slow
def test_a_blow_is_an_event_at_its_instant(falling, tmp_path, monkeypatch):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    monkeypatch.setenv("CFLAGS", "-O0")
    path = write_fmu(tmp_path / "block.fmu", falling, "block")
    assert validate_fmu(str(path)) == []
    options = {"stop_time": 0.4, "step_size": 0.02, "output_interval": 0.02, "output": ["guide.slide"]}
    plain = fmpy.simulate_fmu(str(path), **options)
    found = fmpy.simulate_fmu(str(path), use_event_mode=True, early_return_allowed=True, **options)
    times = np.unique(found["time"])
    events = times[np.abs(times / 0.02 - np.round(times / 0.02)) > 1e-6]
    struck = np.sqrt(2 * HEIGHT / GRAVITY)
    w = np.sqrt(STIFFNESS / MASS)
    # It is left after half a swing, and what gravity adds to it.
    left = struck + (np.pi + 2 * np.arctan(GRAVITY / (w * GRAVITY * struck))) / w
    np.testing.assert_allclose(events[0], struck, atol=5e-6)
    np.testing.assert_allclose(events[1:], [left], atol=3e-4)  # of the integrator
    at = np.interp(struck, found["time"], found["guide.slide"])
    assert abs(at + HEIGHT) < 1e-4
    last = [float(each["guide.slide"][-1]) for each in (plain, found)]
    np.testing.assert_allclose(last[0], last[1], atol=1e-3)


@needs_compiler
@pytest.mark.slow
def test_an_importer_without_events_steps_across(falling, tmp_path, monkeypatch):
    fmpy = pytest.importorskip("fmpy")
    monkeypatch.setenv("CFLAGS", "-O0")
    path = write_fmu(tmp_path / "block.fmu", falling, "block")
    description = fmpy.read_model_description(str(path))
    assert description.coSimulation.hasEventMode
    fmu = fmpy.fmi3.FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(path), unzipdir=str(tmp_path / "own")),
        modelIdentifier="machine",
        instanceName="one",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    event, _, early, reached = fmu.doStep(0.0, 0.4)
    assert (event, early, reached) == (False, False, 0.4)
