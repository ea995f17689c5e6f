"""What all joints share: ends, axes, names; and the motions that each one leaves free."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    Ball,
    Cylindrical,
    Fixed,
    PointOnLine,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    Universal,
)
from supple.machine.joints.joint import axes_along
from supple.machine.pose import Pose

ENDS = {"first": GROUND, "second": At("a", "left")}
SLIDES, TURNS = range(3), range(3, 6)
"""Small motions of the second frame along and about the first's axes, in the order x y z x y z."""

JOINTS = {
    "ball": (Ball(**ENDS), None, {3, 4, 5}),
    "revolute": (Revolute(**ENDS, axis=(0, 0, 1)), None, {5}),
    "universal": (Universal(**ENDS, first_axis=(0, 0, 1), second_axis=(1, 0, 0)), None, {3, 5}),
    "cylindrical": (Cylindrical(**ENDS, axis=(0, 0, 1)), None, {2, 5}),
    "point on a line": (PointOnLine(**ENDS, axis=(0, 0, 1)), None, {2, 3, 4, 5}),
    "prismatic": (Prismatic(**ENDS, axis=(0, 0, 1)), None, {2}),
    "fixed": (Fixed(**ENDS), None, set()),
    "prescribed rotation": (PrescribedRotation(**ENDS, axis=(0, 0, 1), angle=0.0), 0.0, set()),
    "prescribed translation": (PrescribedTranslation(**ENDS, axis=(0, 0, 1), displacement=0.0), 0.0, set()),
}


def seen(point, axes):
    return Pose(point, axes, jnp.zeros(3), jnp.zeros(3))


def equations(joint, value, motion):
    """The joint's equations after a motion (6,) of the second frame away from the first."""
    first = seen(jnp.array([0.3, -0.2, 0.5]), rotation_exp(jnp.array([0.4, 0.2, -0.7])))
    second = seen(first.point + first.axes @ motion[:3], first.axes @ rotation_exp(motion[3:]))
    return joint.constraint(first, second, value)


def derivative(joint, value):
    """Of the equations for the motion, at none."""
    return np.asarray(jax.jit(jax.jacfwd(lambda motion: equations(joint, value, motion)))(jnp.zeros(6)))


@pytest.mark.slow
@pytest.mark.parametrize("name", JOINTS)
def test_joint_leaves_free_what_it_says_and_nothing_else(name):
    """The null space of the Jacobian is spanned by the free motions."""
    joint, value, free = JOINTS[name]
    jacobian = derivative(joint, value)
    assert jacobian.shape == (joint.n_constraints, 6)
    assert joint.n_constraints == 6 - len(free) == len(joint.rows)
    held = [i for i in range(6) if i not in free]
    np.testing.assert_allclose(jacobian[:, sorted(free)], 0, atol=1e-15)
    assert np.linalg.matrix_rank(jacobian[:, held]) == len(held)


@pytest.mark.parametrize("name", ["revolute", "cylindrical", "prismatic", "fixed"])
def test_rows_are_what_they_are_called(name):
    """Each row answers with one to its own motion and not at all to the others: multipliers are wrenches."""
    joint, value, _ = JOINTS[name]
    jacobian = derivative(joint, value)
    column = {f"{kind} {axis}": i for i, axis in enumerate("xyz") for kind in ("position",)}
    column |= {f"{kind} {axis}": 3 + i for i, axis in enumerate("xyz") for kind in ("rotation", "tilt about")}
    expected = np.eye(6)[[column[row] for row in joint.rows]]
    np.testing.assert_allclose(jacobian, expected, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "motion"),
    [
        ("ball", [0, 0, 0, 1.0, -2.0, 0.5]),
        ("revolute", [0, 0, 0, 0, 0, 2.5]),
        ("cylindrical", [0, 0, 3.0, 0, 0, 2.5]),
        ("prismatic", [0, 0, -4.0, 0, 0, 0]),
        ("universal", [0, 0, 0, 0, 0, 1.2]),
        ("universal", [0, 0, 0, -0.9, 0, 0]),
    ],
)
def test_free_motions_may_be_large(name, motion):
    joint, value, _ = JOINTS[name]
    np.testing.assert_allclose(equations(joint, value, jnp.array(motion)), 0, atol=1e-15)


def test_prescribed_motions_are_met_where_they_should_be():
    turn = PrescribedRotation(**ENDS, axis=(0, 0, 1), angle=lambda t: 0.5 * t)
    at = float(turn.law(3.0))
    assert at == 1.5
    np.testing.assert_allclose(equations(turn, at, jnp.array([0, 0, 0, 0, 0, 1.5])), 0, atol=1e-15)
    slide = PrescribedTranslation(**ENDS, axis=(0, 0, 1), displacement=0.7)
    np.testing.assert_allclose(
        equations(slide, slide.law(0.0), jnp.array([0, 0, 0.7, 0, 0, 0])), 0, atol=1e-15
    )


@pytest.mark.parametrize("axis", [(0, 0, 2), (1, 0, 0), (0, -3, 0), (0.3, -0.5, 0.8)])
def test_axes_are_right_handed_with_z_along_the_axis(axis):
    axes = axes_along(axis)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    np.testing.assert_allclose(axes[:, 2], np.array(axis) / np.linalg.norm(axis))


def test_universal_joint_makes_its_axes_perpendicular():
    joint = Universal(**ENDS, first_axis=(0, 0, 1), second_axis=(1, 0, 0.4))
    np.testing.assert_allclose(joint.initial_axes, np.eye(3), atol=1e-15)


def test_forces_of_a_weld_may_have_the_axes_of_a_blade():
    """Coned by 0.1 rad, at an azimuth of a third of a turn; x is the flapwise direction."""
    blade = rotation_exp(jnp.array([2 * np.pi / 3, 0, 0])) @ rotation_exp(jnp.array([0, 0.1, 0]))
    joint = Fixed(**ENDS, axis=tuple(blade[:, 2].tolist()), x_axis=(1, 0, 0))
    np.testing.assert_allclose(joint.initial_axes, blade, atol=1e-15)
    np.testing.assert_array_equal(Fixed(**ENDS).initial_axes, np.eye(3))


def test_joints_name_themselves_after_their_ends():
    assert Ball(**ENDS).name == "ball ground - a.left"


def test_ends_may_be_plain_pairs():
    assert Ball(first=("a", "right"), second=("b", "left")).first == At("a", "right")


@pytest.mark.parametrize("axis", [(0, 0, 0), (0, float("nan"), 1), (1, 0)])
def test_axis_must_be_a_direction(axis):
    with pytest.raises(ModelError, match="a joint axis must be three finite numbers, not all zero; got"):
        Revolute(**ENDS, axis=axis)


def test_axes_of_a_universal_joint_must_differ():
    with pytest.raises(ModelError, match="the two axes of a joint must not be parallel"):
        Universal(**ENDS, first_axis=(0, 1, 0), second_axis=(0, -2, 0))


def test_ground_cannot_be_joined_to_itself():
    with pytest.raises(ModelError, match="joint 'ball ground - ground' joins the ground to itself"):
        Ball(first=GROUND, second=GROUND)


def test_end_cannot_be_joined_to_itself():
    with pytest.raises(ModelError, match=r"joint 'ball a.left - a.left' joins 'a.left' to itself"):
        Ball(first=At("a", "left"), second=At("a", "left"))
