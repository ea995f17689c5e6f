"""A system as arrays: rigid inertia, system size, ends of joints and forces."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import FullBody, MeanAxisFrame, RigidBody
from supple.equations.build_model import build_model, rigid_gram, system_length
from supple.errors import ModelError
from supple.machine import GROUND, At, Placed, Revolute, SpringDamper, System


def test_rigid_gram_is_that_of_point_masses():
    """`W^T M W` with `W = [I, -x~]`, summed over the points."""
    rng = np.random.default_rng(0)
    points, masses = rng.standard_normal((5, 3)), rng.uniform(1, 2, 5)
    centre = masses @ points / masses.sum()
    arms = points - centre
    inertia = sum(m * (d @ d * np.eye(3) - np.outer(d, d)) for m, d in zip(masses, arms, strict=True))
    gram = rigid_gram(RigidBody("cloud", masses.sum(), centre, inertia))
    expected = np.zeros((6, 6))
    for m, (x, y, z) in zip(masses, points, strict=True):
        W = np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
        expected += m * W.T @ W
    np.testing.assert_allclose(gram, expected, atol=1e-13)


def test_mass_of_every_kind_of_body(rod, blade, floating_blade):
    """1 m x 0.1 m x 0.02 m of density 1000."""
    for body in (rod("rod", 2.0, mass=2.0), floating_blade, FullBody(blade, MeanAxisFrame())):
        np.testing.assert_allclose(build_model(System((Placed(body),))).mass, 2.0, rtol=1e-12)


def test_size_of_a_system_is_the_span_of_its_points(rod, turned):
    system = System(
        (Placed(rod("a", 2.0)), Placed(rod("b", 1.0), position=[0, 3, 0], rotation=turned(2, np.pi / 2)))
    )
    np.testing.assert_allclose(system_length(system), np.hypot(2.0, 3.5), rtol=1e-14)


def test_size_of_a_single_point_is_a_length_of_its_body():
    """Whatever the unit of length: sqrt(trace(J) / m)."""
    ball = RigidBody("ball", 2.0, [0, 0, 0], 6.0 * np.eye(3))
    assert system_length(System((Placed(ball, position=[5, 0, 0]),))) == pytest.approx(3.0)
    other = RigidBody("other", 2.0, [0, 0, 0], 6.0 * np.eye(3))
    pair = System((Placed(ball, position=[5, 0, 0]), Placed(other, position=[5, 0, 1e-28])))
    assert system_length(pair) == pytest.approx(3.0)  # not the round-off between them


def test_joint_axes_coincide_at_the_start(rod, turned):
    """The axes of both ends, each carried by its own body, are the joint's in the initial configuration."""
    a, b = rod("a", 2.0), rod("b", 2.0)
    turn = turned(2, 0.7) @ turned(0, 0.3)
    joint = Revolute(first=At("a", "right"), second=At("b", "left"), axis=(1, 2, 3))
    system = System((Placed(a), Placed(b, position=turn @ [1, 0, 0] + [1, 0, 0], rotation=turn)), (joint,))
    (group,) = build_model(system).joints
    np.testing.assert_allclose(turn @ group.second.axes[0], group.first.axes[0], atol=1e-14)
    np.testing.assert_allclose(group.first.axes[0, :, 2], np.array([1, 2, 3]) / np.sqrt(14), rtol=1e-14)


def test_ground_stands_where_the_other_end_starts(rod):
    joint = Revolute(first=GROUND, second=At("a", "right"), axis=(0, 0, 1))
    (group,) = build_model(System((Placed(rod("a", 2.0), position=[0, 5, 0]),), (joint,))).joints
    np.testing.assert_array_equal(group.first.offset, [[1, 5, 0]])


def test_spring_on_the_ground_hangs_from_its_anchor(rod):
    spring = SpringDamper(first=At("a", "right"), anchor=(1, 2, 3), stiffness=1.0)
    (group,) = build_model(System((Placed(rod("a", 2.0)),), loads=(spring,))).forces
    np.testing.assert_array_equal(group.second.offset, [[1, 2, 3]])


def test_spring_without_length_has_no_direction(rod):
    spring = SpringDamper(first=At("a", "right"), anchor=(1, 0, 0), stiffness=1.0)
    with pytest.raises(
        ModelError,
        match=r"SpringDamper on a.right: both ends start at \[1.0, 0.0, 0.0\], so its line",
    ):
        build_model(System((Placed(rod("a", 2.0)),), loads=(spring,)))


def test_equal_bodies_and_joints_stand_in_groups(rod, floating_blade):
    """A chain of five rods and a blade: groups by kind, whatever their number, in the order of the system."""
    rods = [Placed(rod(str(i), 2.0), position=[2 * i, 0, 0]) for i in range(5)]
    joints = [
        Revolute(first=At(str(i), "right"), second=At(str(i + 1), "left"), axis=(0, 0, 1)) for i in range(4)
    ]
    joints.append(Revolute(first=At("4", "right"), second=At("blade", "root"), axis=(0, 0, 1)))
    model = build_model(System((*rods, Placed(floating_blade, position=[9.5, 0, 0])), tuple(joints)))
    assert [group.members for group in model.groups] == [(0, 1, 2, 3, 4), (5,)]
    assert [group.rows.starts for group in model.joints] == [(0, 5, 10, 15), (20,)]
    assert model.joints[0].second.bodies == (1, 2, 3, 4)
    assert model.joints[0].second.velocities.starts == (6, 12, 18, 24)
