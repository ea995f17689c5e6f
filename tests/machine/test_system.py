"""What a system refuses: vectors, names, ends, nodes."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, RigidBody
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    Ball,
    DeadForce,
    FollowerForce,
    Placed,
    PrescribedRotation,
    System,
)
from supple.reduction import ReducedBody


@pytest.fixture
def placed(rod):
    return Placed(rod("link", 1.0), velocity=np.zeros(3), angular_velocity=np.zeros(3))


def test_rotation_as_vector_and_matrix_are_the_same(rod, turned):
    by_vector = Placed(rod("link", 1.0), rotation=[0, 0, 0.7])
    by_matrix = Placed(rod("link", 1.0), rotation=turned(2, 0.7))
    np.testing.assert_allclose(by_vector.rotation, by_matrix.rotation, atol=1e-15)


def test_arrays_are_read_only(placed):
    for item in ("position", "rotation", "velocity", "angular_velocity", "coordinates"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(placed, item)[...] = 1.0


@pytest.mark.parametrize("item", ["position", "velocity", "angular_velocity"])
@pytest.mark.parametrize("value", [[0, 0], [0, 0, float("nan")], 3.0])
def test_vectors_are_three_finite_numbers(rod, item, value):
    with pytest.raises(ModelError, match=f"{item} of body 'link' must be three finite numbers, got"):
        Placed(rod("link", 1.0), **{item: value})


@pytest.mark.parametrize("rotation", [2 * np.eye(3), np.zeros((3, 2)), np.ones(4)])
def test_rotation_must_be_orthonormal(rod, rotation):
    with pytest.raises(ModelError, match="rotation of body 'link' must be a rotation vector"):
        Placed(rod("link", 1.0), rotation=rotation)


def test_rotation_must_not_mirror(rod):
    with pytest.raises(ModelError, match="rotation of body 'link' mirrors the body"):
        Placed(rod("link", 1.0), rotation=np.diag([1.0, 1.0, -1.0]))


@pytest.mark.parametrize("item", ["coordinates", "coordinate_rates"])
def test_coordinates_must_be_as_many_as_the_body_has(clamped_blade, item):
    with pytest.raises(
        ModelError, match=rf"{item} of body 'blade' must be 6 finite numbers, got shape \(3,\)"
    ):
        Placed(clamped_blade, **{item: np.zeros(3)})


def test_a_system_needs_a_body():
    with pytest.raises(ModelError, match="a system needs at least one body"):
        System(())


def test_gravity_is_a_vector(placed):
    with pytest.raises(ModelError, match=r"gravity must be three finite numbers, got 9.81"):
        System((placed,), gravity=9.81)


def test_body_names_differ(placed):
    with pytest.raises(ModelError, match="body name 'link' is used 2 times: names must differ"):
        System((placed, placed))


def test_joint_names_differ(placed):
    joint = Ball(first=GROUND, second=At("link", "left"), name="pivot")
    with pytest.raises(ModelError, match="joint name 'pivot' is used 2 times: names must differ"):
        System((placed,), (joint, joint))


def test_no_body_is_the_ground(rod):
    with pytest.raises(ModelError, match="no body may be named 'ground'"):
        System((Placed(rod("ground", 1.0)),))


def test_joint_on_an_unknown_body(placed):
    joint = Ball(first=GROUND, second=At("lnik", "left"), name="pivot")
    with pytest.raises(ModelError, match=r"joint 'pivot': there is no body 'lnik'; did you mean 'link'?"):
        System((placed,), (joint,))


def test_joint_on_an_unknown_interface(placed):
    joint = Ball(first=GROUND, second=At("link", "top"), name="pivot")
    with pytest.raises(
        ModelError, match="joint 'pivot': body 'link' has no interface 'top'; there are: left, right"
    ):
        System((placed,), (joint,))


def test_load_on_an_unknown_interface(placed):
    load = FollowerForce(first=At("link", "rihgt"), force=[1, 0, 0])
    with pytest.raises(
        ModelError, match=r"FollowerForce on link.rihgt: body 'link' has no interface 'rihgt'; did you"
    ):
        System((placed,), loads=(load,))


def test_dead_force_on_an_unknown_body(placed):
    load = DeadForce(body="lever", at="left", force=[1, 0, 0])
    with pytest.raises(ModelError, match="DeadForce on 'left' of 'lever': there is no body 'lever'"):
        System((placed,), loads=(load,))


def test_rigid_bodies_have_no_nodes(placed):
    load = DeadForce(body="link", at=[0], force=[1, 0, 0])
    with pytest.raises(ModelError, match="a rigid body has no nodes; name one of its interfaces"):
        System((placed,), loads=(load,))


@pytest.mark.parametrize("nodes", [[], [[0, 1]]])
def test_nodes_are_a_list(clamped_blade, nodes):
    load = DeadForce(body="blade", at=nodes, force=[1, 0, 0])
    with pytest.raises(ModelError, match="node indices must be a list of at least one node"):
        System((Placed(clamped_blade),), loads=(load,))


@pytest.mark.parametrize("nodes", [[-1, 3], [3, 21]])
def test_nodes_must_exist(clamped_blade, nodes):
    load = DeadForce(body="blade", at=nodes, force=[1, 0, 0])
    with pytest.raises(
        ModelError,
        match=rf"node indices run from {nodes[0]} to {nodes[1]}, but the body has nodes 0 to 20",
    ):
        System((Placed(clamped_blade),), loads=(load,))


@pytest.mark.parametrize(
    ("at", "force"),
    [("tip", [1.0, 0.0]), ("tip", 5.0), ([0, 1], np.zeros((3, 3))), ("tip", np.zeros((2, 3)))],
)
def test_forces_have_three_components_for_every_node(clamped_blade, at, force):
    load = DeadForce(body="blade", at=at, force=force)
    with pytest.raises(ModelError, match=r"DeadForce on .* of 'blade': its values over time have shape"):
        System((Placed(clamped_blade),), loads=(load,))


def test_follower_force_has_three_components(placed):
    load = FollowerForce(first=At("link", "left"), force=[1.0, 2.0])
    with pytest.raises(
        ModelError,
        match=r"FollowerForce on link.left: its values over time have shape \(2,\); they must have \(3,\)",
    ):
        System((placed,), loads=(load,))


def test_prescribed_motion_is_one_number(placed):
    joint = PrescribedRotation(
        first=GROUND, second=At("link", "left"), axis=(0, 0, 1), angle=[0.0, 0.0, 0.0], name="motor"
    )
    with pytest.raises(
        ModelError, match=r"joint 'motor': its values over time have shape \(3,\); they must have \(\)"
    ):
        System((placed,), (joint,))


def test_functions_of_time_are_written_with_jax(placed):
    joint = PrescribedRotation(
        first=GROUND, second=At("link", "left"), axis=(0, 0, 1), angle=np.sin, name="motor"
    )
    with pytest.raises(
        ModelError, match=r"joint 'motor': its function of time must be written with jax.numpy"
    ):
        System((placed,), (joint,))


def test_bodies_of_a_form_come_by_name_in_their_order(rod, floating_blade):
    bodies = (rod("crank", 1.0), floating_blade, rod("slider", 2.0))
    system = System(tuple(Placed(body) for body in bodies))
    assert list(system.bodies_of(RigidBody)) == ["crank", "slider"]
    assert system.bodies_of(ReducedBody) == {"blade": floating_blade}
    assert system.bodies_of(FullBody) == {}


def test_bodies_stand_at_the_origin_unless_placed(rod):
    link, moved = rod("link", 1.0), Placed(rod("crank", 1.0), position=[0, 1, 0])
    system = System([link, moved])
    assert system.bodies[0].body is link
    assert system.bodies[1] is moved
    np.testing.assert_array_equal(system.bodies[0].position, np.zeros(3))
    np.testing.assert_array_equal(system.bodies[0].rotation, np.eye(3))
    assert system.bodies[0].velocity is None
    np.testing.assert_array_equal(system.bodies[0].twist, np.zeros(6))


def test_a_flexible_body_must_be_reduced_or_stand_in_full(blade):
    remedy = (
        r"body 'blade' is a FlexibleBody, .* place reduce\(body, frame, basis\), or FullBody\(body, frame\)"
    )
    with pytest.raises(ModelError, match=remedy):
        Placed(blade)
    with pytest.raises(ModelError, match=remedy):
        System([blade])
