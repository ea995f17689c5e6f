"""Drift of a free body's centre of mass from the path due to its loads: the momentum error of few modes."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import scipy  # its parts are imported when first used
from numpy.typing import NDArray

from supple.equations.compiler_options import STARTING
from supple.integrate import Solution
from supple.machine import System
from supple.methods.intrinsic.complete_motion import states_of
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.line_equations import momenta, station_velocities
from supple.methods.intrinsic.line_system import LineSystem, States, places_of, system_wrenches
from supple.methods.intrinsic.machine_of_lines import machine_of_lines
from supple.methods.intrinsic.supported_root import is_joined
from supple.programs.program_cache import CachedProgram

__all__ = ["centre_drift"]

Array = NDArray[np.float64]

FEWEST = 5
"""Fewest output times for which the impulse of the loads is integrated; with fewer, the drift is 0."""


def centre_drift(system: System, solution: Solution, name: str) -> float:
    """Largest distance of a free body's centre of mass from the motion due to the impulse of its loads, m.

        c(t) - c(0) - c'(0) t - 1/m int int F dt dt

    c is the centre of mass, m the mass, and F the sum of the loads. With few modes, the momentum of a bent
    free line follows the loads only approximately. F is a cubic spline through its values at the output
    times. The difference from a spline through every second value estimates the spline's error, which is
    subtracted.

    name : name of the body
    Returns 0 for a body with a supported root, if `is_joined`, and for fewer than five output times.
    """
    placed = system.bodies[system.body_index(name)]
    body = body_of(placed)
    times = solution.times
    if is_joined(system) or body.support.free.shape[1] < 6 or len(times) < FEWEST:
        return 0.0
    machine = machine_of_lines(system, float(times[0]))
    states = tuple(states_of(body_of(each), solution.bodies[each.body.name]) for each in system.bodies)
    number = system.body_index(name)
    masses = tuple(_translating(body_of(each)) for each in system.bodies)
    centre, velocity, force = jax.device_get(
        _carried(machine.lines, masses, jnp.asarray(times), states)[number]
    )
    m = body.mass
    paths = [_path(times[::skip], force[::skip] / m, times) for skip in (1, 2)]
    free = centre[0] + velocity[0] * (times - times[0])[:, None]
    away = np.linalg.norm(centre - free - paths[0], axis=1)
    unsure = np.linalg.norm(paths[0] - paths[1], axis=1)
    return float(np.maximum(away - unsure, 0.0).max())


def _path(known: Array, acceleration: Array, times: Array) -> Array:
    """Displacement (t, 3) from rest at `times`, integrated from accelerations at the times `known`."""
    return scipy.interpolate.CubicSpline(known, acceleration).antiderivative(2)(times)


def _translating(body: IntrinsicBody) -> Array:
    """(n, 6, 3) momenta of the stations in unit translations."""
    n = body.line.n
    return body.line.mass.reshape(n, 6, n, 6).sum(axis=2)[:, :, :3]


def _carried_by_lines(
    system: LineSystem, masses: tuple[jax.Array, ...], times: jax.Array, states: States
) -> tuple[tuple[jax.Array, jax.Array, jax.Array], ...]:
    """Centre of mass, its velocity, and the sum of the loads (t, 3) of each line."""
    return tuple(_carried_by(system, number, mass, times, states) for number, mass in enumerate(masses))


def _carried_by(
    system: LineSystem, number: int, mass: jax.Array, times: jax.Array, states: States
) -> tuple[jax.Array, jax.Array, jax.Array]:
    model = system.lines[number]
    own = jnp.trace(mass[:, :3], axis1=1, axis2=2) / 3
    moments = mass[:, 3:]  # skew-symmetric: mass times the offset of its centre from the station
    beside = 0.5 * jnp.stack(
        [
            moments[:, 2, 1] - moments[:, 1, 2],
            moments[:, 0, 2] - moments[:, 2, 0],
            moments[:, 1, 0] - moments[:, 0, 1],
        ],
        axis=1,
    )

    def at(instant: tuple[jax.Array, States]) -> tuple[jax.Array, jax.Array, jax.Array]:
        time, now = instant
        state = now[number]
        rotations, positions = places_of(model, system.drives[number], state, time)
        centre = (own[:, None] * positions + jnp.einsum("nij,nj->ni", rotations, beside)).sum(axis=0)
        x1 = station_velocities(model, state.q1)
        momentum = jnp.einsum("nij,nj->i", rotations, momenta(model, x1, state.q1, None)[:, :3])
        roots = tuple(None if drive is None else drive.twist(time) for drive in system.drives)
        wrench = system_wrenches(system, now, time, roots)[number]
        loads = jnp.zeros((len(own), 3)) if wrench is None else wrench[:, :3]
        return centre / own.sum(), momentum / own.sum(), jnp.einsum("nij,nj->i", rotations, loads)

    return jax.lax.map(at, (times, states))


_carried = CachedProgram(_carried_by_lines, STARTING)
