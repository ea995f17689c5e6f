"""Residuals, and their exact derivatives, of lines and floating bodies at rest or in steady rotation.

Small motions y of a line are integrals of its velocity amplitudes q_1: strains and root change by S(q) y, as
their rates are S(q) q_1. In a rotating machine, y is relative to rotating axes. With the amplitudes q_R(q) of
the line's steady rotation at zero strain rate,

    q_1 = q_R(q) + y',     q_1' = dq_R/dt + y'',     dq = S(q) y

and for frames that rotate at w about a point p, with displacements x of the origins r along global axes and
rotations psi along own axes, where A is the rotation matrix of a frame,

    v = w x (r - p) + x',             v' = w x (w x (r - p)) + 2 w x x' + x''
    w_own = A^T w + psi',             w_own' = A^T w x psi' + psi''

so that derivatives of the equations of motion by y, y' and y'' are K with centrifugal terms, C with
gyroscopic terms, and M. They are exact for the equations of the time integration.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.balance import balance
from supple.equations.compiler_options import STARTING
from supple.equations.joint_force import constraints
from supple.equations.steady_motion import SteadyRotation
from supple.methods.intrinsic.joined_equations import (
    JoinedInstant,
    JoinedRates,
    all_velocities,
    motion_residuals,
    moved_instant,
    on_amplitudes,
    seen_motion,
    steady_rates,
)
from supple.methods.intrinsic.joined_machine import JoinedArrays
from supple.methods.intrinsic.joined_start import velocity_metric
from supple.methods.intrinsic.line_equations import (
    RootTwist,
    force_rates,
    section_strains,
    station_velocities,
)
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import system_wrenches
from supple.methods.intrinsic.strain_integration import rotation_of
from supple.programs.program_cache import CachedProgram


class Unbalanced(NamedTuple):
    """Residual of a steady motion, and its terms.

    residual : (N,)         entries of floating bodies, then of the lines' amplitudes
    terms : (N, 4)          inertia, internal, applied and joint forces, which add up to the residual
    gaps : (m,)             residuals of the joints
    """

    residual: AnyArray
    terms: AnyArray
    gaps: AnyArray


class LineSmallMotions(NamedTuple):
    """`M y'' + C y' + K y + G^T l = 0`, `G y = 0`, with multipliers l; translations along global axes."""

    mass: AnyArray
    damping: AnyArray
    stiffness: AnyArray
    jacobian: AnyArray


def _parts(arrays: JoinedArrays, y: jax.Array) -> tuple[jax.Array, list[jax.Array]]:
    """Parts of a vector of motions: of floating bodies, and of each line."""
    sizes = [arrays.n_floating, *(model.velocities.shape[1] for model in arrays.lines)]
    floating, *lines = jnp.split(y, np.cumsum(sizes)[:-1])
    return floating, lines


def _moved_by(arrays: JoinedArrays, at: JoinedInstant, y: jax.Array) -> JoinedInstant:
    floating, own = _parts(arrays, y)
    lines = steady_rates(arrays, at.lines, tuple(own))
    return moved_instant(arrays, at, JoinedRates(lines, jnp.zeros_like(at.velocity), floating), jnp.zeros(()))


def _turning_line(
    model: LineModel, driven: RootTwist | None, state: LineState, w: jax.Array, point: jax.Array
) -> jax.Array:
    """q_R (m,): the root rotates as far as its support allows, at constant strains."""
    root = rotation_of(state.quaternion)
    twist = jnp.concatenate([jnp.cross(w, state.position - point) @ root, w @ root])
    if driven is not None:
        twist = twist - driven.twist
    e = section_strains(model, state.q2)

    def strain_rates(q1: jax.Array) -> jax.Array:
        return force_rates(model, station_velocities(model, q1, driven), q1, e)

    none = jnp.zeros_like(state.q1)
    own = model.velocities[:6]
    rigid = own[:, : model.n_rigid].T
    rows = jnp.concatenate([rigid @ own, jax.jacfwd(strain_rates)(none)])
    return jnp.linalg.solve(rows, jnp.concatenate([rigid @ twist, -strain_rates(none)]))


def _turning_lines(
    arrays: JoinedArrays, turning: SteadyRotation | None, now: JoinedInstant
) -> tuple[jax.Array, ...]:
    if turning is None:
        return tuple(jnp.zeros_like(state.q1) for state in now.lines)
    rates = turning.angular_velocities[arrays.n_bodies :]
    return tuple(
        _turning_line(model, None if drive is None else drive.twist(now.time), state, w, turning.point)
        for model, drive, state, w in zip(arrays.lines, arrays.drives, now.lines, rates, strict=True)
    )


def _turning_frames(
    arrays: JoinedArrays, turning: SteadyRotation | None, now: JoinedInstant, dy: jax.Array, ddy: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Velocities and accelerations (n,) of the floating bodies in steady rotation."""
    nb = arrays.n_bodies
    if turning is None or not nb:
        return dy, ddy
    places = np.array(arrays.model.frames.starts[:nb])[:, None] + np.arange(3)
    w = turning.angular_velocities[:nb]
    own = (now.floating.rotations[:nb] * w[:, :, None]).sum(axis=1)
    moving = jnp.cross(w, now.floating.origins[:nb] - turning.point)
    velocity = dy.at[places].add(moving).at[places + 3].add(own)
    faster = ddy.at[places].add(jnp.cross(w, moving + 2 * dy[places]))
    return velocity, faster.at[places + 3].add(jnp.cross(own, dy[places + 3]))


def _near(
    arrays: JoinedArrays,
    turning: SteadyRotation | None,
    at: JoinedInstant,
    y: AnyArray,
    dy: AnyArray,
    ddy: AnyArray,
) -> tuple[JoinedInstant, JoinedRates]:
    """The machine displaced by y, with rates y' and y'' relative to rotating axes."""
    now = _moved_by(arrays, at, y)
    (floating, own), (faster, own_faster) = _parts(arrays, dy), _parts(arrays, ddy)
    velocity, acceleration = _turning_frames(arrays, turning, now, floating, faster)
    steady, changes = jax.jvp(
        lambda s: _turning_lines(arrays, turning, _moved_by(arrays, at, s)), (y,), (dy,)
    )
    lines, rates = [], []
    for state, q1, by_change, first, second in zip(now.lines, steady, changes, own, own_faster, strict=True):
        still = jax.tree.map(jnp.zeros_like, state)
        lines.append(LineState(q1 + first, state.q2, state.quaternion, state.position))
        rates.append(LineState(by_change + second, still.q2, still.quaternion, still.position))
    now = now._replace(velocity=velocity, lines=tuple(lines))
    return now, JoinedRates(tuple(rates), acceleration, jnp.zeros_like(velocity))


def _residual(
    arrays: JoinedArrays, now: JoinedInstant, rates: JoinedRates, multipliers: jax.Array
) -> jax.Array:
    none = jnp.zeros(len(arrays.model.active))
    left = motion_residuals(arrays, now, rates, multipliers, none, jnp.zeros_like)
    return jnp.concatenate([left.acceleration, *(line.q1 for line in left.lines)])


def _unbalanced(
    arrays: JoinedArrays, turning: SteadyRotation | None, at: JoinedInstant, multipliers: jax.Array
) -> Unbalanced:
    n, none = arrays.n_floating, jnp.zeros(arrays.n_floating + sum(len(state.q1) for state in at.lines))
    now, rates = _near(arrays, turning, at, none, none, none)
    residual = _residual(arrays, now, rates, multipliers)
    terms = balance(arrays.model, seen_motion(arrays, now, rates, multipliers))
    back = on_amplitudes(arrays, now.lines)
    roots = tuple(None if drive is None else drive.twist(now.time) for drive in arrays.drives)
    wrenches = system_wrenches(arrays.line_system, now.lines, now.time, roots)
    columns = []
    for model, state, wrench, pushed, pulled in zip(
        arrays.lines, now.lines, wrenches, back(terms.applied[n:]), back(terms.joint[n:]), strict=True
    ):
        spread = 0.0 if wrench is None else wrench.reshape(-1) @ model.velocities
        internal = jnp.concatenate([jnp.zeros(model.n_rigid), -model.omega * state.q2])
        columns.append([internal, pushed - spread, pulled])
    internal, applied, joint = (jnp.concatenate(own) for own in zip(*columns, strict=True))
    of_lines = jnp.stack([residual[n:] - internal - applied - joint, internal, applied, joint], axis=1)
    floating = jnp.stack([terms.inertia, terms.internal, terms.applied, terms.joint], axis=1)[:n]
    gaps = constraints(arrays.model, now.time, now.floating)
    return Unbalanced(residual, jnp.concatenate([floating, of_lines]), gaps)


def _small_motions(
    arrays: JoinedArrays, turning: SteadyRotation | None, at: JoinedInstant, multipliers: jax.Array
) -> LineSmallMotions:
    none = jnp.zeros(arrays.n_floating + sum(len(state.q1) for state in at.lines))

    def residual(y: jax.Array, dy: jax.Array) -> jax.Array:
        return _residual(arrays, *_near(arrays, turning, at, y, dy, none), multipliers)

    def gaps(y: jax.Array) -> jax.Array:
        return constraints(arrays.model, at.time, _moved_by(arrays, at, y).floating)

    stiffness, damping = jax.jacfwd(residual, (0, 1))(none, none)
    return LineSmallMotions(velocity_metric(arrays, at), damping, stiffness, jax.jacfwd(gaps)(none))


def _steady(
    arrays: JoinedArrays, turning: SteadyRotation | None, at: JoinedInstant
) -> tuple[JoinedInstant, JoinedRates, jax.Array]:
    """The instant and its rates, and the velocities of all bodies of the model, in steady rotation."""
    none = jnp.zeros(arrays.n_floating + sum(len(state.q1) for state in at.lines))
    now, rates = _near(arrays, turning, at, none, none, none)
    return now, rates, all_velocities(arrays, now)


moved_by = CachedProgram(_moved_by, STARTING)
unbalanced_at = CachedProgram(_unbalanced, STARTING)
small_motions = CachedProgram(_small_motions, STARTING)
steady = CachedProgram(_steady, STARTING)
