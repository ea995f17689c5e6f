"""The equations of motion: exact tangents, exact constraint Jacobians, power balance."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.equations.balance import balance, constraint_jacobian, tangent
from supple.equations.build_model import build_model
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, SystemMotion, advance
from supple.equations.inertia import mass_matrix
from supple.equations.joint_force import constraint_rows, constraints
from supple.integrate import GeneralizedAlpha, StepRule
from supple.machine import (
    GROUND,
    At,
    Ball,
    BaseAcceleration,
    Cylindrical,
    DeadForce,
    DeadTorque,
    Fixed,
    FollowerForce,
    FollowerPressure,
    FollowerTorque,
    Placed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
    TorsionSpringDamper,
    Universal,
)

STEP = 0.3
"""Long, so that every term of the tangent weighs about as much as every other."""
RULE = StepRule(GeneralizedAlpha(0.6).coefficients, STEP)


def everything_once(floating_blade):
    """A flexible and a rigid body, every joint and every load; joints stand open, as within an iteration."""
    lump = RigidBody(
        "lump", 2.0, [0.1, -0.2, 0.05], np.diag([0.3, 0.4, 0.5]), {"a": [0.3, 0, 0], "b": [0, 0.2, 0.1]}
    )
    tip, root = At("blade", "tip"), At("blade", "root")
    a, b = At("lump", "a"), At("lump", "b")
    axis = (0.3, -0.5, 0.8)
    return System(
        bodies=(
            Placed(floating_blade, position=[0.2, 0.1, -0.3], rotation=[0.3, 0.2, -0.4]),
            Placed(lump, position=[1.0, 0.2, 0.1], rotation=[-0.2, 0.5, 0.1]),
        ),
        joints=(
            Ball(first=tip, second=a, name="ball"),
            Revolute(first=b, second=tip, axis=axis, name="revolute"),
            Universal(first=root, second=b, first_axis=axis, second_axis=(1, 0, 0), name="universal"),
            Cylindrical(first=tip, second=GROUND, axis=axis, name="cylindrical"),
            Prismatic(first=root, second=tip, axis=axis, name="prismatic within the blade"),
            Fixed(first=GROUND, second=a, name="fixed"),
            PrescribedRotation(first=tip, second=b, axis=axis, angle=lambda t: t**2, name="rotation"),
            PrescribedTranslation(first=a, second=root, axis=axis, displacement=lambda t: t**3, name="slide"),
        ),
        loads=(
            DeadForce(body="blade", at="tip", force=[1.0, -2.0, 3.0]),
            DeadForce(body="blade", at=[0, 5, 9], force=lambda t: t * jnp.arange(9.0).reshape(3, 3)),
            DeadForce(body="lump", at="b", force=[3.0, 1.0, -1.0]),
            FollowerPressure(body="blade", faces=[[0, 1, 4], [1, 5, 4]], pressure=lambda t: 40.0 * t),
            FollowerPressure(body="blade", faces=[[2, 3, 7, 6]], pressure=-30.0),
            BaseAcceleration(acceleration=lambda t: jnp.array([1.0, t, -t])),
            DeadTorque(first=tip, torque=[0.4, 0.3, -0.2]),
            FollowerForce(first=tip, force=[-1.0, 2.0, 0.5]),
            FollowerTorque(first=b, torque=[0.1, -0.7, 0.3]),
            SpringDamper(first=tip, second=b, stiffness=5.0, damping=0.7, rest_length=0.4),
            TorsionSpringDamper(first=root, second=a, axis=axis, stiffness=2.0, damping=0.3, rest_angle=0.1),
        ),
        gravity=(0.5, -1.0, -9.81),
    )


def doubled(system):
    """Two of each body, joint and load, which the equations treat in groups; two joints more join both.

    The copies are listed last, so that the bodies of a group do not stand side by side.
    """

    def twin(item):
        names = {}
        for field in ("first", "second"):
            end = getattr(item, field, None)
            if end is not None and end != GROUND:
                names[field] = At(end.body + " 2", end.interface)
        if hasattr(item, "body"):
            names["body"] = item.body + " 2"
        if getattr(item, "name", ""):
            names["name"] = item.name + " 2"
        return replace(item, **names) if names else None

    bodies = [
        replace(
            placed,
            body=replace(placed.body, name=placed.body.name + " 2"),
            position=placed.position + np.array([0.1, 0.4, -0.2]),
        )
        for placed in system.bodies
    ]
    crossing = (
        Ball(first=At("blade", "tip"), second=At("lump 2", "a"), name="across"),
        Ball(first=At("blade 2", "root"), second=At("lump", "b"), name="back"),
    )
    return System(
        (*system.bodies, *bodies),
        (*system.joints, *crossing, *map(twin, system.joints)),
        (*system.loads, *(new for load in system.loads if (new := twin(load)) is not None)),
        system.gravity,
    )


@pytest.fixture(scope="module", params=["one of each", pytest.param("two of each", marks=pytest.mark.slow)])
def everything(request, floating_blade):
    once = everything_once(floating_blade)
    return once if request.param == "one of each" else doubled(once)


@pytest.fixture(scope="module")
def model(everything):
    return build_model(everything)


@pytest.fixture(scope="module")
def start(everything, model):
    """A random motion with moderate strains: configuration, velocity, acceleration, multipliers, time."""
    rng = np.random.default_rng(8)
    configuration = Configuration(
        origins=jnp.array([placed.position for placed in everything.bodies]),
        rotations=jnp.array([placed.rotation for placed in everything.bodies]),
        coordinates=jnp.array(0.05 * rng.standard_normal(sum(model.sizes))),
    )
    n = model.n_velocities
    velocity, acceleration = rng.standard_normal((2, n))
    return SystemMotion(
        jnp.asarray(0.7), configuration, velocity, acceleration, rng.standard_normal(model.n_equations)
    )


def motion_after(model, start, acceleration):
    """The motion a step later, and its increments; old accelerations are 0.3 of the velocity."""
    rule, old = RULE, 0.3 * start.velocity
    auxiliary = rule.auxiliary(acceleration, old, old)
    increments = rule.increment(start.velocity, old, auxiliary)
    motion = SystemMotion(
        start.time,
        advance(model, start.configuration, increments),
        rule.new_velocity(start.velocity, old, auxiliary),
        acceleration,
        start.multipliers,
    )
    return motion, increments


def equations(acceleration, model, start):
    motion, _ = motion_after(model, start, acceleration)
    return balance(model, motion).residual, constraints(model, motion.time, motion.configuration)


@partial(jax.jit, compiler_options=STARTING)
def both_tangents(model, start):
    """By differentiation, and as the step takes them; the model is an argument: of constants XLA computes."""
    motion, increments = motion_after(model, start, start.acceleration)
    linearization = balance(model, motion).linearization
    analytic = tangent(model, motion, linearization, increments, RULE.factors)
    rows = RULE.factors.by_position * constraint_rows(model, linearization.joints, increments)
    return jax.jacfwd(equations)(start.acceleration, model, start), (analytic, rows)


@pytest.fixture(scope="module")
def linearized(model, start):
    """Residual and constraints over one step as functions of the new accelerations, and both tangents."""
    return jax.tree.map(np.asarray, both_tangents(model, start))


def test_tangent_is_the_derivative_of_the_residual(linearized):
    (expected, _), (computed, _) = linearized
    np.testing.assert_allclose(computed, expected, rtol=1e-10, atol=1e-11 * np.abs(expected).max())


def test_constraint_rows_are_the_derivative_over_the_step(linearized):
    (_, expected), (_, computed) = linearized
    np.testing.assert_allclose(computed, expected, atol=1e-12 * np.abs(expected).max())


def test_every_freedom_and_every_joint_takes_part(linearized, model):
    """Guards the two tests above: no row or column of what they compare is empty."""
    (matrix, rows), _ = linearized
    assert np.linalg.matrix_rank(matrix) == model.n_velocities
    assert (np.abs(rows).max(axis=1) > 1e-3 * np.abs(rows).max()).all()


@pytest.fixture(scope="module")
def compiled(model):
    """The pieces of the equations, compiled once."""

    @partial(jax.jit, compiler_options=STARTING)
    def pieces(motion):
        return (
            constraints(model, motion.time, motion.configuration),
            constraint_jacobian(model, motion.time, motion.configuration),
            balance(model, motion),
            mass_matrix(model, motion.configuration),
        )

    return lambda motion: jax.tree.map(np.asarray, pieces(motion))


def test_constraint_jacobian_against_finite_differences(model, start, compiled):
    """Central differences along random velocities, whose error is of second order."""
    _, jacobian, _, _ = compiled(start)
    move = jax.jit(
        lambda increment: advance(model, start.configuration, increment), compiler_options=STARTING
    )
    for direction in np.random.default_rng(1).standard_normal((3, model.n_velocities)):
        h = 1e-6
        ahead, behind = (
            compiled(start._replace(configuration=move(sign * h * direction)))[0] for sign in (1, -1)
        )
        np.testing.assert_allclose(jacobian @ direction, (ahead - behind) / (2 * h), atol=1e-8)


def test_joint_forces_are_the_jacobian_transposed(start, compiled):
    _, jacobian, terms, _ = compiled(start)
    np.testing.assert_allclose(terms.joint, jacobian.T @ start.multipliers, atol=1e-13)


def test_inertia_is_linear_in_the_accelerations(start, compiled):
    """The difference of two accelerations is seen through the mass matrix."""
    change = np.random.default_rng(4).standard_normal(start.acceleration.shape)
    _, _, terms, mass = compiled(start)
    moved = compiled(start._replace(acceleration=start.acceleration + change))[2]
    np.testing.assert_allclose(moved.inertia - terms.inertia, mass @ change, atol=1e-12 * np.abs(mass).max())


def test_mass_matrix_is_symmetric_and_positive(start, compiled):
    mass = compiled(start)[3]
    np.testing.assert_allclose(mass, mass.T, atol=1e-13)
    assert np.linalg.eigvalsh(mass).min() > 0
