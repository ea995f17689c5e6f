"""A case that assembles a machine and moves it by its driving joint alone."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_text import abaqus_text

from supple.cases import read_case, run_case, static_case
from supple.cases.static_case import starting_system
from supple.errors import CaseError, SuppleWarning, ValidityWarning
from supple.mesh import strip

CASE = """
title = "slider-crank, drawn apart"
units = { length = "m", mass = "kg", time = "s", force = "N", stress = "Pa" }

[[body]]
name = "crank"
position = [0.5, 0, 0]
rigid = { mass = 2.0, inertia = [[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.2]] }
[[body.interface]]
name = "hub"
position = [-0.5, 0, 0]
[[body.interface]]
name = "pin"
position = [0.5, 0, 0]

[[body]]
name = "rod"
position = [2.5, 0.4, 0]
rigid = { mass = 1.0, inertia = [[0.1, 0, 0], [0, 0.8, 0], [0, 0, 0.8]] }
[[body.interface]]
name = "pin"
position = [-1.5, 0, 0]
[[body.interface]]
name = "wrist"
position = [1.5, 0, 0]

[[body]]
name = "slider"
position = [4.0, 0, 0]
rigid = { mass = 3.0, inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]] }
[[body.interface]]
name = "wrist"
position = [0, 0, 0]

[[joint]]
name = "motor"
kind = "prescribed-rotation"
first = "ground"
second = "crank.hub"
axis = [0, 0, 1]
law = { kind = "spin-up", speed = 2.0, duration = 1.0 }

[[joint]]
kind = "revolute"
first = "crank.pin"
second = "rod.pin"
axis = [0, 0, 1]

[[joint]]
kind = "ball"
first = "rod.wrist"
second = "slider.wrist"

[[joint]]
kind = "prismatic"
first = "ground"
second = "slider.wrist"
axis = [1, 0, 0]

[simulation]
duration = 4.0
output_step = 0.05
step = 0.05
assemble = true
kinematic = true

[output]
track = ["slider.wrist"]
pictures = false
animation = false
report = false
"""

STRIP = """
[[body]]
name = "strip"
mesh = "strip.inp"
shell = { thickness = 0.01, youngs_modulus = 1e9, poissons_ratio = 0.3, density = 1000.0 }
frame = { kind = "mean-axis" }
"""


@pytest.fixture
def written(tmp_path):
    def write(text=CASE):
        (tmp_path / "crank.toml").write_text(text, encoding="utf-8")
        return read_case(tmp_path / "crank.toml")

    return write


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_the_slider_moves_as_its_crank_and_the_motor_does_the_work(written, tmp_path):
    result = run_case(written(), tmp_path)
    at, motion = result.solution, result.solution.bodies
    angle = np.arctan2(motion["crank"].rotation[:, 1, 0], motion["crank"].rotation[:, 0, 0])
    expected = np.cos(angle) + np.sqrt(9 - np.sin(angle) ** 2)
    np.testing.assert_allclose(result.tracked["slider.wrist"].position[:, 0], expected, atol=1e-11)
    power = at.joint_forces["motor"][:, 5] * motion["crank"].angular_velocity[:, 2]
    work = np.zeros_like(power)
    for name, mass, inertia in (("crank", 2.0, 0.2), ("rod", 1.0, 0.8), ("slider", 3.0, 0.1)):
        own = motion[name]
        work += mass * (own.velocity * own.acceleration).sum(axis=1)
        work += inertia * own.angular_velocity[:, 2] * own.angular_acceleration[:, 2]
    np.testing.assert_allclose(power, work, atol=1e-11 * abs(work).max())
    assert (tmp_path / "crank.h5").exists()


@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_the_equilibrium_of_a_machine_drawn_apart_is_that_of_the_assembled_one(written, tmp_path):
    tracked = static_case(written(), tmp_path).tracked["slider.wrist"]
    np.testing.assert_allclose(tracked.position[0], [4, 0, 0], atol=1e-9)
    driven = static_case(written(), tmp_path, time=1.5).tracked["slider.wrist"]  # the crank at 2 rad
    np.testing.assert_allclose(driven.position[0, 0], np.cos(2) + np.sqrt(9 - np.sin(2) ** 2), atol=1e-9)


def test_what_an_integrator_would_need_is_a_mistake(written):
    with pytest.raises(CaseError, match=r"simulation\.rho_inf: not used in a kinematic run"):
        written(CASE.replace("kinematic = true", "kinematic = true\nrho_inf = 0.5"))


def test_a_kinematic_run_needs_no_time_step(written):
    assert float(written(CASE.replace("\nstep = 0.05", "")).run.step_control.first) == 0.05


@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_an_error_that_is_not_estimated_is_stated(written, tmp_path):
    short = (
        CASE.replace("duration = 4.0", "duration = 0.05").replace("\nstep = 0.05", "\nstep = 0.005")
        + "\n[error]\nbasis = true\n"
    )
    with pytest.warns(SuppleWarning, match=r"\[error\] has no effect: the error of kinematic runs is not"):
        run_case(written(short), tmp_path)


@pytest.mark.filterwarnings("ignore::supple.errors.RedundantConstraintWarning")
def test_a_body_that_does_not_deform_has_no_stress_and_the_run_needs_no_step(written, tmp_path):
    held = (
        STRIP
        + """\
reduction = { basis = "craig-bampton", modes = 2 }

[[body.interface]]
name = "root"
nodes = "ROOT"

[[joint]]
kind = "fixed"
first = "ground"
second = "strip.root"

[simulation]"""
    )
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 2, 2)))
    short = CASE.replace("duration = 4.0", "duration = 0.1").replace("\nstep = 0.05", "")
    with pytest.warns(ValidityWarning, match="its stress and section forces are those of this shape"):
        result = run_case(written(short.replace("\n[simulation]", held)), tmp_path)
    np.testing.assert_allclose(result.solution.times, [0.0, 0.05, 0.1])
    assert not result.numbers["stress"]


def test_a_body_that_corrects_itself_is_refused(written, tmp_path):
    """Only a run with forces of inertia says how many coordinates it needs."""
    (tmp_path / "strip.inp").write_text(abaqus_text(strip(1.0, 0.1, 2, 2)))
    case = written(CASE.replace("\n[simulation]", STRIP + "\n[simulation]"))
    with pytest.raises(CaseError, match="has a self-correcting reduction: for a run with kinematic = true"):
        starting_system(case)
