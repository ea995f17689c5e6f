"""The pictures of a run are drawn from a system, a solution and meshes, whoever made them."""

from __future__ import annotations

import numpy as np
import pytest

from supple.errors import ModelError
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import Placed, System
from supple.mesh import strip
from supple.quantities import tracked_motion
from supple.report import write_report
from supple.viz import animate_run, draw_run


@pytest.fixture
def swinging(clamped_blade):
    """The blade in three states of its first mode."""
    three, turned = np.zeros((3, 3)), np.tile(np.eye(3), (3, 1, 1))
    many = np.outer([0.0, 1.0, -1.0], 1e-3 * np.eye(clamped_blade.r)[0])
    motion = FloatingMotion(three, turned, many, three, three, many, three, three, many)
    solution = Solution(np.arange(3.0), {"blade": motion}, {}, Statistics())
    return System(bodies=(Placed(clamped_blade),)), solution, {"blade": strip(1.0, 0.1, 6, 2)}


@pytest.mark.slow
def test_pictures_of_a_body_and_of_what_is_tracked(tmp_path, ink, swinging, blade):
    system, solution, _ = swinging
    tip = tracked_motion(system.bodies[0].body, solution.bodies["blade"], "tip")
    pictures = draw_run(tmp_path, *swinging, tracked={"blade.tip": tip}, elements={"blade": blade.model})
    names = [f"blade-{what}.png" for what in ("mesh", "modes", "deformed", "stress")]
    assert [path.name for path in pictures] == [*names, "tracked-motion.png"]
    assert all(ink(path) > 0.001 for path in pictures)


@pytest.mark.slow
def test_without_elements_there_is_no_stress(tmp_path, swinging):
    assert "blade-stress.png" not in [path.name for path in draw_run(tmp_path, *swinging)]


def test_an_animation_tells_how_far_it_is(tmp_path, swinging):
    shares: list[float] = []
    path = animate_run(tmp_path / "motion.gif", *swinging, progress=shares.append)
    assert path is not None
    assert path.stat().st_size > 0
    assert shares[-1] == 1.0


def test_meshes_and_elements_of_no_body_are_refused(tmp_path, swinging, blade):
    system, solution, meshes = swinging
    for given, more in (({"blde": meshes["blade"]}, {}), (meshes, {"elements": {"blde": blade.model}})):
        for draw in (draw_run, animate_run, write_report):
            with pytest.raises(ModelError, match="there is no body 'blde'; did you mean 'blade'"):
                draw(tmp_path / "a.gif", system, solution, given, **more)


def test_nothing_to_animate(tmp_path, swinging):
    system, solution, _ = swinging
    assert animate_run(tmp_path / "motion.gif", system, solution, {}) is None
