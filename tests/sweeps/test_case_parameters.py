"""Derivatives of a case's outputs for numbers of its file against differences of its runs, and fits."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import CaseError
from supple.sensitivity import Measurement
from supple.simulation import simulate
from supple.sweeps import case_parameters

MASS, GRAVITY = "body.bob.rigid.mass", "gravity[2]"
FORCE = "joint hinge"


def force(own, values):
    """Of the hinge, (t, 3)."""
    return simulate(own.machine(values), own.run).joint_forces["hinge"][:, :3]


def test_derivatives_are_those_of_differences(pendulum):
    own = case_parameters(pendulum, [MASS, GRAVITY])
    assert own.values == {MASS: 2.0, GRAVITY: -9.81}
    found = own.sensitivities([FORCE])
    assert list(found.values) == [FORCE]
    for path, value in own.values.items():
        step = 1e-3 * abs(value)
        low, high = (force(own, own.values | {path: value + side * step}) for side in (-1, 1))
        by_differences = (high - low) / (2 * step)
        derivative = found.derivatives[FORCE][path][:, :3]
        assert np.abs(derivative - by_differences).max() < 1e-5 * np.abs(by_differences).max()
    # The values of the file again, found from what its run gives.
    times = found.solution.times
    measured = Measurement(FORCE, times, found.values[FORCE][:, 0], channel="Fx", deviation=1e-3)
    pendulum.write_text(pendulum.read_text().replace("-9.81]", "-9.0]"))
    fit = case_parameters(pendulum, [GRAVITY]).calibrate([measured])
    assert fit.parameters[GRAVITY] == pytest.approx(-9.81, rel=1e-6)


def test_what_has_no_derivative_is_refused(pendulum, case_folder):
    with pytest.raises(CaseError, match="no output is named 'joint hing'; did you mean"):
        case_parameters(pendulum, [GRAVITY]).sensitivities(["joint hing"])
    with pytest.raises(CaseError, match="is not a number in"):
        case_parameters(pendulum, ["joint.hinge.kind"])
    with pytest.raises(CaseError, match="the run or the program"):
        case_parameters(pendulum, ["simulation.step"])
    with pytest.raises(CaseError, match="the run or the program"):
        case_parameters(case_folder / "strip.toml", ["body.strip.shell.thickness"])
