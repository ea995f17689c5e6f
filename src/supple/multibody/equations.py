"""Equations of motion of a system of floating bodies with joints: residual, constraints and exact tangent.

    M(q) vdot + c(q, v) + f(q) + D v + G(q)^T lambda = Q(t, q, v),        g(q, t) = 0

assembled densely from the bodies' 6 + r equations each: force (global), moment about the frame origin (body
components), deformation. Source: [Wu2019] (26)-(28), (50).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from supple.algebra.rotation import rotation_exp, rotation_right_jacobian, skew
from supple.multibody.floating_inertia import FloatingMotion, floating_mass, inertia_force, inertia_tangent
from supple.multibody.joint_linearization import (
    JointLinearization,
    geometric_stiffness,
    joint_equations,
    linearize_joint,
)
from supple.multibody.marker import (
    N_LOCAL,
    Marker,
    displaced,
    generalized_force,
    with_rates,
)
from supple.multibody.model import DeadForceArrays, End, ForceArrays, JointArrays, Model
from supple.multibody.polynomial_force import polynomial_force

__all__ = [
    "Balance",
    "Configuration",
    "Joints",
    "Motion",
    "advance",
    "balance",
    "constraint_jacobian",
    "constraints",
    "linearize_joints",
    "mass_matrix",
    "tangent",
]


class Configuration(NamedTuple):
    """Position of every body: frame origins (nb, 3), frame rotations (nb, 3, 3), coordinates (r,) each."""

    origins: jax.Array
    rotations: jax.Array
    coordinates: tuple[jax.Array, ...]


class Motion(NamedTuple):
    """What the equations are evaluated at."""

    time: jax.Array
    configuration: Configuration
    velocity: jax.Array
    """(n,)"""
    acceleration: jax.Array
    """(n,)"""
    multipliers: jax.Array
    """(m,)"""


class Balance(NamedTuple):
    """The terms in balance, each (n,); their sum is the residual."""

    inertia: jax.Array
    internal: jax.Array
    applied: jax.Array
    joint: jax.Array
    stiffness: tuple[jax.Array, ...]
    """Tangent of each body's internal force (r, r), a by-product."""

    @property
    def residual(self) -> jax.Array:
        """The unbalanced force, (n,)."""
        return self.inertia + self.internal + self.applied + self.joint


def advance(model: Model, configuration: Configuration, increment: jax.Array) -> Configuration:
    """The configuration moved by an increment (n,) of the kind `velocity * time`."""
    origins, rotations, coordinates = [], [], []
    for index, part in enumerate(model.slices):
        step = increment[part]
        origins.append(configuration.origins[index] + step[:3])
        rotations.append(configuration.rotations[index] @ rotation_exp(step[3:6]))
        coordinates.append(configuration.coordinates[index] + step[6:])
    return Configuration(jnp.stack(origins), jnp.stack(rotations), tuple(coordinates))


def _floating(model: Model, motion: Motion, index: int) -> FloatingMotion:
    part = model.slices[index]
    velocity, acceleration = motion.velocity[part], motion.acceleration[part]
    rotation = motion.configuration.rotations[index]
    return FloatingMotion(
        coordinates=motion.configuration.coordinates[index],
        spin=velocity[3:6],
        rates=velocity[6:],
        acceleration=rotation.T @ (acceleration[:3] - model.gravity),
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
    local = end.selection[6:, 6:] @ configuration.coordinates[end.body]
    local_rates = end.selection[6:, 6:] @ own[6:]
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


Joints = tuple[JointLinearization, ...]
"""Every joint of a model at one configuration."""


def _law_value(law: Any, time: jax.Array) -> Any:
    return None if law is None else law(time)


def _markers(model: Model, element: JointArrays | ForceArrays, motion: Motion) -> tuple[Marker, Marker]:
    return (
        marker(model, element.first, motion.configuration, motion.velocity),
        marker(model, element.second, motion.configuration, motion.velocity),
    )


def _scatter(
    model: Model, element: JointArrays | ForceArrays, local: jax.Array, total: jax.Array
) -> jax.Array:
    """Add the local generalised forces (24,) of both ends to the bodies' equations."""
    for end, part in ((element.first, local[:N_LOCAL]), (element.second, local[N_LOCAL:])):
        if end.body >= 0:
            total = total.at[model.slices[end.body]].add(end.selection.T @ part)
    return total


def _joint_parts(model: Model) -> list[slice]:
    starts = [0]
    for joint in model.joints:
        starts.append(starts[-1] + joint.n_constraints)
    return [slice(a, b) for a, b in zip(starts[:-1], starts[1:], strict=True)]


def _all_multipliers(model: Model, multipliers: jax.Array) -> jax.Array:
    return jnp.zeros(model.n_equations).at[jnp.array(model.active, dtype=int)].set(multipliers)


def _ends_at(model: Model, element: JointArrays, configuration: Configuration) -> tuple[Marker, Marker]:
    """Both markers of a joint in a configuration at rest."""
    at_rest = jnp.zeros(model.n_velocities)
    return (
        marker(model, element.first, configuration, at_rest),
        marker(model, element.second, configuration, at_rest),
    )


def _active_rows(model: Model, rows: list[jax.Array]) -> jax.Array:
    return jnp.concatenate(rows)[jnp.array(model.active, dtype=int)]


def linearize_joints(model: Model, time: jax.Array, configuration: Configuration) -> Joints:
    """Equations and derivatives of every joint, once for all that need them."""
    return tuple(
        linearize_joint(joint, *_ends_at(model, joint, configuration), time) for joint in model.joints
    )


def constraints(
    model: Model, time: jax.Array, configuration: Configuration, joints: Joints | None = None
) -> jax.Array:
    """Active constraint equations `g(q, t)`, (m,); `joints` where they are linearised already."""
    if not model.joints:
        return jnp.zeros(0)
    if joints is not None:
        return _active_rows(model, [at.equations for at in joints])
    return _active_rows(
        model,
        [joint_equations(joint, *_ends_at(model, joint, configuration), time) for joint in model.joints],
    )


def constraint_jacobian(
    model: Model,
    time: jax.Array,
    configuration: Configuration,
    increments: jax.Array | None = None,
    joints: Joints | None = None,
) -> jax.Array:
    """Derivative `G` of the active equations for the velocities, (m, n).

    With `increments` (n,), for the increments that led here instead: `dpsi = T(increment) dincrement`.
    `joints` where they are linearised already.
    """
    if not model.joints:
        return jnp.zeros((0, model.n_velocities))
    rows = []
    for joint, at in zip(
        model.joints, joints or linearize_joints(model, time, configuration), strict=True
    ):
        row = jnp.zeros((joint.n_constraints, model.n_velocities))
        for end, part in zip((joint.first, joint.second), at.by_end, strict=True):
            if end.body >= 0:
                moves = _selection_by_increment(model, end, increments)
                row = row.at[:, model.slices[end.body]].add(part @ moves)
        rows.append(row)
    return _active_rows(model, rows)


def _turn_by_increment(model: Model, index: int, increments: jax.Array) -> jax.Array:
    return rotation_right_jacobian(increments[model.slices[index]][3:6])


def _selection_by_increment(model: Model, end: End, increments: jax.Array | None) -> jax.Array:
    """The marker's selection with the frame's rotation parametrised by its increment over the step."""
    if increments is None:
        return jnp.asarray(end.selection)
    turn = _turn_by_increment(model, end.body, increments)
    return jnp.asarray(end.selection).at[3:6, 3:6].set(turn)


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


def _point_forces(model: Model, load: DeadForceArrays, motion: Motion) -> _PointForces:  # noqa: ARG001
    configuration = motion.configuration
    coordinates = configuration.coordinates[load.body]
    arms = load.positions + jnp.einsum("kir,r->ki", load.basis, coordinates)
    forces = jnp.broadcast_to(jnp.asarray(load.law(motion.time)), arms.shape)
    return _PointForces(arms, forces @ configuration.rotations[load.body])


def balance(model: Model, motion: Motion, joints: Joints | None = None) -> Balance:
    """All terms of the equations of motion; `joints` where they are linearised already."""
    zero = jnp.zeros(model.n_velocities)
    inertia, internal, stiffness = [], [], []
    for index, body in enumerate(model.bodies):
        floating = _floating(model, motion, index)
        own = inertia_force(body.gram, floating)
        rotation = motion.configuration.rotations[index]
        inertia.append(jnp.concatenate([rotation @ own[:3], own[3:]]))
        force, tangent_stiffness = polynomial_force(
            body.stiffness, body.cubic, body.quartic, floating.coordinates
        )
        internal.append(jnp.concatenate([jnp.zeros(6), force + body.damping @ floating.rates]))
        stiffness.append(tangent_stiffness)
    applied = zero
    for load in model.dead_forces:
        arms, forces = _point_forces(model, load, motion)
        total = motion.configuration.rotations[load.body] @ forces.sum(axis=0)
        generalized = jnp.concatenate(
            [total, jnp.cross(arms, forces).sum(axis=0), jnp.einsum("kir,ki->r", load.basis, forces)]
        )
        applied = applied.at[model.slices[load.body]].add(-generalized)
    still = jnp.zeros(2 * N_LOCAL)
    for force in model.forces:
        first, second = _markers(model, force, motion)
        local = _force_on_local_freedoms(force, first, second, motion.time, still, still)
        applied = _scatter(model, force, -local, applied)
    joint_forces = zero
    multipliers = _all_multipliers(model, motion.multipliers)
    joints = joints or linearize_joints(model, motion.time, motion.configuration)
    for joint, at, rows in zip(model.joints, joints, _joint_parts(model), strict=True):
        local = jnp.concatenate([part.T @ multipliers[rows] for part in at.by_end])
        joint_forces = _scatter(model, joint, local, joint_forces)
    return Balance(
        jnp.concatenate(inertia), jnp.concatenate(internal), applied, joint_forces, tuple(stiffness)
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
    stiffness: tuple[jax.Array, ...],
    increments: jax.Array,
    velocity: jax.Array,
    position: jax.Array,
    joints: Joints | None = None,
) -> jax.Array:
    """Derivative of the residual for the new accelerations, (n, n).

    The velocities follow the accelerations with the factor `velocity`, the increments of the configuration
    with the factor `position` (`StepRule`); `joints` where they are linearised already.
    """
    matrix = jnp.zeros((model.n_velocities, model.n_velocities))
    for index in range(len(model.bodies)):
        block = _body_tangent(model, motion, index, stiffness[index], increments, velocity, position)
        matrix = matrix.at[model.slices[index], model.slices[index]].add(block)
    for load in model.dead_forces:
        block = _dead_force_tangent(model, load, motion, increments)
        matrix = matrix.at[model.slices[load.body], model.slices[load.body]].add(-position * block)
    still = jnp.zeros(2 * N_LOCAL)
    for force in model.forces:
        first, second = _markers(model, force, motion)
        by_position, by_rate = jax.jacfwd(
            lambda variation, rates, force=force, first=first, second=second: _force_on_local_freedoms(
                force, first, second, motion.time, variation, rates
            ),
            argnums=(0, 1),
        )(still, still)
        matrix = _scatter_matrix(
            model, force, -position * by_position, -velocity * by_rate, increments, matrix
        )
    multipliers = _all_multipliers(model, motion.multipliers)
    joints = joints or linearize_joints(model, motion.time, motion.configuration)
    for joint, at, rows in zip(model.joints, joints, _joint_parts(model), strict=True):
        first, second = _markers(model, joint, motion)
        geometric = geometric_stiffness(joint, at, first, second, motion.time, multipliers[rows])
        matrix = _scatter_matrix(model, joint, position * geometric, None, increments, matrix)
    return matrix


def _body_tangent(
    model: Model,
    motion: Motion,
    index: int,
    stiffness: jax.Array,
    increments: jax.Array,
    velocity: jax.Array,
    position: jax.Array,
) -> jax.Array:
    body = model.bodies[index]
    floating = _floating(model, motion, index)
    rotation = motion.configuration.rotations[index]
    local = inertia_tangent(body.gram, floating, velocity, position)
    force = inertia_force(body.gram, floating)[:3]
    turn = position * _turn_by_increment(model, index, increments)
    # a = A^T (Rddot - g) changes with the frame's rotation, da = a x dpsi, and so does the force A p.
    by_turn = local[:, :3] @ skew(floating.acceleration) @ turn
    local = local.at[:, 3:6].add(by_turn)
    local = local.at[:3, 3:6].add(-skew(force) @ turn)
    local = local.at[6:, 6:].add(position * stiffness + velocity * body.damping)
    local = local.at[:, :3].set(local[:, :3] @ rotation.T)
    return local.at[:3].set(rotation @ local[:3])


def _dead_force_tangent(
    model: Model, load: DeadForceArrays, motion: Motion, increments: jax.Array
) -> jax.Array:
    """Change of the generalised forces of dead loads with the body's freedoms, (6 + r, 6 + r)."""
    arms, forces = _point_forces(model, load, motion)
    turn = _turn_by_increment(model, load.body, increments)
    r = load.basis.shape[2]
    # In body components dead forces turn against the frame: df = f x dpsi.
    total = jnp.zeros((6 + r, 6 + r))
    cross = jax.vmap(skew)(forces)
    total = total.at[3:6, 3:6].set(jnp.einsum("kij,kjl->il", jax.vmap(skew)(arms), cross) @ turn)
    total = total.at[6:, 3:6].set(jnp.einsum("kir,kij->rj", load.basis, cross) @ turn)
    return total.at[3:6, 6:].set(-jnp.einsum("kij,kjr->ir", cross, load.basis))


def _scatter_matrix(
    model: Model,
    element: JointArrays | ForceArrays,
    by_position: jax.Array,
    by_rate: jax.Array | None,
    increments: jax.Array,
    matrix: jax.Array,
) -> jax.Array:
    """Add a local matrix (24, 24), for increments and for rates, to the bodies' tangent."""
    ends = ((element.first, slice(0, N_LOCAL)), (element.second, slice(N_LOCAL, 2 * N_LOCAL)))
    for row_end, rows in ends:
        for column_end, columns in ends:
            if row_end.body < 0 or column_end.body < 0:
                continue
            moves = _selection_by_increment(model, column_end, increments)
            block = by_position[rows, columns] @ moves
            if by_rate is not None:
                block = block + by_rate[rows, columns] @ column_end.selection
            matrix = matrix.at[model.slices[row_end.body], model.slices[column_end.body]].add(
                row_end.selection.T @ block
            )
    return matrix
