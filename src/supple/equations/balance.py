"""Equations of motion of a system of floating bodies with joints: a sum of terms, and its tangent.

    M(q) vdot + c(q, v) + f(q) + D(q) v + G(q)^T lambda = Q(t, q, v),        g(q, t) = 0

assembled from the bodies. Each body has 3 equations of force (global components), 3 of moment about its frame
origin (body components), and one for each of its r coordinates of deformation. Each term is in its own file:
`inertia`, `internal_force`, `joint_force`, `marker_force`, `control_force`, `nodal_load`. The tangent omits
the change of the damping D(q) with q and the dependence of joint friction on the multipliers; otherwise it is
exact. Source: [Wu2019] (26)-(28), (50).
"""

from __future__ import annotations

from typing import NamedTuple

import jax

from supple.arrays import AnyArray
from supple.equations import (
    control_force,
    inertia,
    internal_force,
    joint_force,
    marker_force,
    nodal_load,
)
from supple.equations.configuration import Configuration, SystemMotion, turns_by_increment
from supple.equations.floating_inertia import InertiaTerms
from supple.equations.internal_force import InternalMatrices
from supple.equations.joint_force import LinearizedJoints, constraint_rows, linearized
from supple.equations.machine_model import Model
from supple.equations.places import MatrixBlock, assembled_matrix, assembled_vector
from supple.integrate import StepFactors


class Linearization(NamedTuple):
    """Intermediate results of `balance`, from which `tangent` is computed at the same motion.

    inertia, internal : one entry per group of bodies;   joints : one entry per group of joints
    """

    inertia: tuple[InertiaTerms, ...]
    internal: tuple[InternalMatrices, ...]
    joints: tuple[LinearizedJoints, ...]


class Balance(NamedTuple):
    """Terms whose sum is the residual, (n,) each; constraint residuals; data of the tangent."""

    inertia: AnyArray
    internal: AnyArray
    applied: AnyArray
    joint: AnyArray
    constraint_residual: AnyArray
    """Active constraint equations, (m,)"""
    linearization: Linearization

    @property
    def residual(self) -> AnyArray:
        """The unbalanced force, (n,)."""
        return self.inertia + self.internal + self.applied + self.joint


def balance(model: Model, motion: SystemMotion) -> Balance:
    """All terms of the equations of motion, the joints' equations, and the data of their tangent."""
    n = model.n_velocities
    inertial, elastic, inertia_terms, matrices = [], [], [], []
    for group in model.groups:
        states = inertia.floating_states(model, group, motion)
        force, terms = inertia.force(group, group.of(motion.configuration.rotations), states)
        inertial.append((group.velocities, force))
        inertia_terms.append(terms)
        force, internal_matrices = internal_force.force(group, states)
        elastic.append((group.velocities, force))
        matrices.append(internal_matrices)
    applied = [(load.velocities, -nodal_load.force(load, motion)) for load in model.nodal_loads]
    for forces in model.forces:
        applied += [(rows, -force) for rows, force in marker_force.force(model, forces, motion)]
    applied += [(rows, -force) for rows, force in control_force.force(model, motion)]
    joints = linearized(model, motion.time, motion.configuration)
    return Balance(
        inertia=assembled_vector(n, inertial),
        internal=assembled_vector(n, elastic),
        applied=assembled_vector(n, applied),
        joint=assembled_vector(n, joint_force.force(model, joints, motion.multipliers)),
        constraint_residual=joint_force.residuals(model, joints),
        linearization=Linearization(tuple(inertia_terms), tuple(matrices), joints),
    )


def constraint_jacobian(model: Model, time: AnyArray, configuration: Configuration) -> jax.Array:
    """Derivative `G` of the active equations with respect to the velocities, (m, n)."""
    return constraint_rows(model, linearized(model, time, configuration))


def tangent(
    model: Model,
    motion: SystemMotion,
    linearization: Linearization,
    increments: jax.Array,
    factors: StepFactors,
) -> jax.Array:
    """Derivative of the residual with respect to the new accelerations, (n, n).

    linearization : of `balance` at the same motion
    increments : (n,) change of the configuration since the start of the step
    factors : derivatives of the increments and of the velocities with respect to the accelerations
    """
    blocks = tangent_blocks(model, motion, linearization, increments, factors)
    return assembled_matrix((model.n_velocities, model.n_velocities), blocks)


def tangent_blocks(
    model: Model,
    motion: SystemMotion,
    linearization: Linearization,
    increments: jax.Array,
    factors: StepFactors,
) -> list[MatrixBlock]:
    """The blocks whose sum is the matrix of `tangent`, from the same arguments."""
    turns = turns_by_increment(model, increments)
    blocks = []
    for group, terms, matrices in zip(
        model.groups, linearization.inertia, linearization.internal, strict=True
    ):
        matrix = inertia.tangent(
            group,
            group.of(motion.configuration.rotations),
            inertia.floating_states(model, group, motion),
            terms,
            internal_force.tangent(matrices, factors),
            group.of(turns),
            factors,
        )
        blocks.append(MatrixBlock(group.velocities, group.velocities, matrix))
    for load in model.nodal_loads:
        matrix = -factors.by_position * nodal_load.tangent(load, motion, turns[load.body])
        blocks.append(MatrixBlock(load.velocities, load.velocities, matrix))
    minus = StepFactors(-factors.by_position, -factors.by_velocity)
    for forces in model.forces:
        blocks += marker_force.tangent(model, forces, motion, turns, minus)
    blocks += control_force.tangent(model, motion, turns, minus)
    blocks += joint_force.tangent(model, motion, linearization.joints, turns, factors.by_position)
    return blocks
