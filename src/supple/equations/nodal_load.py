"""Loads on nodes, as a term of the equations: the forces of all facets and their derivatives.

The functions here apply to reduced bodies (through their basis) and to full bodies (at their nodes). With
arms `x_a = X_a + u_a` and forces `F_a` in body components, the generalised forces are

    force  A sum F_a,     moment  sum x_a x F_a,     deformation  sum V_a^T F_a
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.rotation import rotation_exp, skew
from supple.arrays import AnyArray
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import STATIC, NodalLoadArrays
from supple.machine import NodalLoad, TimeLaw


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class PreparedLoad:
    """A nodal load as arrays."""

    facet_forces: Callable[..., jax.Array] = field(metadata=STATIC)
    follows_nodes: bool = field(metadata=STATIC)
    turns_against_frame: bool = field(metadata=STATIC)
    value_rank: int = field(metadata=STATIC)
    """Number of axes of the law's value for one facet"""
    law: TimeLaw
    facets: AnyArray
    """(e, m) nodes of every facet, as indices among the nodes of the load"""


def prepared(load: NodalLoad) -> PreparedLoad:
    """The arrays of a nodal load."""
    return PreparedLoad(
        facet_forces=type(load).facet_forces,
        follows_nodes=load.follows_nodes,
        turns_against_frame=load.turns_against_frame,
        value_rank=len(load.value_shapes[0]),
        law=load.law,
        facets=load.facets.astype(np.int32),
    )


def _over_facets(
    load: PreparedLoad, function: Callable[..., jax.Array], places: jax.Array, value: jax.Array
) -> jax.Array:
    by_facet = 0 if value.ndim > load.value_rank else None
    own = places[:, None] if load.facets.shape[1] == 1 else places[load.facets]
    return jax.vmap(function, in_axes=(0, by_facet))(own, value)


def _on_nodes(load: PreparedLoad, values: jax.Array, k: int) -> jax.Array:
    """Sum of the contributions of all facets (e, m, ...) to their nodes, (k, ...)."""
    if load.facets.shape[1] == 1:
        return values[:, 0]
    return jnp.zeros((k, *values.shape[2:])).at[load.facets].add(values)


def nodal_forces(load: PreparedLoad, places: jax.Array, rotation: jax.Array, time: AnyArray) -> jax.Array:
    """Forces (k, 3) on the nodes at `places` (k, 3), both in body components."""
    value = jnp.asarray(load.law(time))
    forces = _over_facets(load, lambda x, v: load.facet_forces(x, rotation, v), places, value)
    return _on_nodes(load, forces, len(places))


def forces_by_rotation(
    load: PreparedLoad, places: jax.Array, rotation: jax.Array, time: AnyArray
) -> jax.Array:
    """Derivative of the forces by a small rotation `dpsi` of the frame, (k, 3, 3)."""
    if not load.turns_against_frame:
        return jnp.zeros((len(places), 3, 3))
    value = jnp.asarray(load.law(time))

    def by_turn(x: jax.Array, v: jax.Array) -> jax.Array:
        turned = jax.jacfwd(lambda turn: load.facet_forces(x, rotation @ rotation_exp(turn), v))
        return turned(jnp.zeros(3))

    return _on_nodes(load, _over_facets(load, by_turn, places, value), len(places))


def forces_by_places(load: PreparedLoad, places: jax.Array, rotation: jax.Array, time: AnyArray) -> jax.Array:
    """Derivative of the forces of every facet by the positions of its nodes, (e, m, 3, m, 3)."""
    value = jnp.asarray(load.law(time))
    change = jax.jacfwd(lambda x, v: load.facet_forces(x, rotation, v))
    return _over_facets(load, change, places, value)


def _places(load: NodalLoadArrays, motion: SystemMotion) -> tuple[jax.Array, jax.Array]:
    """Positions of the nodes (k, 3), and the rotation of the frame."""
    coordinates = load.coordinates.take(motion.configuration.coordinates)[0]
    displaced = load.positions + jnp.einsum("kir,r->ki", load.basis, coordinates)
    return displaced, motion.configuration.rotations[load.body]


def force(load: NodalLoadArrays, motion: SystemMotion) -> jax.Array:
    """Generalised forces of the load, (1, 6 + r)."""
    arms, rotation = _places(load, motion)
    forces = nodal_forces(load.load, arms, rotation, motion.time)
    return jnp.concatenate(
        [
            rotation @ forces.sum(axis=0),
            jnp.cross(arms, forces).sum(axis=0),
            jnp.einsum("kir,ki->r", load.basis, forces),
        ]
    )[None]


def tangent(load: NodalLoadArrays, motion: SystemMotion, turn: jax.Array) -> jax.Array:
    """Derivative of the generalised forces by the body's increments, (1, 6 + r, 6 + r)."""
    own, basis = load.load, load.basis
    arms, rotation = _places(load, motion)
    forces = nodal_forces(own, arms, rotation, motion.time)
    r = basis.shape[2]
    crosses, levers = jax.vmap(skew)(forces), jax.vmap(skew)(arms)
    total = jnp.zeros((6 + r, 6 + r)).at[3:6, 6:].set(-jnp.einsum("kij,kjr->ir", crosses, basis))
    if own.turns_against_frame:
        by_turn = forces_by_rotation(own, arms, rotation, motion.time)
        on_force = rotation @ (by_turn - crosses).sum(axis=0)
        total = total.at[3:6, 3:6].set(jnp.einsum("kij,kjl->il", levers, by_turn) @ turn)
        total = total.at[6:, 3:6].set(jnp.einsum("kir,kij->rj", basis, by_turn) @ turn)
    else:
        on_force = -rotation @ crosses.sum(axis=0)
    total = total.at[:3, 3:6].set(on_force @ turn)
    if own.follows_nodes:
        by_places = jax.vmap(
            lambda column: jax.jvp(lambda x: nodal_forces(own, x, rotation, motion.time), (arms,), (column,))[
                1
            ],
            in_axes=-1,
            out_axes=-1,
        )(basis)
        total = total.at[:3, 6:].set(rotation @ by_places.sum(axis=0))
        total = total.at[3:6, 6:].add(jnp.einsum("kij,kjr->ir", levers, by_places))
        total = total.at[6:, 6:].set(jnp.einsum("kis,kir->sr", basis, by_places))
    return total[None]
