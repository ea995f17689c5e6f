"""A method of one's own: twenty lines behind the engine protocol are simulated, kept, resumed and drawn.

Nothing but this file knows the engine.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import RigidBody
from supple.integrate import FloatingMotion, Leg, Run, Solution, Statistics
from supple.machine import Placed, System
from supple.mesh import Skin
from supple.quantities import node_positions
from supple.results import summarize
from supple.simulation import register_engine, simulate
from supple.simulation.engines import _ENGINES
from supple.storage import read_header, read_solution
from supple.viz import animate


class Thrown(RigidBody):
    """A rigid body whose form chooses the engine below."""

    @property
    def kind(self):
        return "thrown"


class Explicit:
    """A free rigid body without moments, by the leapfrog rule: the state is (time, position, velocity)."""

    least_leg = 1

    def __init__(self, system, run):
        (self.placed,) = system.bodies
        self.gravity, self.h = system.gravity, run.step_control.first

    def start(self, time):
        return time, self.placed.position, self.placed.twist[:3] + self.h / 2 * self.gravity

    def resumed(self, last):
        return last.times[-1], last.bodies[self.placed.body.name].position[-1], last.engine_state["midway"]

    def march(self, state, times):
        states = []
        for end in times:
            for _ in range(round((end - state[0]) / self.h)):
                state = state[0] + self.h, state[1] + self.h * state[2], state[2] + self.h * self.gravity
            states.append(state := (end, *state[1:]))
        return Leg(states, len(states), state, Statistics(steps=len(states)))

    def solution(self, leg):
        times, position, midway = (np.array(column) for column in zip(*leg.states, strict=True))
        none, still = np.zeros((len(times), 0)), np.zeros((len(times), 3))
        turned = Rotation.from_rotvec(times[:, None] * self.placed.twist[3:]).as_matrix()
        velocity, spin = midway - self.h / 2 * self.gravity, still + self.placed.twist[3:]
        motion = FloatingMotion(
            position, turned, none, velocity, spin, none, still + self.gravity, still, none
        )
        body = {self.placed.body.name: motion}
        return Solution(times, body, {}, leg.statistics, engine_state={"midway": midway[-1]})


RUN = Run(2.0, 0.02)


@pytest.fixture
def stone(monkeypatch):
    monkeypatch.setattr("supple.simulation.engines._ENGINES", dict(_ENGINES))
    register_engine("thrown", Explicit)
    corners = {f"{i}": 0.1 * np.array([i & 1, i >> 1 & 1, i >> 2 & 1]) for i in range(8)}
    body = Thrown("stone", 2.0, [0.0, 0.0, 0.0], np.eye(3), corners)
    placed = Placed(body, velocity=[3.0, 0.0, 5.0], angular_velocity=[0.0, 1.0, 0.0])
    return System([placed], gravity=(0.0, 0.0, -9.81))


def test_it_is_simulated(stone):
    """The parabola, which the leapfrog rule meets exactly."""
    motion = simulate(stone, RUN)
    t = motion.times
    np.testing.assert_allclose(motion.bodies["stone"].position[:, 2], 5 * t - 9.81 * t**2 / 2, atol=1e-12)
    np.testing.assert_allclose(motion.bodies["stone"].velocity[:, 2], 5 - 9.81 * t, atol=1e-12)


def test_its_run_is_summarised(stone):
    summary = summarize(stone, simulate(stone, RUN))
    assert summary["bodies"] == {"stone": {"kind": "thrown", "mass": 2.0}}


def test_it_is_kept_killed_and_resumed(stone, tmp_path):
    class KilledError(Exception):
        pass

    def kill(share):
        if share > 0.4:
            raise KilledError

    path = tmp_path / "stone.h5"
    with pytest.raises(KilledError):
        simulate(stone, RUN, file=path, progress=kill)
    header = read_header(path)
    assert not header.complete
    assert 20 < header.n_times < 80
    resumed = simulate(stone, RUN, file=path)
    direct = simulate(stone, RUN)
    for name, array in direct.bodies["stone"].arrays().items():
        np.testing.assert_array_equal(resumed.bodies["stone"].arrays()[name], array)
    np.testing.assert_array_equal(read_solution(path).times, direct.times)
    assert read_header(path).complete


@pytest.mark.slow
def test_another_run_is_not_taken_for_it(stone, tmp_path):
    path = tmp_path / "stone.h5"
    simulate(stone, RUN, file=path)
    with pytest.raises(OSError, match="contains another run than requested"):
        simulate(replace(stone, gravity=(0.0, 0.0, -1.62)), RUN, file=path)


@pytest.mark.slow
def test_it_is_drawn_and_exported(stone, tmp_path):
    motion = simulate(stone, RUN)
    body = stone.bodies[0].body
    places = node_positions(body, motion.bodies["stone"])
    assert places.shape == (101, 8, 3)
    triangles = np.array([[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]])
    animation = animate(tmp_path / "stone.gif", motion.times, places, Skin(triangles, np.ones((6, 3), bool)))
    assert animation is not None
    assert animation.stat().st_size > 1000
    np.savetxt(tmp_path / "stone.csv", places[:, 0], delimiter=",")
    np.testing.assert_allclose(np.loadtxt(tmp_path / "stone.csv", delimiter=","), places[:, 0])
