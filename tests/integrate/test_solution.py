"""Solutions are joined end to end, and their costs add up."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from supple.errors import ModelError
from supple.integrate import FloatingMotion, FramedMotion, Motion, Solution, Statistics, concatenate
from supple.methods.explicit import NodalMotion


def chunk(times):
    """A body whose every array holds the time, with two coordinates and a joint of one equation."""
    shapes = {
        "rotation": (3, 3),
        "coordinates": (2,),
        "coordinate_rates": (2,),
        "coordinate_accelerations": (2,),
    }
    motion = {
        f.name: np.multiply.outer(times, np.ones(shapes.get(f.name, (3,)))) for f in fields(FloatingMotion)
    }
    return Solution(
        np.asarray(times),
        {"link": FloatingMotion(**motion)},
        {"hinge": np.asarray(times)[:, None]},
        Statistics(
            steps=len(times), iterations=2 * len(times), rejected_steps=1, seconds=0.5, compile_seconds=0.25
        ),
    )


def test_parts_are_joined_in_time():
    whole = concatenate([chunk([0.0]), chunk([1.0, 2.0]), chunk([3.0])])
    np.testing.assert_array_equal(whole.times, [0, 1, 2, 3])
    motion = whole.bodies["link"]
    assert motion.rotation.shape == (4, 3, 3)
    for f in fields(FloatingMotion):
        array = getattr(motion, f.name)
        np.testing.assert_array_equal(array.reshape(4, -1)[:, 0], whole.times)
    np.testing.assert_array_equal(whole.joint_forces["hinge"][:, 0], whole.times)


def test_costs_add_up():
    total = concatenate([chunk([0.0]), chunk([1.0, 2.0])]).statistics
    assert total == Statistics(steps=3, iterations=6, rejected_steps=2, seconds=1.0, compile_seconds=0.5)


def test_nothing_cannot_be_joined():
    with pytest.raises(ValueError, match="no parts to join"):
        concatenate([])


def test_motion_at_some_instants_keeps_all_its_fields():
    """By a slice or by numbers: every array loses the same rows, and no other."""
    values = {
        f.name: np.random.default_rng(i).normal(size=(5, 3)) for i, f in enumerate(fields(FloatingMotion))
    }
    motion = FloatingMotion(**values)
    for rows in (slice(1, 4, 2), np.array([1, 3])):
        for name, value in values.items():
            np.testing.assert_array_equal(getattr(motion.at(rows), name), value[[1, 3]])


def test_solution_at_some_instants_is_that_of_its_parts():
    """The rows of a joined solution that came from one part are that part again, at the cost of the whole."""
    parts = [chunk([0.0]), chunk([1.0, 2.0]), chunk([3.0])]
    whole = concatenate(parts)
    for rows in (slice(1, 3), np.array([1, 2])):
        some = whole.at(rows)
        np.testing.assert_array_equal(some.times, parts[1].times)
        np.testing.assert_array_equal(some.joint_forces["hinge"], parts[1].joint_forces["hinge"])
        for f in fields(FloatingMotion):
            expected = getattr(parts[1].bodies["link"], f.name)
            np.testing.assert_array_equal(getattr(some.bodies["link"], f.name), expected)
        assert some.statistics == whole.statistics


@pytest.mark.parametrize("expected", [FloatingMotion, FramedMotion, Motion])
def test_a_motion_is_found_as_one_of_its_types(expected):
    solution = chunk([0.0, 1.0])
    assert solution.motion("link", expected) is solution.bodies["link"]


def test_a_motion_of_another_type_is_refused_with_its_fields():
    places, values = np.zeros((2, 8, 3)), np.ones((2, 1))
    nodal = NodalMotion(places, places, places, values, values, values)
    solution = Solution(np.array([0.0, 1.0]), {"bar": nodal}, {}, Statistics())
    refused = (
        "body 'bar': its motion is of type NodalMotion, but FramedMotion is needed: .* nodes, velocities"
    )
    with pytest.raises(ModelError, match=refused):
        solution.motion("bar", FramedMotion)
    with pytest.raises(ModelError, match=r"NodalMotion is needed: .* position, rotation, coordinates"):
        chunk([0.0]).motion("link", NodalMotion)


def test_a_body_that_is_not_there_is_named():
    with pytest.raises(ModelError, match="no body 'lnk' in the solution; it has link"):
        chunk([0.0]).motion("lnk", FloatingMotion)
