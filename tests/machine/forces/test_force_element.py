"""Laws of force at given markers, and what is refused."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    DeadTorque,
    FollowerForce,
    FollowerTorque,
    SpringDamper,
    TorsionSpringDamper,
)
from supple.machine.pose import Pose

A, B = At("a", "left"), At("b", "left")


def pose(point, turn=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0)):
    """Of an end whose axes have turned from the global ones; the spin in its own axes."""
    axes = rotation_exp(jnp.array(turn, float))
    return Pose(jnp.array(point, float), axes, jnp.array(velocity, float), axes @ jnp.array(spin, float))


def test_spring_pulls_its_ends_together():
    """Tension k (5 - 2) + c (rate 0.6 along the line), along (3, 4, 0)/5."""
    spring = SpringDamper(first=A, second=B, stiffness=10.0, damping=2.0, rest_length=2.0)
    first, second = pose([0, 0, 0]), pose([3, 4, 0], velocity=[1.0, 0, 5.0])
    on_first, on_second = spring.wrenches(first, second, None, spring.parameters)
    np.testing.assert_allclose(on_first.force, (10 * 3 + 2 * 0.6) * np.array([0.6, 0.8, 0]), rtol=1e-14)
    np.testing.assert_allclose(on_second.force, -np.asarray(on_first.force))
    np.testing.assert_array_equal(on_first.moment, 0)


def test_torsion_spring_turns_its_ends_back():
    spring = TorsionSpringDamper(
        first=A, second=B, axis=(0, 0, 1), stiffness=10.0, damping=2.0, rest_angle=lambda t: 0.1 * t
    )
    first, second = pose([0, 0, 0], spin=[0, 0, 1.0]), pose([0, 0, 0], turn=[0, 0, 0.5], spin=[0, 0, 4.0])
    on_first, on_second = spring.wrenches(first, second, spring.law(2.0), spring.parameters)
    np.testing.assert_allclose(on_second.moment, [0, 0, -(10 * (0.5 - 0.2) + 2 * 3.0)], rtol=1e-14)
    np.testing.assert_allclose(on_first.moment, -np.asarray(on_second.moment))
    np.testing.assert_array_equal(on_first.force, 0)


def test_follower_loads_turn_and_dead_ones_do_not():
    turned = pose([0, 0, 0], turn=[0, 0, np.pi / 2])
    x = jnp.array([1.0, 0.0, 0.0])
    for law, item, expected in (
        (FollowerForce(first=A, force=x), "force", [0, 1, 0]),
        (FollowerTorque(first=A, torque=x), "moment", [0, 1, 0]),
        (DeadTorque(first=A, torque=x), "moment", [1, 0, 0]),
    ):
        on_body, on_ground = law.wrenches(turned, turned, law.law(0.0), law.parameters)
        np.testing.assert_allclose(getattr(on_body, item), expected, atol=1e-15)
        np.testing.assert_array_equal(jnp.concatenate(on_ground), 0)


def test_labels_say_what_and_where():
    assert FollowerForce(first=A, force=[1, 0, 0]).label == "FollowerForce on a.left"
    assert DeadForce(body="a", at=[1, 2], force=[1, 0, 0]).label == "DeadForce on 2 nodes of 'a'"


@pytest.mark.parametrize("name", ["stiffness", "damping", "rest_length"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_spring_constants_must_not_be_negative(name, value):
    with pytest.raises(ModelError, match=f"SpringDamper on a.left: {name} must be finite and not negative"):
        SpringDamper(first=A, second=B, **{name: value})


@pytest.mark.parametrize("name", ["stiffness", "damping"])
def test_torsion_spring_constants_must_not_be_negative(name):
    with pytest.raises(ModelError, match=f"TorsionSpringDamper on a.left: {name} must be finite and not"):
        TorsionSpringDamper(first=A, second=B, axis=(0, 0, 1), **{name: -1.0})


def test_force_on_the_ground_alone():
    with pytest.raises(ModelError, match="FollowerForce on ground acts on the ground alone"):
        FollowerForce(first=GROUND, force=[1, 0, 0])


def test_spring_to_the_ground_needs_an_anchor():
    with pytest.raises(
        ModelError, match=r"SpringDamper on a.left: an end on the ground, and only such an end, needs"
    ):
        SpringDamper(first=A, stiffness=1.0)
    with pytest.raises(
        ModelError, match=r"SpringDamper on a.left: an end on the ground, and only such an end, needs"
    ):
        SpringDamper(first=A, second=B, anchor=(0, 0, 0))


@pytest.mark.parametrize("anchor", [(0, 0), (0, float("nan"), 0)])
def test_anchor_must_be_a_point(anchor):
    with pytest.raises(ModelError, match=r"SpringDamper on a.left: the anchor must be three finite numbers"):
        SpringDamper(first=A, anchor=anchor)
