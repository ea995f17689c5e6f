"""A run of few modes at some instants as all modes of its bodies would carry it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from numpy.typing import NDArray

from supple.algebra.kept_programs import KeptProgram
from supple.algebra.rotation import euler_parameters
from supple.integrate import Solution
from supple.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.intrinsic.intrinsic_modes import IntrinsicModes
from supple.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.intrinsic.line_model import LineState
from supple.intrinsic.line_slope import system_slope
from supple.intrinsic.line_system import LineSystem, States, system_rates
from supple.intrinsic.machine_of_lines import MachineOfLines, machine_of_lines
from supple.machine import Placed, System
from supple.multibody.equations.compiler_options import STARTING

__all__ = ["CompleteMotion", "complete_motion", "states_of", "with_modes"]

Array = NDArray[np.float64]

TOLERANCE = 1e-8
"""Of the rates that all modes would have, were they at rest in the others' motion."""
MOST_ITERATIONS = 12


class CompleteMotion(NamedTuple):
    """The machine with all modes of its bodies, and its motion at the instants looked at.

    shown : the run itself at these instants, in all modes
    found : (t,)    False where no such motion was found
    """

    system: System
    solution: Solution
    shown: Solution
    found: NDArray[np.bool_]


def complete_motion(system: System, solution: Solution, rows: NDArray[np.intp]) -> CompleteMotion:
    """The elastic amplitudes of all modes at which accelerations and strain rates are those of the run.

        0 = W q + N(q) q + eta - A (q' of the run)

    A brings amplitudes of the run to those of all modes; root and rigid motion are the run's. The modes left
    out follow the motion, as [Wang2015] (37) has them, and the kept ones give way to what these do to them.

    Parameters
    ----------
    system, solution : bodies that the ground holds, or free ones, and their run
    rows : (t,) output times to look at

    Raises ModelError as `machine_of_lines`.
    """
    bodies = [body_of(placed) for placed in system.bodies]
    wholes = [body.complete or body for body in bodies]
    whole_system = replace(system, bodies=[with_modes(placed, None) for placed in system.bodies])
    chosen = solution.at(rows)
    time = float(solution.times[0])
    kept, whole = machine_of_lines(system, time), machine_of_lines(whole_system, time)
    maps = tuple(_maps(own.modes, other.modes) for own, other in zip(bodies, wholes, strict=True))
    states = tuple(states_of(body, chosen.bodies[body.name]) for body in bodies)
    times = jnp.asarray(chosen.times)
    shown, reached, left = jax.device_get(_follow(kept.lines, whole.lines, maps, times, states))
    return CompleteMotion(
        whole_system,
        replace(chosen, bodies=_motions(whole, chosen, reached)),
        replace(chosen, bodies=_motions(whole, chosen, shown)),
        np.asarray(left) <= TOLERANCE,
    )


def states_of(body: IntrinsicBody, motion: IntrinsicMotion) -> LineState:
    """States (leading axis: time) of a body from its motion."""
    root = motion.position + motion.rotation @ body.line.tree.points[0]
    return LineState(
        q1=jnp.asarray(motion.rates),
        q2=jnp.asarray(body.forces_of(motion.coordinates)),
        quaternion=jax.vmap(euler_parameters)(jnp.asarray(motion.rotation)),
        position=jnp.asarray(root),
    )


def _motions(machine: MachineOfLines, solution: Solution, states: States) -> dict[str, Any]:
    found = machine.motions(solution.times, states)
    # Driven roots are where the drive has them; the others are the run's to the last digit.
    return {
        name: replace(motion, position=own.position, rotation=own.rotation)
        for name, motion in found.items()
        for own in [solution.bodies[name]]
    }


def _maps(own: IntrinsicModes, whole: IntrinsicModes) -> tuple[Array, Array]:
    """Amplitudes (m', m) of velocities, and (e', e) of forces, in all modes by those of the kept ones."""
    first = whole.velocities.reshape(-1, whole.n_modes).T @ own.momenta.reshape(-1, own.n_modes)
    lengths = own.line.tree.lengths[:, None, None]
    strains = (lengths * whole.strains).reshape(-1, whole.n_elastic)
    return first, strains.T @ own.forces.reshape(-1, own.n_elastic)


def with_modes(placed: Placed, number: int | None) -> Placed:
    """The body with a number of its lowest modes, or all, placed with the same strains and velocities."""
    own = body_of(placed)
    other = (
        (own.complete or own)
        if number is None
        else own.truncated(min(number, (own.complete or own).n_coordinates))
    )
    first, second = _maps(own.modes, other.modes)
    k = own.modes.n_rigid
    forces = second @ own.forces_of(placed.coordinates)
    return replace(
        placed,
        body=other,
        coordinates=-forces / other.modes.omega[k:],
        coordinate_rates=first[k:, k:] @ placed.coordinate_rates,
    )


def _followed(
    kept: LineSystem, whole: LineSystem, maps: Any, times: jax.Array, states: States
) -> tuple[States, States, jax.Array]:
    """The run in all modes, the complete motion, and what it leaves of its equations, at each instant."""

    def brought(now: States) -> States:
        return tuple(
            replace(state, q1=first @ state.q1, q2=second @ state.q2)
            for state, (first, second) in zip(now, maps, strict=True)
        )

    elastic = np.concatenate(
        [
            np.r_[np.zeros(k), np.ones(m - k + model.omega.shape[0]), np.zeros(7)]
            for model in whole.lines
            for k, m in [(model.n_rigid, model.velocities.shape[1])]
        ]
    )
    free = np.flatnonzero(elastic)

    def at(instant: tuple[jax.Array, States]) -> tuple[States, States, jax.Array]:
        time, now = instant
        flat, unravel = ravel_pytree(brought(now))
        target = ravel_pytree(brought(system_rates(kept, time, now)))[0][free]

        def missing(y: jax.Array) -> jax.Array:
            return ravel_pytree(system_rates(whole, time, unravel(y)))[0][free] - target

        def measured(y: jax.Array, left: jax.Array) -> jax.Array:
            frequencies = jnp.concatenate(
                [
                    jnp.concatenate([jnp.zeros(model.n_rigid), model.omega, model.omega, jnp.zeros(7)])
                    for model in whole.lines
                ]
            )
            return jnp.linalg.norm(left) / (jnp.linalg.norm(frequencies * y) + 1e-300)

        def goes_on(carry: Any) -> jax.Array:
            _, _, error, count = carry
            return (count < MOST_ITERATIONS) & ((count == 0) | (error > TOLERANCE))

        def improve(carry: Any) -> Any:
            y, left, _, count = carry
            slope = system_slope(whole, time, unravel(y))[np.ix_(free, free)]
            y = y.at[free].add(-jnp.linalg.solve(slope, left))
            left = missing(y)
            return y, left, measured(y, left), count + 1

        left = missing(flat)
        begin = flat, left, measured(flat, left), jnp.zeros((), dtype=int)
        y, _, error, _ = jax.lax.while_loop(goes_on, improve, begin)
        return unravel(flat), unravel(y), error

    return jax.lax.map(at, (times, states))


_follow = KeptProgram(_followed, STARTING)
