"""Equations of motion of lines and floating bodies connected by joints.

The pose of a station follows from the strains and the root. Its velocities are linear in the line's
amplitudes q_1, V_s = T(q) q_1, and T^T maps forces of force elements, Q, and of joints to amplitudes:

    line            q_1' = .. + T^T (Q - G^T lambda),     (q_2, root)' = S(q) (q_1 + T^T G^T mu)
    floating body   M V' + c + f - Q + G^T lambda = 0,    q' = V + M^-1 G^T mu
    joints          g(t, q) = 0,     G V + dg/dt = 0

S maps q_1 to the rates of q_2 and of the root, c are gyroscopic and f internal forces, and G = dg/dq.
Joints do no work on velocities that satisfy them, and T is the exact derivative of the positions in g. So
energy is conserved for any number of modes or stations. mu vanishes with the step; it keeps both positions
and velocities on the constraints.
Source: C. W. Gear, B. Leimkuhler, G. K. Gupta, "Automatic integration of Euler-Lagrange equations with
constraints", J. Comput. Appl. Math. 12-13 (1985) 77-90, for mu.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray
from supple.equations import joint_force
from supple.equations.balance import balance
from supple.equations.configuration import Configuration, ControlStep, SystemMotion, advance
from supple.equations.joint_force import constraints
from supple.equations.places import assembled_vector
from supple.methods.intrinsic.equal_lines import for_each_line
from supple.methods.intrinsic.joined_machine import JoinedArrays, coupled_places, with_stations
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    force_rates,
    line_rates,
    section_strains,
    station_velocities,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import States, root_rates, system_wrenches


class JoinedInstant(NamedTuple):
    """Positions and velocities of the machine.

    floating : Configuration    configuration of all bodies of the model, including stations
    velocity : (n,)             velocities of the floating bodies
    """

    time: AnyArray
    lines: States
    floating: Configuration
    velocity: AnyArray


class JoinedRates(NamedTuple):
    """Rates of an instant.

    lines : q_1', q_2' and the root's rates, of each line
    acceleration : (n,)     accelerations of the floating bodies
    frames : (n,)           rates of the floating bodies' configuration, V + M^-1 G^T mu
    """

    lines: States
    acceleration: AnyArray
    frames: AnyArray


def shape_rates(model: LineModel, state: LineState, q1: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Rates of q_2, and of the root's quaternion and position, linear in amplitudes of velocities."""
    x1 = station_velocities(model, q1)
    forces = force_rates(model, x1, q1, section_strains(model, state.q2))
    return forces, *root_rates(model, q1, state.quaternion)


def steady_rates(arrays: JoinedArrays, states: States, amplitudes: tuple[jax.Array, ...]) -> States:
    """Rates of the states of each line at constant amplitudes q_1 of velocities."""

    def rates(model: LineModel, state: LineState, q1: jax.Array) -> LineState:
        return LineState(jnp.zeros_like(q1), *shape_rates(model, state, q1))

    return for_each_line(rates, arrays.lines, states, amplitudes)


def station_twists(arrays: JoinedArrays, states: States, amplitudes: tuple[jax.Array, ...]) -> jax.Array:
    """Velocities (global) and angular velocities (own axes) of the coupled stations, (6 s,)."""
    rates = steady_rates(arrays, states, amplitudes)
    (_, rotations), (velocities, turning) = jax.jvp(
        lambda at: coupled_places(arrays, at), (states,), (rates,)
    )
    skew = (rotations[:, :, :, None] * turning[:, :, None, :]).sum(axis=1)
    spin = jnp.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    return jnp.concatenate([velocities, spin], axis=1).reshape(-1)


def coupled_forces(arrays: JoinedArrays, states: States, wrenches: jax.Array) -> tuple[jax.Array, ...]:
    """T^T f for forces and moments f (6 s,) on the coupled stations: forces on each line's amplitudes."""
    return on_amplitudes(arrays, states)(wrenches)


def on_amplitudes(arrays: JoinedArrays, states: States) -> Callable[[jax.Array], tuple[jax.Array, ...]]:
    """`coupled_forces` as a function of the forces, for several of them."""
    amplitudes = tuple(state.q1 for state in states)
    _, back = jax.vjp(lambda q1: station_twists(arrays, states, q1), amplitudes)
    return lambda wrenches: back(wrenches)[0]


def coupled_wrenches(arrays: JoinedArrays, now: JoinedInstant, multipliers: jax.Array) -> jax.Array:
    """Forces (global) and moments (own axes) of joints and force elements on coupled stations, (6 s,).

    now : instant with its stations placed,  multipliers : (m,) of the active equations
    """
    still = jnp.zeros(arrays.model.n_velocities)
    seen = SystemMotion(now.time, now.floating, all_velocities(arrays, now), still, multipliers)
    return -balance(arrays.model, seen).residual[arrays.n_floating :]


def all_velocities(arrays: JoinedArrays, now: JoinedInstant) -> jax.Array:
    """Velocities (N,) of the model's bodies: floating ones, then stations."""
    twists = station_twists(arrays, now.lines, tuple(state.q1 for state in now.lines))
    return jnp.concatenate([now.velocity, twists])


def residuals_of_joints(arrays: JoinedArrays, now: JoinedInstant) -> tuple[jax.Array, jax.Array]:
    """Residuals g, and G V + dg/dt, of the active equations, (m,) each; stations of `now` are placed."""
    model, time, at = arrays.model, jnp.asarray(now.time, dtype=float), now.floating
    joints = joint_force.linearized(model, time, at)
    rates = joint_force.constraint_rows(model, joints) @ all_velocities(arrays, now)
    if any(group.law is not None for group in model.joints):
        rates = rates + jax.jvp(lambda t: constraints(model, t, at), (time,), (jnp.ones_like(time),))[1]
    return joint_force.residuals(model, joints), rates


def moved_instant(
    arrays: JoinedArrays, now: JoinedInstant, change: JoinedRates, time: AnyArray
) -> JoinedInstant:
    """The instant after a time `time`; `change` contains the rates multiplied by this time."""
    increment = jnp.concatenate([change.frames, jnp.zeros(6 * arrays.n_coupled)])
    lines = jax.tree.map(jnp.add, now.lines, change.lines)
    floating = advance(arrays.model, now.floating, increment)
    return JoinedInstant(
        now.time + time, lines, with_stations(arrays, floating, lines), now.velocity + change.acceleration
    )


def seen_motion(
    arrays: JoinedArrays,
    now: JoinedInstant,
    rates: JoinedRates,
    multipliers: AnyArray,
    control: ControlStep | None = None,
) -> SystemMotion:
    """Motion of floating bodies and stations as the input of joints, forces and controllers."""
    accelerations = jnp.concatenate([rates.acceleration, jnp.zeros(6 * arrays.n_coupled)])
    velocities = all_velocities(arrays, now)
    return SystemMotion(now.time, now.floating, velocities, accelerations, multipliers, control)


def motion_residuals(
    arrays: JoinedArrays,
    now: JoinedInstant,
    rates: JoinedRates,
    multipliers: jax.Array,
    closing: jax.Array,
    softness: Callable[[jax.Array], jax.Array],
    control: ControlStep | None = None,
) -> JoinedRates:
    """Residuals of the equations of motion at given rates.

    multipliers : (m,) lambda,  closing : (m,) mu
    softness : function that multiplies forces (n,) on the floating bodies by M^-1
    control : step of the machine's controllers; None without controllers
    """
    model, n = arrays.model, arrays.n_floating
    balanced = balance(model, seen_motion(arrays, now, rates, multipliers, control))
    left = balanced.residual
    push = assembled_vector(
        model.n_velocities, joint_force.force(model, balanced.linearization.joints, closing)
    )
    back = on_amplitudes(arrays, now.lines)
    forces, pushed = back(-left[n:]), back(push[n:])
    roots = tuple(None if drive is None else drive.twist(now.time) for drive in arrays.drives)
    wrenches = system_wrenches(arrays.line_system, now.lines, now.time, roots)
    lines = for_each_line(
        _line_residual, arrays.lines, now.lines, rates.lines, wrenches, roots, forces, pushed
    )
    return JoinedRates(lines, left[:n], rates.frames - now.velocity - softness(push[:n]))


def _line_residual(
    model: LineModel,
    state: LineState,
    rate: LineState,
    wrench: jax.Array | None,
    root: RootTwist | None,
    force: jax.Array,
    shift: jax.Array,
) -> LineState:
    """Residual of the equations of one line; `shift` is added to q_1 in the rates of the other states."""
    first, _ = line_rates(model, state.q1, state.q2, wrench, root)
    found = LineState(first + force, *shape_rates(model, state, state.q1 + shift))
    return jax.tree.map(jnp.subtract, rate, found)
