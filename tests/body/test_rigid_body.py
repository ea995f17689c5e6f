from __future__ import annotations

import pickle

import numpy as np
import pytest

from supple.body import RigidBody
from supple.errors import ModelError

BRICK = np.diag([13.0, 10.0, 5.0])


def test_it_holds_read_only_data():
    body = RigidBody("hub", 2.0, [0, 0, 1], BRICK, {"shaft": [1, 2, 3]})
    np.testing.assert_array_equal(body.centre, [0, 0, 1])
    np.testing.assert_array_equal(body.interface("shaft").position, [1, 2, 3])
    for array in (body.inertia, body.centre, body.interface("shaft").position):
        assert array.dtype == np.float64
        assert not array.flags.writeable
    again = pickle.loads(pickle.dumps(body))
    np.testing.assert_array_equal(again.interface("shaft").position, [1, 2, 3])


@pytest.mark.parametrize("inertia", [np.diag([1.0, 1.0, 2.0]), np.diag([1.0, 1.0, 1e-9]), np.eye(3)])
def test_discs_rods_and_balls_are_possible(inertia):
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3))).Q
    RigidBody("body", 1.0, np.zeros(3), turn @ inertia @ turn.T)


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, np.inf])
def test_mass_is_positive(mass):
    with pytest.raises(ModelError, match=f"rigid body 'hub': the mass is {mass}; it must be positive"):
        RigidBody("hub", mass, np.zeros(3), BRICK)


@pytest.mark.parametrize(
    ("inertia", "message"),
    [
        (np.eye(2), r"must be a \(3, 3\) array of finite numbers"),
        (np.diag([1, 1, np.nan]), r"must be a \(3, 3\) array of finite numbers"),
        (np.eye(3) + np.eye(3, k=1) * 0.1, "is not symmetric"),
        (np.diag([1.0, 1.0, 0.0]), "is not positive definite, smallest principal value 0"),
        (np.diag([1.0, 1.0, -1.0]), "is not positive definite, smallest principal value -1"),
        (np.diag([1.0, 2.0, 3.1]), r"breaks the triangle inequality: 3.1 > 1 \+ 2"),
    ],
)
def test_inertias_that_no_matter_has(inertia, message):
    with pytest.raises(ModelError, match=f"rigid body 'hub': the inertia {message}"):
        RigidBody("hub", 1.0, np.zeros(3), inertia)


def test_positions_are_three_numbers():
    with pytest.raises(ModelError, match="centre must be three finite numbers"):
        RigidBody("hub", 1.0, [0, 0], BRICK)
    with pytest.raises(ModelError, match="interface 'shaft' must be three finite numbers"):
        RigidBody("hub", 1.0, np.zeros(3), BRICK, {"shaft": [0, 0, np.inf]})


def test_unknown_interfaces_are_told_with_the_known_ones():
    with pytest.raises(ModelError, match="body 'hub' has no interface 'rim'; there are: shaft"):
        RigidBody("hub", 1.0, np.zeros(3), BRICK, {"shaft": np.zeros(3)}).interface("rim")
    with pytest.raises(ModelError, match="there are: none"):
        RigidBody("hub", 1.0, np.zeros(3), BRICK).interface("rim")
