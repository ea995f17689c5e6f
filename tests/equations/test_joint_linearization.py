"""The affine form of every joint, and its derivatives against differentiation of the constraint equations."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.equations.joint_linearization import (
    affine_form,
    geometric_stiffness,
    joint_equations,
    linearize_joint,
)
from supple.equations.marker import Marker, displaced
from supple.machine import (
    At,
    Ball,
    Cylindrical,
    Fixed,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    Revolute,
    Universal,
)

ENDS = {"first": At("a", "tip"), "second": At("b", "root")}
JOINTS = {
    "ball": Ball(**ENDS),
    "cylindrical": Cylindrical(**ENDS, axis=(0, 0, 1)),
    "fixed": Fixed(**ENDS),
    "prescribed rotation": PrescribedRotation(**ENDS, axis=(0, 0, 1), angle=lambda t: t**2),
    "prescribed translation": PrescribedTranslation(**ENDS, axis=(0, 0, 1), displacement=lambda t: 3 * t),
    "prismatic": Prismatic(**ENDS, axis=(0, 0, 1)),
    "revolute": Revolute(**ENDS, axis=(0, 0, 1)),
    "universal": Universal(**ENDS, first_axis=(0, 0, 1), second_axis=(1, 0, 0)),
}
TIME = jnp.asarray(0.8)


@pytest.fixture(scope="module")
def markers(turned):
    """Two markers that are nowhere near each other: the equations are far from zero."""
    rng = np.random.default_rng(4)

    def one(axis):
        return Marker(
            origin=rng.standard_normal(3),
            rotation=turned(axis, 0.7),
            displacement=0.1 * rng.standard_normal(3),
            rotation_vector=0.3 * rng.standard_normal(3),
            cubic_turn=jnp.asarray(0.2),
            offset=rng.standard_normal(3),
            axes=turned(axis - 1, 0.4),
            velocity=np.zeros(3),
            angular_velocity=np.zeros(3),
            displacement_rate=np.zeros(3),
            rotation_vector_rate=np.zeros(3),
        )

    return jax.tree.map(jnp.asarray, (one(0), one(2)))


@pytest.mark.slow
@pytest.mark.parametrize("name", JOINTS)
def test_linearization_is_that_of_the_equations(markers, name):
    """Value, first derivatives by local freedoms, and second ones, twelve directions at each end."""
    joint = JOINTS[name]
    value = None if joint.law is None else joint.law(TIME)
    affine = affine_form(joint.constraint, value)
    multipliers = jnp.asarray(np.random.default_rng(9).standard_normal(joint.n_constraints))

    def equations(local):
        first, second = (displaced(marker, part) for marker, part in zip(markers, local, strict=True))
        return joint_equations(joint.constraint, first, second, value)

    def forces(local):
        moved = tuple(displaced(marker, part) for marker, part in zip(markers, local, strict=True))
        return tuple(multipliers @ part for part in linearize_joint(affine, *moved).by_end)

    @jax.jit
    def everything(local):
        at = linearize_joint(affine, *markers)
        derived = equations(local), jax.jacfwd(equations)(local), jax.jacfwd(forces)(local)
        return derived, (at.equations, at.by_end, geometric_stiffness(affine[0], at, *markers, multipliers))

    derived, written = everything((jnp.zeros(12), jnp.zeros(12)))
    for expected, computed in zip(jax.tree.leaves(derived), jax.tree.leaves(written), strict=True):
        np.testing.assert_allclose(computed, expected, atol=1e-14 * (1 + np.abs(expected).max()))
