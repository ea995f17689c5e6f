"""Rigid bodies, joints and the ground are in pictures; what is tracked of a rigid body is its motion."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from supple.body import RigidBody
from supple.errors import ModelError
from supple.integrate import FixedStep, Run
from supple.machine import GROUND, At, Placed, Revolute, System
from supple.quantities import Place, tracked_places
from supple.results import summarize
from supple.results.run_tables import motion_table, place_table
from supple.simulation import simulate
from supple.viz import animate, animate_run, draw_run, glyphs_of, plot_mesh

LENGTH = 0.5


@pytest.fixture(scope="module")
def pendulum():
    """A rod on a hinge with the ground, let go level."""
    rod = RigidBody(
        "rod",
        1.0,
        np.array([LENGTH / 2, 0, 0]),
        np.diag([1e-3, 0.02, 0.02]),
        {"pin": np.zeros(3), "tip": np.array([LENGTH, 0.0, 0.0])},
    )
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "pin"), axis=(0.0, 1.0, 0.0))
    system = System((Placed(rod),), (hinge,), gravity=np.array([0.0, 0.0, -9.81]))
    return system, simulate(system, Run(0.3, 0.05, step=FixedStep(0.01)))


def test_glyphs_stand_where_bodies_and_joints_are(pendulum):
    system, solution = pendulum
    rows = np.arange(len(solution.times))
    glyphs = glyphs_of(system, solution, rows)
    motion = solution.bodies["rod"]
    centre = motion.position + motion.rotation @ np.array([LENGTH / 2, 0, 0])
    tip = motion.position + motion.rotation @ np.array([LENGTH, 0, 0])
    assert glyphs.lines.shape == (len(rows), 2, 2, 3)
    np.testing.assert_allclose(glyphs.lines[:, 1, 0], centre, atol=1e-12)
    np.testing.assert_allclose(glyphs.lines[:, 1, 1], tip, atol=1e-12)
    places = {mark.style.name: mark.places for mark in glyphs.marks}
    assert places.keys() == {"ground", "revolute", "centre of mass"}
    np.testing.assert_allclose(places["ground"], 0.0, atol=1e-12)
    np.testing.assert_allclose(places["revolute"], motion.position, atol=1e-12)
    np.testing.assert_allclose(places["centre of mass"], centre, atol=1e-12)


@pytest.mark.slow
def test_a_machine_without_a_mesh_is_drawn_and_animated(tmp_path, pendulum):
    system, solution = pendulum
    pictures = {path.name for path in draw_run(tmp_path, system, solution, {})}
    assert pictures == {"machine.png", "joint-forces.png"}
    film = animate_run(tmp_path / "motion.gif", system, solution, {})
    assert film is not None
    with Image.open(film) as frames:
        assert frames.n_frames == len(solution.times)
        frames.seek(0)
        first = np.asarray(frames.convert("L"), dtype=int)
        frames.seek(frames.n_frames - 1)
        last = np.asarray(frames.convert("L"), dtype=int)
    dark = [np.argwhere(frame[:, : frame.shape[1] * 9 // 10] < 60) for frame in (first, last)]
    assert all(len(each) > 100 for each in dark)
    assert np.abs(first - last).max() > 100


def test_nothing_to_draw_is_refused(tmp_path, pendulum):
    system, solution = pendulum
    nothing = glyphs_of(System((system.bodies[0],)), solution, slice(0, 1))
    assert not nothing.is_empty
    with pytest.raises(ModelError, match="nothing to animate"):
        animate(tmp_path / "a.gif", solution.times, np.empty((len(solution.times), 0, 3)), None)
    with pytest.raises(ModelError, match="cannot animate: glyphs at 1 times, positions at 7"):
        animate(
            tmp_path / "a.gif", solution.times, np.empty((len(solution.times), 0, 3)), None, glyphs=nothing
        )
    empty = type(nothing)(np.empty((1, 0, 2, 3)), ())
    with pytest.raises(ModelError, match="give a skin, or glyphs"):
        plot_mesh(tmp_path / "a.png", np.empty((0, 3)), None, glyphs=empty)


def test_the_track_of_a_rigid_body_is_its_motion_in_global_axes(pendulum):
    """A rod let go level falls on a circle: it is its place that is told, not a deflection of zero."""
    system, solution = pendulum
    tracked = tracked_places(system, solution, {"rod.tip": Place("rod", "tip")})
    place = tracked["rod.tip"]
    assert not place.is_elastic
    np.testing.assert_allclose(np.linalg.norm(place.position, axis=1), LENGTH, rtol=1e-6)
    numbers = summarize(system, solution, tracked)
    assert numbers["tracked"]["rod.tip"]["lowest position"][2] < -0.1 * LENGTH
    rows = motion_table(numbers).rows
    assert [row[1] for row in rows] == ["x", "y", "z"]
    assert float(rows[2][2]) == pytest.approx(place.position[:, 2].min(), rel=1e-4)
    assert place_table(numbers).rows == []
