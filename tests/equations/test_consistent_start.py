"""Consistent starts: closed joints, velocities along them, first accelerations, redundancy by name."""

from __future__ import annotations

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import RigidBody
from supple.equations import joint_closure
from supple.equations.consistent_start import independent_constraints
from supple.errors import ConvergenceError, ModelError, RedundantConstraintWarning, StartWarning
from supple.machine import (
    GROUND,
    At,
    Ball,
    ConstantRate,
    Fixed,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Revolute,
    System,
)
from supple.methods.floating.compiled.engine import initial_state
from supple.simulation import assemble


@pytest.fixture(scope="module")
def chain(rod):
    """Two rods of 1 m, hinged to the ground and to each other, stretched along x."""
    return System(
        bodies=(Placed(rod("a", 1.0), position=[0.5, 0, 0]), Placed(rod("b", 1.0), position=[1.5, 0, 0])),
        joints=(
            Revolute(first=GROUND, second=At("a", "left"), axis=(0, 0, 1), name="shoulder"),
            Revolute(first=At("a", "right"), second=At("b", "left"), axis=(0, 0, 1), name="elbow"),
        ),
        gravity=(0, -9.81, 0),
    )


def moved(system, index, **changes):
    bodies = list(system.bodies)
    bodies[index] = replace(bodies[index], **changes)
    return replace(system, bodies=tuple(bodies))


def test_small_gaps_are_closed(chain):
    """A tenth of a millimetre off: both rods give way, by the least motion in the mass norm."""
    with pytest.warns(StartWarning, match="joint 'elbow' is open by 0.0001 .*body 'b' was moved by 0.0001 "):
        _, state = initial_state(moved(chain, 1, position=[1.5001, 0, 0]), 0.0, 1e-3)
    origins = np.asarray(state.configuration.origins)
    np.testing.assert_allclose(origins, [[0.5, 0, 0], [1.5, 0, 0]], atol=1e-12)


def test_joints_of_a_machine_of_a_tenth_of_a_millimetre_are_closed():
    """Its lengths round off at 1e-20, but its angles at 1e-16."""
    size, turn = 1e-4, Rotation.random(rng=np.random.default_rng(1)).as_matrix()
    ends = {"left": [-size, 0, 0], "right": [size, 0, 0]}
    bodies = [
        Placed(
            RigidBody(name, 1.0, np.zeros(3), size**2 * np.diag([1, 1.2, 1.3]), ends),
            position=turn @ [shift, 0, 0],
            rotation=turn,
        )
        for name, shift in (("a", 0.0), ("b", 2 * size))
    ]
    hinge = Revolute(first="ground", second="a.left", axis=tuple(turn[:, 2]), name="hinge")
    weld = Fixed(first="a.right", second="b.left", name="weld")
    model, state = initial_state(System(bodies, [hinge, weld]), 0.0, 1e-3)
    assert len(model.active) == 11
    assert np.asarray(state.configuration.origins) == pytest.approx(
        np.array([placed.position for placed in bodies]), abs=1e-15
    )
    size = model.length
    lengths = model.as_lengths(np.ones(11))
    assert lengths == pytest.approx([1, 1, 1, size, size, 1, 1, 1, size, size, size])


@pytest.mark.parametrize(("law", "what"), [(lambda t: jnp.sin(t) / t, "value"), (jnp.sqrt, "rate")])
def test_a_law_that_is_not_finite_at_the_start_is_refused(rod, law, what):
    hub = PrescribedRotation(first="ground", second="a.left", axis=(0, 0, 1), angle=law, name="hub")
    system = System([Placed(rod("a", 1.0), position=[0.5, 0, 0])], [hub])
    with pytest.raises(ModelError, match=f"joint 'hub': its law has no finite {what} at the start"):
        initial_state(system, 0.0, 1e-3)
    if what == "value":
        with pytest.raises(ModelError, match="joint 'hub': its law has no finite value"):
            assemble(system)


def test_velocities_are_made_to_fit(chain):
    """A rod that spins about its end and is given its middle at rest: both give way."""
    start = {"velocity": [0, 0, 0], "angular_velocity": [0, 0, 2.0]}
    with pytest.warns(StartWarning, match="do not allow the initial velocities"):
        _, state = initial_state(moved(chain, 0, **start), 0.0, 1e-3)
    v = np.asarray(state.velocity)
    np.testing.assert_allclose(v[:3], [0, 0.5 * v[5], 0], atol=1e-12)
    # Of m l^2/12 w^2 with the middle held, m l^2/3 w'^2 remains: least change of middle and spin.
    np.testing.assert_allclose(v[5], 2.0 / 4, rtol=1e-9)


def test_what_is_not_given_follows(chain):
    """The spin of the first rod alone is given: its middle moves at w x r, the second rod's end with it."""
    _, state = initial_state(moved(chain, 0, angular_velocity=[0, 0, 2.0]), 0.0, 1e-3)
    v = np.asarray(state.velocity)
    np.testing.assert_allclose(v[:6], [0, 1.0, 0, 0, 0, 2.0], atol=1e-12)
    np.testing.assert_allclose(v[7], 2.0 + 0.5 * v[11], atol=1e-12)
    # A uniform rod struck at its end at speed u: its middle at u/4, its spin -3/2 u/l.
    np.testing.assert_allclose(v[[7, 11]], [0.5, -3.0], rtol=1e-9)


def test_consistent_velocities_are_kept(chain):
    given = moved(moved(chain, 0, velocity=[0, 1, 0], angular_velocity=[0, 0, 2]), 1, velocity=[0, 2, 0])
    _, state = initial_state(given, 0.0, 1e-3)
    np.testing.assert_allclose(state.velocity, [0, 1, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0], atol=1e-12)


def test_first_accelerations_are_those_of_the_double_pendulum(chain):
    """Two equal uniform rods released horizontally: alpha = -(9/7) g/l and +(3/7) g/l (both about z).

    From m l^2 [[4/3, 1/2], [1/2, 1/3]] alpha = -m g l [3/2, 1/2].
    """
    _, state = initial_state(chain, 0.0, 1e-3)
    acceleration = np.asarray(state.acceleration)
    expected = np.linalg.solve([[4 / 3, 1 / 2], [1 / 2, 1 / 3]], [-1.5 * 9.81, -0.5 * 9.81])
    np.testing.assert_allclose(acceleration[[5, 11]], expected, rtol=1e-12)


def test_open_joint_is_named_with_the_gap(chain):
    with pytest.raises(
        ModelError,
        match=r"joint 'elbow' is open in the initial configuration: position x is off by 0.2",
    ):
        initial_state(moved(chain, 1, position=[1.7, 0, 0]), 0.0, 1e-3)


def test_prescribed_angle_that_does_not_start_at_zero(rod):
    joint = PrescribedRotation(
        first=GROUND, second=At("a", "left"), axis=(0, 0, 1), angle=ConstantRate(1.0, 0.4), name="drive"
    )
    with pytest.raises(
        ModelError,
        match=r"joint 'drive' is open .*: rotation z is off by -0.389.* let the prescribed motion",
    ):
        initial_state(System((Placed(rod("a", 1.0)),), (joint,)), 0.0, 1e-3)


def test_redundant_rows_are_those_of_the_joint_that_comes_last(rod):
    """A rod clamped at one end needs no ball joint at the other."""
    system = System(
        (Placed(rod("a", 1.0)),),
        (
            Fixed(first=GROUND, second=At("a", "left"), name="clamp"),
            Ball(first=GROUND, second=At("a", "right"), name="prop"),
        ),
    )
    with pytest.warns(
        RedundantConstraintWarning,
        match=r"3 redundant constraint equation\(s\) left out: 'prop' \(position x\), 'prop' \(position y\), "
        r"'prop' \(position z\)",
    ):
        model, _ = initial_state(system, 0.0, 1e-3)
    assert model.active == tuple(range(6))


def test_independent_constraints_are_a_largest_set(rod):
    """Rank four out of six, in a metric of widely different masses; a row of zeros holds nothing."""
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((3, 12))
    jacobian = np.vstack([rows, rows[0] - 2 * rows[2], np.zeros(12), rng.standard_normal(12)])
    mass = np.diag(10.0 ** rng.uniform(-4, 4, 12))
    system = System(
        (Placed(rod("a", 1.0)), Placed(rod("b", 1.0))),
        (
            Ball(first=GROUND, second=At("a", "left"), name="one"),
            Ball(first=GROUND, second=At("b", "left"), name="two"),
        ),
    )
    with pytest.warns(
        RedundantConstraintWarning, match=r"2 redundant .*'two' \(position x\), 'two' \(position y\)\."
    ):
        assert independent_constraints(system, jacobian, mass) == (0, 1, 2, 5)


def test_no_joints_no_constraints(rod):
    system = System((Placed(rod("a", 1.0)),))
    assert independent_constraints(system, np.zeros((0, 6)), np.eye(6)) == ()


def test_contradicting_joints_are_named(rod):
    """A rod between two fixed points that is asked to slide a little along itself."""
    system = System(
        (Placed(rod("a", 1.0), position=[0.5, 0, 0]), Placed(rod("sled", 1.0), position=[1.5, 0, 0])),
        (
            Ball(first=GROUND, second=At("a", "left"), name="post"),
            Ball(first=At("a", "right"), second=At("sled", "left"), name="link"),
            PrescribedTranslation(
                first=GROUND, second=At("sled", "left"), axis=(1, 0, 0), displacement=1e-4, name="pull"
            ),
        ),
    )
    with (
        pytest.warns(RedundantConstraintWarning, match=r"'pull' \(position z\)"),
        pytest.raises(
            ModelError,
            match=r"the joints contradict each other at the start: with all others closed, 'pull' "
            r"\(position z\) is off by -0.0001",
        ),
    ):
        initial_state(system, 0.0, 1e-3)


def test_joints_that_cannot_be_closed(chain, monkeypatch):
    """With a precision asked for that no arithmetic has."""
    monkeypatch.setattr(joint_closure, "at_rounding", lambda *_: False)
    with pytest.raises(ConvergenceError, match="joints could not be closed at the start: largest residual"):
        initial_state(moved(chain, 1, position=[1.5001, 0, 0]), 0.0, 1e-3)
