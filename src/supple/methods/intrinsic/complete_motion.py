"""Motion in all modes of the bodies at some instants of a run with few modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from numpy.typing import NDArray

from supple.algebra.rotation import euler_parameters
from supple.arrays import AnyArray, FloatArray
from supple.equations.build_model import seen_coordinates
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration
from supple.integrate import FloatingMotion, Motion, Solution
from supple.machine import Placed, System
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.intrinsic_modes import IntrinsicModes
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.joined_equations import JoinedInstant, coupled_forces, coupled_wrenches
from supple.methods.intrinsic.joined_machine import JoinedArrays, JoinedMachine, joined_machine, with_stations
from supple.methods.intrinsic.line_model import LineState
from supple.methods.intrinsic.line_system import LineSystem, RootDrive, States, system_rates, system_slope
from supple.methods.intrinsic.machine_of_lines import line_motion, machine_of_lines
from supple.methods.intrinsic.released import released
from supple.methods.intrinsic.supported_root import is_joined
from supple.programs.program_cache import CachedProgram

TOLERANCE = 1e-8
"""Relative residual at which the iteration ends: its norm over the norm of frequencies times amplitudes."""
MOST_ITERATIONS = 12
"""Largest number of Newton iterations at an instant."""


class CompleteMotion(NamedTuple):
    """The machine with all modes of its bodies, and its motion at some output times.

    solution : the motion in all modes
    shown : the run at these times, expressed in all modes
    found : (t,)    False where the iteration did not converge
    """

    system: System
    solution: Solution
    shown: Solution
    found: NDArray[np.bool_]


Maps = tuple[tuple[FloatArray, FloatArray], ...]
"""`_maps` of each line."""


class _Lines(NamedTuple):
    """The lines of a machine, and its `JoinedArrays` if `is_joined`, otherwise None."""

    system: LineSystem
    joined: JoinedArrays | None


def complete_motion(system: System, solution: Solution, rows: NDArray[np.intp]) -> CompleteMotion:
    """Motion in all modes, with the elastic accelerations and strain rates of the run.

        0 = W q + N(q) q + eta + T^T f - A (q' of the run)

    W q + N(q) q + eta are the `line_rates` of the amplitudes q of all modes with loads eta. T^T f are the
    rates due to the forces f of joints and force elements. A maps amplitudes of the run to all modes.
    Root motion, rigid motion and f are those of the run. The omitted modes follow the motion statically, as
    in [Wang2015] (37), and the retained modes are corrected for the coupling with the omitted ones.

    Parameters
    ----------
    system, solution : a machine with intrinsic bodies, and its run
    rows : (t,) numbers of the output times

    Raises ModelError as `machine_of_lines`, or `joined_machine`.
    """
    placed = intrinsic_of(system)
    bodies = [body_of(each) for each in placed]
    wholes = [body.complete or body for body in bodies]
    whole_system = replace(
        system, bodies=[with_modes(each, None) if each in placed else each for each in system.bodies]
    )
    chosen = solution.at(rows)
    time = float(solution.times[0])
    maps = tuple(_maps(own.modes, other.modes) for own, other in zip(bodies, wholes, strict=True))
    states = tuple(states_of(body, chosen.bodies[body.name]) for body in bodies)
    times = jnp.asarray(chosen.times)
    if is_joined(system):
        machine = joined_machine(system, time)
        kept, whole = machine.arrays, joined_machine(whole_system, time).arrays
        wrenches = _wrenches(kept, *joined_instants(machine, chosen, times, states))
        lines = _Lines(kept.line_system, kept), _Lines(whole.line_system, whole)
    else:
        wrenches = None
        lines = tuple(_Lines(machine_of_lines(each, time).lines, None) for each in (system, whole_system))
    shown, reached, left = jax.device_get(_follow(*lines, maps, times, states, wrenches))
    drives = lines[1].system.drives
    return CompleteMotion(
        whole_system,
        replace(chosen, bodies=_motions(whole_system, drives, chosen, reached)),
        replace(chosen, bodies=_motions(whole_system, drives, chosen, shown)),
        np.asarray(left) <= TOLERANCE,
    )


def intrinsic_of(system: System) -> tuple[Placed, ...]:
    """The placed intrinsic bodies of a machine."""
    return tuple(placed for placed in system.bodies if isinstance(placed.body, IntrinsicBody))


def states_of(body: IntrinsicBody, motion: Motion) -> LineState:
    """States (leading axis: time) of a body from its motion."""
    own = motion.of_type(IntrinsicMotion)
    root = own.position + own.rotation @ body.line.tree.points[0]
    return LineState(
        q1=jnp.asarray(own.rates),
        q2=jnp.asarray(body.forces_of(own.coordinates)),
        quaternion=jax.vmap(euler_parameters)(jnp.asarray(own.rotation)),
        position=jnp.asarray(root),
    )


def joined_instants(
    machine: JoinedMachine, solution: Solution, times: jax.Array, states: States
) -> tuple[JoinedInstant, FloatArray]:
    """Instants of a run (leading axis: time), and the multipliers (t, m) of all joint equations."""
    motions = [solution.motion(placed.body.name, FloatingMotion) for placed in machine.others]
    n = len(times)

    def together(parts: Sequence[FloatArray], *shape: int) -> FloatArray:
        return np.concatenate([np.zeros((n, *shape)), *parts], axis=1)

    def seen(values: Sequence[FloatArray]) -> list[FloatArray]:
        return [
            seen_coordinates(placed.body, own) for placed, own in zip(machine.others, values, strict=True)
        ]

    floating = Configuration(
        together([motion.position[:, None] for motion in motions], 0, 3),
        together([motion.rotation[:, None] for motion in motions], 0, 3, 3),
        together(seen([motion.coordinates for motion in motions]), 0),
    )
    rates = seen([motion.coordinate_rates for motion in motions])
    velocities = [
        part
        for motion, rate in zip(motions, rates, strict=True)
        for part in (motion.velocity, motion.angular_velocity, rate)
    ]
    multipliers = [solution.multipliers[joint.name] for joint in machine.system.joints]
    return JoinedInstant(times, states, floating, together(velocities, 0)), together(multipliers, 0)


def _motions(
    system: System, drives: Sequence[RootDrive | None], solution: Solution, states: States
) -> dict[str, Motion]:
    found = dict(solution.bodies)
    for placed, drive, state in zip(intrinsic_of(system), drives, states, strict=True):
        own = solution.motion(placed.body.name, IntrinsicMotion)
        unknown = np.full(np.shape(state.q1), np.nan)
        motion = line_motion(placed, body_of(placed).model, drive, state, unknown, solution.times)
        # Positions and rotations of the roots are exactly those of the run.
        found[placed.body.name] = replace(motion, position=own.position, rotation=own.rotation)
    return found


def _maps(own: IntrinsicModes, whole: IntrinsicModes) -> tuple[FloatArray, FloatArray]:
    """Maps (m', m) of velocity and (e', e) of force amplitudes, from the retained to all modes."""
    first = whole.velocities.reshape(-1, whole.n_modes).T @ own.momenta.reshape(-1, own.n_modes)
    lengths = own.line.tree.lengths[:, None, None]
    strains = (lengths * whole.strains).reshape(-1, whole.n_elastic)
    return first, strains.T @ own.forces.reshape(-1, own.n_elastic)


def with_modes(placed: Placed, number: int | None) -> Placed:
    """The body with `number` lowest elastic modes (None: all), with strains and velocities in these modes.

    For a released body these are the lowest modes on its support before release.
    """
    own = body_of(placed)
    if number is None:
        other = own.complete or own
    else:
        held = own.supported or own
        fewer = held.truncated(min(number, (held.complete or held).n_coordinates))
        other = fewer if own.supported is None else released(fewer)
    first, second = _maps(own.modes, other.modes)
    k = own.modes.n_rigid
    forces = second @ own.forces_of(placed.coordinates)
    return replace(
        placed,
        body=other,
        coordinates=-forces / other.modes.omega[k:],
        coordinate_rates=first[k:, k:] @ placed.coordinate_rates,
    )


def _rates(lines: _Lines, time: AnyArray, states: States, wrenches: jax.Array | None) -> States:
    rates = system_rates(lines.system, time, states)
    if lines.joined is None or wrenches is None:
        return rates
    pushed = coupled_forces(lines.joined, states, wrenches)
    return tuple(replace(rate, q1=rate.q1 + own) for rate, own in zip(rates, pushed, strict=True))


def _followed(
    kept: _Lines, whole: _Lines, maps: Maps, times: jax.Array, states: States, wrenches: jax.Array | None
) -> tuple[States, States, jax.Array]:
    """The run in all modes, the complete motion, and its relative residual, at each instant."""

    def brought(now: States) -> States:
        return tuple(
            replace(state, q1=first @ state.q1, q2=second @ state.q2)
            for state, (first, second) in zip(now, maps, strict=True)
        )

    models = whole.system.lines
    elastic = np.concatenate(
        [
            np.r_[np.zeros(k), np.ones(m - k + model.omega.shape[0]), np.zeros(7)]
            for model in models
            for k, m in [(model.n_rigid, model.velocities.shape[1])]
        ]
    )
    free = np.flatnonzero(elastic)

    def at(instant: tuple[jax.Array, States, jax.Array | None]) -> tuple[States, States, jax.Array]:
        time, now, wrench = instant
        flat, unravel = ravel_pytree(brought(now))
        target = ravel_pytree(brought(_rates(kept, time, now, wrench)))[0][free]

        def missing(y: jax.Array) -> jax.Array:
            return ravel_pytree(_rates(whole, time, unravel(y), wrench))[0][free] - target

        def slope(y: jax.Array) -> jax.Array:
            of_lines = system_slope(whole.system, time, unravel(y))
            joined = whole.joined
            if joined is not None and wrench is not None:
                still = jax.tree.map(jnp.zeros_like, unravel(y))

                def pushed(y: jax.Array) -> jax.Array:
                    forces = coupled_forces(joined, unravel(y), wrench)
                    return ravel_pytree(
                        tuple(replace(none, q1=own) for none, own in zip(still, forces, strict=True))
                    )[0]

                of_lines = of_lines + jax.jacfwd(pushed)(y)
            return of_lines[np.ix_(free, free)]

        def measured(y: jax.Array, left: jax.Array) -> jax.Array:
            frequencies = jnp.concatenate(
                [
                    jnp.concatenate([jnp.zeros(model.n_rigid), model.omega, model.omega, jnp.zeros(7)])
                    for model in models
                ]
            )
            return jnp.linalg.norm(left) / (jnp.linalg.norm(frequencies * y) + 1e-300)

        def goes_on(carry: tuple[jax.Array, ...]) -> jax.Array:
            _, _, error, count = carry
            return (count < MOST_ITERATIONS) & ((count == 0) | (error > TOLERANCE))

        def improve(carry: tuple[jax.Array, ...]) -> tuple[jax.Array, ...]:
            y, left, _, count = carry
            y = y.at[free].add(-jnp.linalg.solve(slope(y), left))
            left = missing(y)
            return y, left, measured(y, left), count + 1

        left = missing(flat)
        begin = flat, left, measured(flat, left), jnp.zeros((), dtype=int)
        y, _, error, _ = jax.lax.while_loop(goes_on, improve, begin)
        return unravel(flat), unravel(y), error

    return jax.lax.map(at, (times, states, wrenches))


def _wrenches_over_time(arrays: JoinedArrays, instants: JoinedInstant, multipliers: jax.Array) -> jax.Array:
    def at(now: JoinedInstant, own: jax.Array) -> jax.Array:
        placed = now._replace(floating=with_stations(arrays, now.floating, now.lines))
        return coupled_wrenches(arrays, placed, own)

    return jax.vmap(at)(instants, multipliers)


_follow = CachedProgram(_followed, STARTING)
_wrenches = CachedProgram(_wrenches_over_time, STARTING)
