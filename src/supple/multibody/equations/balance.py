"""Equations of motion of a system of floating bodies with joints: residual, constraints and exact tangent.

    M(q) vdot + c(q, v) + f(q) + D v + G(q)^T lambda = Q(t, q, v),        g(q, t) = 0

assembled densely from the bodies' 6 + r equations each: force (global), moment about the frame origin (body
components), deformation. Source: [Wu2019] (26)-(28), (50).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian, skew
from supple.algebra.small_product import small_product
from supple.machine.pose import N_LOCAL, Marker, displaced, generalized_force, with_rates
from supple.multibody.equations.floating_inertia import (
    FloatingState,
    InertiaTerms,
    floating_mass,
    inertia_tangent,
    inertia_terms,
)
from supple.multibody.equations.joint_linearization import (
    Blocks,
    JointLinearization,
    geometric_stiffness,
    joint_equations,
    linearize_joint,
)
from supple.multibody.equations.model import DeadForceArrays, End, ForceArrays, JointArrays, Model
from supple.multibody.equations.polynomial_force import polynomial_force

__all__ = [
    "Balance",
    "Configuration",
    "Linearization",
    "Motion",
    "advance",
    "balance",
    "constraint_jacobian",
    "constraint_rows",
    "constraints",
    "mass_matrix",
    "tangent",
]


AnyArray = Any
"""A NumPy array or a JAX one: both engines keep their states in the same records."""


class Configuration(NamedTuple):
    """Position of every body: frame origins (nb, 3), frame rotations (nb, 3, 3), coordinates (r,) each."""

    origins: AnyArray
    rotations: AnyArray
    coordinates: tuple[AnyArray, ...]


class Motion(NamedTuple):
    """What the equations are evaluated at."""

    time: AnyArray
    configuration: Configuration
    velocity: AnyArray
    """(n,)"""
    acceleration: AnyArray
    """(n,)"""
    multipliers: AnyArray
    """(m,)"""


class Linearization(NamedTuple):
    """What the tangent takes over from the evaluation of the equations at the same motion."""

    inertia: tuple[InertiaTerms, ...]
    stiffness: tuple[jax.Array, ...]
    """Tangent of each body's internal force, (r, r)"""
    joints: tuple[JointLinearization, ...]


class Balance(NamedTuple):
    """The terms in balance, each (n,), whose sum is the residual; and how far the joints are open."""

    inertia: AnyArray
    internal: AnyArray
    applied: AnyArray
    joint: AnyArray
    gap: AnyArray
    """Active constraint equations, (m,)"""
    linearization: Linearization

    @property
    def residual(self) -> AnyArray:
        """The unbalanced force, (n,)."""
        return self.inertia + self.internal + self.applied + self.joint


def advance(model: Model, configuration: Configuration, increment: jax.Array) -> Configuration:
    """The configuration moved by an increment (n,) of the kind `velocity * time`."""
    origins, rotations, coordinates = [], [], []
    for index, part in enumerate(model.slices):
        step = increment[part]
        origins.append(configuration.origins[index] + step[:3])
        rotations.append(small_product(configuration.rotations[index], rotation_exp(step[3:6])))
        coordinates.append(configuration.coordinates[index] + step[6:])
    return Configuration(jnp.stack(origins), jnp.stack(rotations), tuple(coordinates))


def _floating(model: Model, motion: Motion, index: int) -> FloatingState:
    part = model.slices[index]
    velocity, acceleration = motion.velocity[part], motion.acceleration[part]
    rotation = motion.configuration.rotations[index]
    return FloatingState(
        coordinates=motion.configuration.coordinates[index],
        spin=velocity[3:6],
        rates=velocity[6:],
        acceleration=small_product(rotation.T, acceleration[:3] - model.gravity),
        spin_rate=acceleration[3:6],
        accelerations=acceleration[6:],
    )


def marker(model: Model, end: End, configuration: Configuration, velocity: jax.Array) -> Marker:
    """State of a marker; the ground's is at rest."""
    zero = jnp.zeros(3)
    if end.body < 0:
        eye = jnp.eye(3)
        return Marker(zero, eye, zero, zero, end.offset, end.axes, zero, zero, zero, zero)
    own = velocity[model.slices[end.body]]
    local = end.motion @ configuration.coordinates[end.body]
    local_rates = end.motion @ own[6:]
    return Marker(
        origin=configuration.origins[end.body],
        rotation=configuration.rotations[end.body],
        displacement=local[:3],
        turn=local[3:],
        offset=end.offset,
        axes=end.axes,
        velocity=own[:3],
        spin=own[3:6],
        displacement_rate=local_rates[:3],
        turn_rate=local_rates[3:],
    )


def _law_value(law: Any, time: jax.Array) -> Any:
    return None if law is None else law(time)


def _markers(model: Model, element: JointArrays | ForceArrays, motion: Motion) -> tuple[Marker, Marker]:
    return (
        marker(model, element.first, motion.configuration, motion.velocity),
        marker(model, element.second, motion.configuration, motion.velocity),
    )


def _on_bodies(
    element: JointArrays | ForceArrays, local: tuple[jax.Array, jax.Array]
) -> Iterator[tuple[int, jax.Array]]:
    """Generalised forces on the bodies at both ends of an element, from those on the local freedoms (12,)."""
    for end, part in zip((element.first, element.second), local, strict=True):
        if end.body >= 0:
            yield end.body, jnp.concatenate([part[:6], end.motion.T @ part[6:]])


def _joined(model: Model, parts: list[tuple[int, jax.Array]]) -> jax.Array:
    """The system's vector (n,) from contributions to bodies."""
    totals: list[Any] = [jnp.zeros(6 + body.r) for body in model.bodies]
    for index, part in parts:
        totals[index] = totals[index] + part
    return jnp.concatenate(totals)


def _joint_parts(model: Model) -> list[slice]:
    starts = [0]
    for joint in model.joints:
        starts.append(starts[-1] + joint.n_constraints)
    return [slice(a, b) for a, b in pairwise(starts)]


def _all_multipliers(model: Model, multipliers: jax.Array) -> jax.Array:
    if len(model.active) == model.n_equations:
        return multipliers
    return jnp.zeros(model.n_equations).at[jnp.array(model.active, dtype=int)].set(multipliers)


def _active_rows(model: Model, rows: list[jax.Array]) -> jax.Array:
    every = jnp.concatenate(rows)
    if len(model.active) == model.n_equations:
        return every
    return every[jnp.array(model.active, dtype=int)]


def _ends_at(model: Model, element: JointArrays, configuration: Configuration) -> tuple[Marker, Marker]:
    """Both markers of a joint in a configuration at rest."""
    at_rest = jnp.zeros(model.n_velocities)
    return (
        marker(model, element.first, configuration, at_rest),
        marker(model, element.second, configuration, at_rest),
    )


def _linearize_joints(
    model: Model, time: jax.Array, configuration: Configuration
) -> tuple[JointLinearization, ...]:
    return tuple(
        linearize_joint(joint, *_ends_at(model, joint, configuration), time) for joint in model.joints
    )


def constraints(model: Model, time: jax.Array, configuration: Configuration) -> jax.Array:
    """Active constraint equations `g(q, t)`, (m,)."""
    if not model.joints:
        return jnp.zeros(0)
    return _active_rows(
        model,
        [joint_equations(joint, *_ends_at(model, joint, configuration), time) for joint in model.joints],
    )


def constraint_jacobian(model: Model, time: jax.Array, configuration: Configuration) -> jax.Array:
    """Derivative `G` of the active equations for the velocities, (m, n)."""
    return constraint_rows(model, _linearize_joints(model, time, configuration))


def constraint_rows(
    model: Model, joints: tuple[JointLinearization, ...], increments: jax.Array | None = None
) -> jax.Array:
    """Derivative `G` of the active equations of linearised joints for the velocities, (m, n).

    With `increments` (n,), for the increments that led here instead: `dpsi = T(increment) dincrement`.
    """
    if not joints:
        return jnp.zeros((0, model.n_velocities))
    rows = []
    for joint, at in zip(model.joints, joints, strict=True):
        blocks: list[Any] = [jnp.zeros((joint.n_constraints, 6 + body.r)) for body in model.bodies]
        for end, part in zip((joint.first, joint.second), at.by_end, strict=True):
            if end.body >= 0:
                turn = None if increments is None else _turn_by_increment(model, end.body, increments)
                blocks[end.body] = blocks[end.body] + _on_velocities(end, part, turn)
        rows.append(jnp.concatenate(blocks, axis=1))
    return _active_rows(model, rows)


def _on_velocities(end: End, by_local: jax.Array, turn: jax.Array | None) -> jax.Array:
    """Columns for a body's velocities (k, 6 + r) from those for the local freedoms (k, 12) of its marker.

    With `turn` (3, 3), for the increment of the frame's rotation vector instead of `dpsi`.
    """
    spin = by_local[:, 3:6] if turn is None else small_product(by_local[:, 3:6], turn)
    return jnp.concatenate([by_local[:, :3], spin, by_local[:, 6:] @ end.motion], axis=1)


def _turn_by_increment(model: Model, index: int, increments: jax.Array) -> jax.Array:
    return rotation_right_jacobian(increments[model.slices[index]][3:6])


def _force_on_local_freedoms(
    force: ForceArrays, first: Marker, second: Marker, time: jax.Array, variation: jax.Array, rates: jax.Array
) -> jax.Array:
    """Generalised forces (24,) of a force element, markers displaced and sped up by (24,) each."""
    first = with_rates(displaced(first, variation[:N_LOCAL]), rates[:N_LOCAL])
    second = with_rates(displaced(second, variation[N_LOCAL:]), rates[N_LOCAL:])
    on_first, on_second = force.wrenches(first, second, _law_value(force.law, time), force.parameters)
    return jnp.concatenate([generalized_force(first, on_first), generalized_force(second, on_second)])


class _PointForces(NamedTuple):
    """Dead forces of one load seen from their body: arms (k, 3) and forces (k, 3) in body components."""

    arms: jax.Array
    forces: jax.Array


def _point_forces(load: DeadForceArrays, motion: Motion) -> _PointForces:
    configuration = motion.configuration
    coordinates = configuration.coordinates[load.body]
    arms = load.positions + jnp.einsum("kir,r->ki", load.basis, coordinates)
    forces = jnp.broadcast_to(jnp.asarray(load.law(motion.time)), arms.shape)
    return _PointForces(arms, forces @ configuration.rotations[load.body])


def balance(model: Model, motion: Motion) -> Balance:
    """All terms of the equations of motion, the joints' equations, and what their tangent needs."""
    inertia, internal, inertia_by_body, stiffness = [], [], [], []
    for index, body in enumerate(model.bodies):
        floating = _floating(model, motion, index)
        terms = inertia_terms(body.inertia, floating)
        own = terms.force
        rotation = motion.configuration.rotations[index]
        inertia.append(jnp.concatenate([small_product(rotation, own[:3]), own[3:]]))
        force, tangent_stiffness = polynomial_force(
            body.stiffness, body.cubic, body.quartic, floating.coordinates
        )
        internal.append(jnp.concatenate([jnp.zeros(6), force + body.damping @ floating.rates]))
        inertia_by_body.append(terms)
        stiffness.append(tangent_stiffness)
    applied = []
    for load in model.dead_forces:
        arms, forces = _point_forces(load, motion)
        total = motion.configuration.rotations[load.body] @ forces.sum(axis=0)
        generalized = jnp.concatenate(
            [total, jnp.cross(arms, forces).sum(axis=0), jnp.einsum("kir,ki->r", load.basis, forces)]
        )
        applied.append((load.body, -generalized))
    still = jnp.zeros(2 * N_LOCAL)
    for force in model.forces:
        first, second = _markers(model, force, motion)
        local = _force_on_local_freedoms(force, first, second, motion.time, still, still)
        applied += _on_bodies(force, (-local[:N_LOCAL], -local[N_LOCAL:]))
    holding = []
    multipliers = _all_multipliers(model, motion.multipliers)
    joints = _linearize_joints(model, motion.time, motion.configuration)
    for joint, at, rows in zip(model.joints, joints, _joint_parts(model), strict=True):
        on_first, on_second = at.by_end
        own_multipliers = multipliers[rows]
        local = small_product(own_multipliers, on_first), small_product(own_multipliers, on_second)
        holding += _on_bodies(joint, local)
    return Balance(
        inertia=jnp.concatenate(inertia),
        internal=jnp.concatenate(internal),
        applied=_joined(model, applied),
        joint=_joined(model, holding),
        gap=_active_rows(model, [at.equations for at in joints]) if joints else jnp.zeros(0),
        linearization=Linearization(tuple(inertia_by_body), tuple(stiffness), joints),
    )


def mass_matrix(model: Model, configuration: Configuration) -> jax.Array:
    """Mass matrix of the system for its velocities, (n, n)."""
    matrix = jnp.zeros((model.n_velocities, model.n_velocities))
    for index, (body, part) in enumerate(zip(model.bodies, model.slices, strict=True)):
        own = floating_mass(body.gram, configuration.coordinates[index])
        rotation = configuration.rotations[index]
        own = own.at[:, :3].set(own[:, :3] @ rotation.T)
        matrix = matrix.at[part, part].set(own.at[:3].set(rotation @ own[:3]))
    return matrix


def tangent(
    model: Model,
    motion: Motion,
    linearization: Linearization,
    increments: jax.Array,
    velocity: jax.Array,
    position: jax.Array,
) -> jax.Array:
    """Derivative of the residual for the new accelerations, (n, n).

    The velocities follow the accelerations with the factor `velocity`, the increments of the configuration
    with the factor `position` (`StepRule`); the linearisation is that of `balance` at the same motion.
    """
    turns = [_turn_by_increment(model, index, increments) for index in range(len(model.bodies))]
    blocks: dict[tuple[int, int], Any] = {
        (index, index): _body_tangent(model, motion, index, linearization, turns[index], velocity, position)
        for index in range(len(model.bodies))
    }
    for load in model.dead_forces:
        block = _dead_force_tangent(load, motion, turns[load.body])
        blocks[load.body, load.body] += -position * block
    still = jnp.zeros(2 * N_LOCAL)
    halves = slice(0, N_LOCAL), slice(N_LOCAL, 2 * N_LOCAL)
    for force in model.forces:
        first, second = _markers(model, force, motion)
        by_position, by_rate = jax.jacfwd(
            lambda variation, rates, force=force, first=first, second=second: _force_on_local_freedoms(
                force, first, second, motion.time, variation, rates
            ),
            argnums=(0, 1),
        )(still, still)
        for sign, by_local, own_turns in ((-position, by_position, turns), (-velocity, by_rate, None)):
            top, bottom = ([sign * by_local[rows, columns] for columns in halves] for rows in halves)
            local = (top[0], top[1]), (bottom[0], bottom[1])
            _add_blocks(blocks, force, local, own_turns)
    multipliers = _all_multipliers(model, motion.multipliers)
    for joint, at, rows in zip(model.joints, linearization.joints, _joint_parts(model), strict=True):
        first, second = _markers(model, joint, motion)
        _add_blocks(
            blocks, joint, geometric_stiffness(at, first, second, position * multipliers[rows]), turns
        )
    return jnp.block(
        [
            [
                blocks.get((row, column), jnp.zeros((6 + row_body.r, 6 + column_body.r)))
                for column, column_body in enumerate(model.bodies)
            ]
            for row, row_body in enumerate(model.bodies)
        ]
    )


def _add_blocks(
    blocks: dict[tuple[int, int], Any],
    element: JointArrays | ForceArrays,
    local: Blocks,
    turns: list[jax.Array] | None,
) -> None:
    """Add an element's matrices for its local freedoms, row end by column end, to the bodies' blocks.

    With `turns`, columns are for the increments of the bodies' rotations.
    """
    for row_end, row in zip((element.first, element.second), local, strict=True):
        for column_end, part in zip((element.first, element.second), row, strict=True):
            if row_end.body < 0 or column_end.body < 0:
                continue
            columns = _on_velocities(column_end, part, None if turns is None else turns[column_end.body])
            block = jnp.concatenate([columns[:6], row_end.motion.T @ columns[6:]])
            where = row_end.body, column_end.body
            blocks[where] = blocks[where] + block if where in blocks else block


def _body_tangent(
    model: Model,
    motion: Motion,
    index: int,
    linearization: Linearization,
    turn: jax.Array,
    velocity: jax.Array,
    position: jax.Array,
) -> jax.Array:
    body = model.bodies[index]
    floating = _floating(model, motion, index)
    rotation = motion.configuration.rotations[index]
    terms = linearization.inertia[index]
    local = inertia_tangent(body.inertia, floating, terms, velocity, position)
    # a = A^T (Rddot - g) changes with the frame's rotation, da = a x dpsi, and so does the force A p.
    pushed = small_product(skew(position * floating.acceleration), turn)
    by_frame = small_product(local[:, :3], jnp.concatenate([rotation.T, pushed], axis=1))
    turned_force = jnp.pad(small_product(skew(-position * terms.force[:3]), turn), ((0, 3 + body.r), (0, 0)))
    elastic = position * linearization.stiffness[index] + velocity * body.damping
    columns = jnp.concatenate(
        [
            by_frame[:, :3],
            local[:, 3:6] + by_frame[:, 3:] + turned_force,
            local[:, 6:] + jnp.pad(elastic, ((6, 0), (0, 0))),
        ],
        axis=1,
    )
    return jnp.concatenate([small_product(rotation, columns[:3]), columns[3:]])


def _dead_force_tangent(load: DeadForceArrays, motion: Motion, turn: jax.Array) -> jax.Array:
    """Change of the generalised forces of dead loads with the body's freedoms, (6 + r, 6 + r)."""
    arms, forces = _point_forces(load, motion)
    r = load.basis.shape[2]
    # In body components dead forces turn against the frame: df = f x dpsi.
    total = jnp.zeros((6 + r, 6 + r))
    cross = jax.vmap(skew)(forces)
    total = total.at[3:6, 3:6].set(jnp.einsum("kij,kjl->il", jax.vmap(skew)(arms), cross) @ turn)
    total = total.at[6:, 3:6].set(jnp.einsum("kir,kij->rj", load.basis, cross) @ turn)
    return total.at[3:6, 6:].set(-jnp.einsum("kij,kjr->ir", cross, load.basis))
