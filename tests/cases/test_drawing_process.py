"""Pictures drawn by a process of their own are those drawn here; without that process they are drawn here."""

import filecmp
import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from supple.body import RigidBody
from supple.cases import drawing_process
from supple.cases.drawing import Drawing
from supple.cases.drawing_process import DrawingProcess
from supple.cases.notify import silent
from supple.cases.output import Output
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.simulation import simulate
from supple.units import UNNAMED


@pytest.fixture(scope="module")
def swing():
    bob = RigidBody("bob", 2.0, [0, 0, 0], np.diag([0.15, 0.2, 0.25]), {"hinge": [0, 0, 0.8]})
    hinge = Revolute(first=GROUND, second=At("bob", "hinge"), axis=(1, 0, 0), name="hinge")
    system = System((Placed(bob, position=[0, 0, -0.8]),), (hinge,), gravity=(0, -3.0, -9.81))
    return system, simulate(system, Run(0.2, 0.1, step=FixedStep(0.02)))


@pytest.fixture
def drawing(swing, tmp_path):
    errors = {"estimated_error": 1e-3, "indicator": 2e-3, "allowed": 5e-4}
    rounds = [{"body": "rod", "size": size, **errors} for size in (4, 8)]
    output = Output()
    return Drawing(tmp_path, *swing, {}, {}, {}, None, {}, UNNAMED, output, rounds)


@pytest.fixture
def worth(monkeypatch):
    monkeypatch.setattr(drawing_process, "WORTH", 0.0)
    monkeypatch.setattr(drawing_process, "available_cores", lambda: 2)


PICTURES = {"machine.png", "joint-forces.png", "self_correction.png", "motion.gif"}


@pytest.mark.slow
def test_pictures_of_the_process_are_those_drawn_here(drawing, worth, tmp_path):
    said = []
    with DrawingProcess() as beside:
        beside.begin(lambda: drawing)
        beside.finish(replace(drawing, folder=tmp_path / "never"), lambda *told: said.append(told))
    assert {path.name for path in tmp_path.iterdir()} == PICTURES
    assert said[0] == ("drawing pictures", 0.0)
    assert said[-1] == ("drawing the animation", 1.0)
    here = tmp_path / "here"
    here.mkdir()
    replace(drawing, folder=here).draw()
    for name in PICTURES:
        assert filecmp.cmp(tmp_path / name, here / name, shallow=False), name


@pytest.mark.slow
def test_what_a_killed_process_has_left_is_drawn_here(drawing, worth, tmp_path):
    with DrawingProcess() as beside:
        beside.begin(lambda: drawing)
        os.kill(beside._process.pid, signal.SIGKILL)
        beside.finish(replace(drawing, output=Output(pictures=False)), silent)
    assert {path.name for path in tmp_path.iterdir()} == {"motion.gif"}


def test_what_cannot_be_sent_is_drawn_here(drawing, worth, tmp_path):
    with DrawingProcess() as beside:
        beside.begin(lambda: replace(drawing, bases={"bob": lambda: None}))
        assert beside._process is None
        beside.finish(replace(drawing, output=Output(pictures=False)), silent)
    assert {path.name for path in tmp_path.iterdir()} == {"motion.gif"}


def test_process_ends_with_the_run(drawing, worth):
    with DrawingProcess() as beside:
        beside.begin(lambda: drawing)
        first = beside._process
        beside.begin(lambda: drawing)
        second = beside._process
        assert first.poll() is not None
        assert second.poll() is None
    assert second.poll() is not None


def test_runs_over_soon_are_drawn_here(drawing):
    with DrawingProcess() as beside:
        beside.begin(lambda: drawing)
        assert beside._process is None
