"""Ends of joints and loads as users write them."""

from __future__ import annotations

import re

import pytest

from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    Ball,
    DeadForce,
    DeadTorque,
    FollowerForce,
    Placed,
    SpringDamper,
    System,
    as_end,
)


@pytest.mark.parametrize(
    ("value", "end"),
    [
        ("blade.root", At("blade", "root")),
        ("blade.root.2", At("blade", "root.2")),
        (("blade", "root"), At("blade", "root")),
        (At("my.blade", "root"), At("my.blade", "root")),
        ("ground", GROUND),
        (GROUND, GROUND),
    ],
)
def test_every_form_of_an_end(value, end):
    assert as_end(value) == end
    assert isinstance(as_end(value), At)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("blade", "'blade' is not an end: write 'BODY.INTERFACE', for example 'blade.root', or 'ground'"),
        ("blade.", "'blade.' is not an end: write 'BODY.INTERFACE', for example 'blade.root'"),
        (".root", "'.root' is not an end: write 'BODY.INTERFACE', for example 'blade.root'"),
        ("", "'' is not an end: write 'BODY.INTERFACE'"),
        ("Ground", "'Ground' is not an end; did you mean 'ground'?"),
        (3, "an end is 'BODY.INTERFACE', At(body, interface) or 'ground', got 3"),
        (("a", "b", "c"), "an end is 'BODY.INTERFACE', At(body, interface) or 'ground', got ('a', 'b', 'c')"),
    ],
)
def test_what_is_not_an_end_is_refused(value, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        as_end(value)


def test_joints_and_forces_take_names():
    joint = Ball(first="ground", second="link.left")
    assert (joint.first, joint.second) == (GROUND, At("link", "left"))
    assert joint.name == "ball ground - link.left"
    spring = SpringDamper(first="link.left", second="link.right", stiffness=1.0)
    assert (spring.first, spring.second) == (At("link", "left"), At("link", "right"))
    assert DeadTorque(first="link.left", torque=[0, 0, 1]).second == GROUND


def test_a_dead_force_may_name_body_and_interface_together():
    load = DeadForce(at="link.left", force=[0.0, 0.0, 1.0])
    assert (load.body, load.at) == ("link", "left")
    assert load.label == DeadForce(body="link", at="left", force=[0.0, 0.0, 1.0]).label


def test_a_dead_force_acts_on_a_body():
    with pytest.raises(ModelError, match="DeadForce on nodes: give the body of these nodes"):
        DeadForce(at=[1, 2], force=[0.0, 0.0, 1.0])
    with pytest.raises(ModelError, match="DeadForce acts on the ground: give a body's interface"):
        DeadForce(at="ground", force=[0.0, 0.0, 1.0])
    with pytest.raises(ModelError, match=r"'left' is not an end: write 'BODY.INTERFACE'"):
        DeadForce(at="left", force=[0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("end", "cause"),
    [
        ("lonk.left", "there is no body 'lonk'; did you mean 'link'?"),
        ("link.lfet", "body 'link' has no interface 'lfet'; did you mean 'left'?"),
    ],
)
def test_misspelt_names_are_refused_by_the_system(rod, end, cause):
    placed = Placed(rod("link", 1.0))
    with pytest.raises(ModelError, match=re.escape(cause)):
        System([placed], joints=[Ball(first="ground", second=end)])
    for load in (FollowerForce(first=end, force=[0, 0, 1]), DeadForce(at=end, force=[0, 0, 1])):
        with pytest.raises(ModelError, match=re.escape(cause)):
            System([placed], loads=[load])
