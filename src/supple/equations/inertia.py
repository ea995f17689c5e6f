"""Inertia of bodies in floating frames, as a term of the equations: forces and their exact tangent."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from supple.algebra.rotation import skew, small_product
from supple.equations.configuration import Configuration, SystemMotion
from supple.equations.floating_inertia import (
    FloatingState,
    InertiaTerms,
    floating_mass,
    inertia_tangent,
    inertia_terms,
)
from supple.equations.machine_model import BodyGroup, Model
from supple.equations.places import MatrixBlock, assembled_matrix, over
from supple.integrate import StepFactors


def floating_states(model: Model, group: BodyGroup, motion: SystemMotion) -> FloatingState:
    """Motion of the bodies of a group in their frames, stacked."""
    gravity = model.gravity_at(motion.time)

    def of_body(
        rotation: jax.Array, coordinates: jax.Array, velocity: jax.Array, acceleration: jax.Array
    ) -> FloatingState:
        return FloatingState(
            coordinates=coordinates,
            angular_velocity=velocity[3:6],
            rates=velocity[6:],
            acceleration=small_product(rotation.T, acceleration[:3] - gravity),
            angular_acceleration=acceleration[3:6],
            accelerations=acceleration[6:],
        )

    return over(
        of_body,
        group.of(motion.configuration.rotations),
        group.coordinates.take(motion.configuration.coordinates),
        group.velocities.take(motion.velocity),
        group.velocities.take(motion.acceleration),
    )


def force(group: BodyGroup, rotations: jax.Array, states: FloatingState) -> tuple[jax.Array, InertiaTerms]:
    """Inertia forces (k, 6 + r), the first three global, the moment in body axes; data of their tangent."""

    def of_body(arrays, rotation: jax.Array, state: FloatingState) -> tuple[jax.Array, InertiaTerms]:
        terms = inertia_terms(arrays, state)
        return jnp.concatenate([small_product(rotation, terms.force[:3]), terms.force[3:]]), terms

    return over(of_body, group.inertia, rotations, states)


def tangent(
    group: BodyGroup,
    rotations: jax.Array,
    states: FloatingState,
    terms: InertiaTerms,
    elastic: jax.Array,
    turns: jax.Array,
    factors: StepFactors,
) -> jax.Array:
    """Derivatives of inertia and internal forces by the accelerations at the step's end, (k, 6 + r, 6 + r).

    elastic : (k, r, r)     derivatives of the internal forces by the accelerations of the coordinates
    turns : (k, 3, 3)       `T` in `dpsi = T dincrement`, of the frames' rotations
    """

    def of_body(arrays, rotation, state, terms, elastic, turn):
        local = inertia_tangent(arrays, state, terms, factors)
        # By the frame's rotation, a = A^T (Rddot - g) changes by da = a x dpsi, and A p by -A (p x dpsi).
        pushed = small_product(skew(factors.by_position * state.acceleration), turn)
        by_frame = small_product(local[:, :3], jnp.concatenate([rotation.T, pushed], axis=1))
        turned_force = jnp.pad(
            small_product(skew(-factors.by_position * terms.force[:3]), turn), ((0, 3 + group.r), (0, 0))
        )
        columns = jnp.concatenate(
            [
                by_frame[:, :3],
                local[:, 3:6] + by_frame[:, 3:] + turned_force,
                local[:, 6:] + jnp.pad(elastic, ((6, 0), (0, 0))),
            ],
            axis=1,
        )
        return jnp.concatenate([small_product(rotation, columns[:3]), columns[3:]])

    return over(of_body, group.inertia, rotations, states, terms, elastic, turns)


def mass_matrix(model: Model, configuration: Configuration) -> jax.Array:
    """Mass matrix of the system for its velocities, (n, n)."""

    def of_body(gram: jax.Array, rotation: jax.Array, coordinates: jax.Array) -> jax.Array:
        own = floating_mass(gram, coordinates)
        own = own.at[:, :3].set(own[:, :3] @ rotation.T)
        return own.at[:3].set(rotation @ own[:3])

    blocks = [
        MatrixBlock(
            group.velocities,
            group.velocities,
            over(
                of_body,
                group.gram,
                group.of(configuration.rotations),
                group.coordinates.take(configuration.coordinates),
            ),
        )
        for group in model.groups
    ]
    return assembled_matrix((model.n_velocities, model.n_velocities), blocks)
