"""Joints, as a term of the equations: constraint equations, Jacobian, forces, geometric stiffness."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import small_product
from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, SystemMotion, turns_by_increment
from supple.equations.ends import (
    blocks_on_bodies,
    columns_on_velocities,
    forces_on_bodies,
    markers,
    turns_of,
)
from supple.equations.joint_linearization import (
    JointLinearization,
    affine_form,
    geometric_stiffness,
    joint_equations,
    linearize_joint,
)
from supple.equations.machine_model import JointGroup, Model
from supple.equations.places import MatrixBlock, Places, assembled_matrix, assembled_vector, over
from supple.programs.program_cache import CachedProgram


class LinearizedJoints(NamedTuple):
    """A group of joints at one configuration."""

    coefficients: AnyArray | None
    """`L` (k, m, 12) of `g = L (d, Q) + b` if it varies with a law of time; None if it is constant"""
    at: JointLinearization
    """Linearisations of the joints, stacked"""


def _values(joints: JointGroup, time: AnyArray) -> AnyArray | None:
    """Values of the laws, (k, ...); None without laws."""
    if joints.law is None:
        return None
    if not jax.tree.leaves(joints.law):  # a function of time, the same for all
        value = jnp.asarray(joints.law(time))
        return jnp.broadcast_to(value, (joints.rows.number, *value.shape))
    return over(lambda law: jnp.asarray(law(time)), joints.law)


def linearized(model: Model, time: AnyArray, configuration: Configuration) -> tuple[LinearizedJoints, ...]:
    """All joints, linearised, by group."""

    def of_group(joints: JointGroup) -> LinearizedJoints:
        values = _values(joints, time)
        ends = markers(joints.first, configuration), markers(joints.second, configuration)
        if values is None:
            affine = affine_form(joints.constraint, None)
            return LinearizedJoints(None, over(lambda a, b: linearize_joint(affine, a, b), *ends))
        affine = over(lambda value: affine_form(joints.constraint, value), values)
        return LinearizedJoints(affine[0], over(linearize_joint, affine, *ends))

    return tuple(of_group(joints) for joints in model.joints)


def constraints(model: Model, time: AnyArray, configuration: Configuration) -> jax.Array:
    """Constraint residuals `g(q, t)` of the active equations, (m,)."""
    parts = []
    for joints in model.joints:
        ends = markers(joints.first, configuration), markers(joints.second, configuration)
        values = _values(joints, time)
        own = over(lambda v, a, b, of=joints.constraint: joint_equations(of, a, b, v), values, *ends)
        parts.append((joints.rows, own))
    return _active(model, assembled_vector(model.n_equations, parts))


def residuals(model: Model, joints: tuple[LinearizedJoints, ...]) -> jax.Array:
    """Constraint residuals of the active equations, (m,), from joints that are already linearised."""
    parts = [(own.rows, each.at.equations) for own, each in zip(model.joints, joints, strict=True)]
    return _active(model, assembled_vector(model.n_equations, parts))


def constraint_rows(
    model: Model, joints: tuple[LinearizedJoints, ...], increments: jax.Array | None = None
) -> jax.Array:
    """Derivative `G` of the active equations of linearised joints with respect to the velocities, (m, n).

    With `increments` (n,), the columns of rotations are derivatives with respect to the increments of the
    rotation vectors, `dpsi = T(increment) dincrement`.
    """
    blocks = constraint_blocks(model, joints, increments)
    return _active(model, assembled_matrix((model.n_equations, model.n_velocities), blocks))


joint_rows = CachedProgram(constraint_rows, STARTING)
"""`constraint_rows` as a compiled program of its own, for arguments with known values."""


def constraint_blocks(
    model: Model, joints: tuple[LinearizedJoints, ...], increments: jax.Array | None = None
) -> Iterator[MatrixBlock]:
    """Blocks of `constraint_rows`, for all equations, redundant ones included."""
    turns = None if increments is None else turns_by_increment(model, increments)
    for own, each in zip(model.joints, joints, strict=True):
        for ends, part in zip((own.first, own.second), each.at.by_end, strict=True):
            if ends.velocities is not None:
                own_turns = None if turns is None else turns_of(ends, turns)
                columns = columns_on_velocities(ends, part, own_turns)
                yield MatrixBlock(own.rows, ends.velocities, columns)


def force(
    model: Model, joints: tuple[LinearizedJoints, ...], multipliers: jax.Array
) -> Iterator[tuple[Places, jax.Array]]:
    """Generalised forces `G^T lambda` on the bodies; multipliers (m,) of the active equations."""
    every = all_multipliers(model, multipliers)
    for own, each in zip(model.joints, joints, strict=True):
        local = over(
            lambda weights, first, second: (small_product(weights, first), small_product(weights, second)),
            own.rows.take(every),
            *each.at.by_end,
        )
        yield from forces_on_bodies(own, local)


def tangent(
    model: Model,
    motion: SystemMotion,
    joints: tuple[LinearizedJoints, ...],
    turns: jax.Array,
    by_position: AnyArray,
) -> Iterator[MatrixBlock]:
    """Geometric stiffness of the joint forces, times `by_position`: blocks in the bodies' increments."""
    every = by_position * all_multipliers(model, motion.multipliers)
    for own, each in zip(model.joints, joints, strict=True):
        ends = (markers(end, motion.configuration, motion.velocity) for end in (own.first, own.second))
        weights = own.rows.take(every)
        if each.coefficients is None:
            constant, _ = affine_form(own.constraint, None)
            local = over(
                lambda at, a, b, w, c=constant: geometric_stiffness(c, at, a, b, w), each.at, *ends, weights
            )
        else:
            local = over(geometric_stiffness, each.coefficients, each.at, *ends, weights)
        yield from blocks_on_bodies(own, local, turns)


def all_multipliers(model: Model, multipliers: jax.Array) -> jax.Array:
    """Multipliers of all equations, zero for the redundant ones."""
    if len(model.active) == model.n_equations:
        return multipliers
    return jnp.zeros(model.n_equations).at[np.array(model.active, dtype=int)].set(multipliers)


def _active(model: Model, every: jax.Array) -> jax.Array:
    if len(model.active) == model.n_equations:
        return every
    return every[np.array(model.active, dtype=int)]
