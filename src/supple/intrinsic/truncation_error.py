"""How many modes are enough: what the modes that were left out would take part in a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.algebra.rotation import euler_parameters
from supple.errors import ModelError
from supple.integrate import Solution
from supple.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.intrinsic.line_model import LineState
from supple.intrinsic.line_system import LineSystem
from supple.intrinsic.machine_of_lines import check_held_by_ground, machine_of_lines
from supple.intrinsic.residual_modes import slaved
from supple.machine import System

__all__ = ["TruncationError", "truncation_error"]

Array = NDArray[np.float64]

SWEEPS = 2
"""Of the search for the modes at rest: the first is their residual, the second what it does to itself."""


@dataclass(frozen=True, eq=False)
class TruncationError:
    """What modes left out would be, over the largest that all are: square roots of shares of energies.

    forces, velocities : (t,)       of the strain energy, and of the kinetic one
    """

    forces: Array
    velocities: Array

    @property
    def largest(self) -> float:
        """Of them all."""
        return float(max(self.forces.max(initial=0.0), self.velocities.max(initial=0.0)))


def truncation_error(
    system: System, solution: Solution, whole: Sequence[IntrinsicBody]
) -> dict[str, TruncationError]:
    """Residuals of the modes left out of a motion, as these modes would follow it at rest, by body.

        q_2H = -n_1H(q) / w_H,     q_1H = n_2H(q) / w_H

    n is what couplings and loads do to them. Modes that the motion shakes near their own frequency would be
    larger: then more must be kept.

    Parameters
    ----------
    system, solution : a machine of intrinsic bodies that the ground holds, and its run
    whole : the same bodies with more modes, or all

    Raises ModelError for another body, one that has no more modes, and a machine that joints connect.
    Source: [Wang2015] (37), as an error estimate.
    """
    check_held_by_ground(system)
    by_name = {body.name: body for body in whole}
    bodies, kept = [], []
    for placed in system.bodies:
        own, more = body_of(placed), by_name.get(placed.body.name)
        n = own.modes.n_modes
        if more is None or more.modes.n_modes <= n or not np.allclose(more.modes.omega[:n], own.modes.omega):
            raise ModelError(
                f"body '{own.name}': to see what its modes leave out, give the same body with more of them "
                "(the same line and support, a larger n_modes)"
            )
        fill = np.zeros(more.n_coordinates - own.n_coordinates)
        start, moving = (np.append(each, fill) for each in (placed.coordinates, placed.coordinate_rates))
        bodies.append(replace(placed, body=more, coordinates=start, coordinate_rates=moving))
        kept.append(n)
    lines = machine_of_lines(replace(system, bodies=bodies), float(solution.times[0])).lines
    states = tuple(_filled(by_name[p.body.name], solution.bodies[p.body.name]) for p in system.bodies)
    found = _followed(lines, tuple(kept), jnp.asarray(solution.times), states)
    return {
        placed.body.name: _error(body_of(placed).modes.n_elastic, n, state)
        for placed, n, state in zip(system.bodies, kept, found, strict=True)
    }


def _filled(body: IntrinsicBody, motion: IntrinsicMotion) -> LineState:
    """States (leading axis: time) of a body from the motion of one with fewer modes."""
    coordinates = _padded(motion.coordinates, body.n_coordinates)
    root = motion.position + motion.rotation @ body.line.tree.points[0]
    return LineState(
        q1=jnp.asarray(_padded(motion.rates, body.modes.n_modes)),
        q2=jnp.asarray(body.forces_of(coordinates)),
        quaternion=jax.vmap(euler_parameters)(jnp.asarray(motion.rotation)),
        position=jnp.asarray(root),
    )


def _padded(array: Array, size: int) -> Array:
    return np.pad(array, ((0, 0), (0, size - array.shape[1])))


def _followed(
    lines: LineSystem, kept: tuple[int, ...], times: jax.Array, states: tuple[LineState, ...]
) -> tuple[LineState, ...]:
    @jax.jit
    def over(system: LineSystem, at: jax.Array, now: tuple[LineState, ...]) -> tuple[LineState, ...]:
        return jax.vmap(lambda t, y: slaved(system, kept, t, y, SWEEPS)[0])(at, now)

    return over(lines, times, states)


def _error(n_elastic: int, n: int, state: LineState) -> TruncationError:
    forces, velocities = np.asarray(state.q2), np.asarray(state.q1)
    return TruncationError(_share(forces, n_elastic), _share(velocities, n))


def _share(amplitudes: Array, n: int) -> Array:
    largest = np.linalg.norm(amplitudes, axis=1).max(initial=0.0)
    return read_only(np.linalg.norm(amplitudes[:, n:], axis=1) / (largest or 1.0))
