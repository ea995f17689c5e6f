"""Linearised controllers at equilibrium: rates of their states, and the forces due to their states."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg

from supple.arrays import AnyArray
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion
from supple.equations.control_force import (
    by_body,
    first_states,
    local_forces,
    moved_markers,
    moved_with,
    rates_of,
    readings_of,
)
from supple.equations.machine_model import ControlLaw, Model
from supple.equations.marker import N_LOCAL, pose
from supple.equations.places import MatrixBlock, Places, assembled_matrix
from supple.machine import Controller, System
from supple.programs.program_cache import CachedProgram


class LinearControl(NamedTuple):
    """Equations of small changes `z` of the states of all controllers, for motions `p` and velocities `v`.

    z' = E_p p + E_v v + E_z z;      the controllers exert the forces H z
    """

    forces: AnyArray
    """`H` (n, k), forces by the states"""
    by_position: AnyArray
    """`E_p` (k, n)"""
    by_velocity: AnyArray
    """`E_v` (k, n)"""
    by_state: AnyArray
    """`E_z` (k, k)"""

    @property
    def size(self) -> int:
        """Number k of states."""
        return len(self.by_state)

    def along(self, motions: AnyArray) -> LinearControl:
        """The equations for motions `N y`, N (n, m): `N^T H`, `E_p N`, `E_v N`, `E_z`."""
        return LinearControl(
            motions.T @ self.forces, self.by_position @ motions, self.by_velocity @ motions, self.by_state
        )


class RestingControl(NamedTuple):
    """Rates of the states of all controllers, which vanish at equilibrium, and their linear equations."""

    rates: AnyArray
    """(k,)"""
    linear: LinearControl


def control_at_rest(model: Model, motion: SystemMotion) -> RestingControl:
    """The controllers, linearised at a motion that has a `resting_control`.

    The motions p are increments of the model's configuration, the velocities v those of the model.
    """
    n, k = model.n_velocities, len(first_states(model))
    if not k:
        none = np.zeros((n, 0))
        return RestingControl(np.zeros(0), LinearControl(none, none.T, none.T, np.zeros((0, 0))))
    return jax.tree.map(np.asarray, _at_rest(model, motion))


def unrest(
    system: System, control: RestingControl, position_scale: AnyArray, velocity: AnyArray, states: AnyArray
) -> dict[str, float]:
    """Rate of each state, relative to the size of its terms; keys describe the state and its rate.

    The terms are those of the linear equations for a large motion, for the velocities at equilibrium, and for
    states as large as the largest one. States are first scaled, to be comparable.

    position_scale, velocity : (n,) a large motion, and the velocities at equilibrium
    states : (k,) at equilibrium
    """
    rates, linear = control
    controllers = [own for own in system.controllers if isinstance(own, Controller)]
    if not linear.size:
        return {}
    first = np.concatenate([own.initial for own in controllers])
    # States have different units: balancing the matrix that couples them makes them comparable.
    _, (units, _) = scipy.linalg.matrix_balance(linear.by_state, permute=False, separate=True)
    largest = np.max(np.maximum(np.abs(states), np.abs(first)) / units)
    parts = abs(linear.by_position) @ position_scale + abs(linear.by_velocity) @ abs(velocity)
    parts += abs(linear.by_state) @ units * largest
    relative = abs(rates) / np.where(parts > 0, parts, np.where(rates == 0, 1.0, abs(rates)))
    names = [(own.name, number) for own in controllers for number in range(own.initial.size)]
    return {
        f"state {number} of controller '{name}' has the rate {rate:.3g}": float(part)
        for (name, number), rate, part in zip(names, rates, relative, strict=True)
    }


def _terms(model: Model, motion: SystemMotion) -> RestingControl:
    n, k = model.n_velocities, sum(np.shape(law.initial)[0] for law in model.controllers)
    rates, first = [], 0
    by_position, by_velocity, by_state, forces = [], [], [], []
    for number, law in enumerate(model.controllers):
        size = np.shape(law.initial)[0]
        if not size:
            continue
        own = Places((first,), size)
        first += size
        states = _states(motion, number)[:size]
        ends, driven = law.seen_ends, law.driven_ends
        still = jnp.zeros((len(ends), N_LOCAL))
        rated = _local_rates(law, number, motion)
        rates.append(rated(still, still, states))
        by_place, by_rate, own_change = jax.jacfwd(rated, argnums=(0, 1, 2))(still, still, states)
        by_state.append(MatrixBlock(own, own, own_change[None]))
        for columns in by_body(ends).values():
            places, carried = moved_with(ends, columns)
            for blocks, change in ((by_position, by_place), (by_velocity, by_rate)):
                local = change[:, np.array(columns)].reshape(size, -1)
                blocks.append(MatrixBlock(own, places, (local @ carried)[None]))
        pushed = jax.jacfwd(_forces_by_states(law, number, motion))(states)
        for rows in by_body(driven).values():
            places, carried = moved_with(driven, rows)
            local = pushed[np.array(rows)].reshape(-1, size)
            forces.append(MatrixBlock(places, own, (carried.T @ local)[None]))
    return RestingControl(
        jnp.concatenate(rates),
        LinearControl(
            assembled_matrix((n, k), forces),
            assembled_matrix((k, n), by_position),
            assembled_matrix((k, n), by_velocity),
            assembled_matrix((k, k), by_state),
        ),
    )


_at_rest = CachedProgram(_terms, STARTING)


def _states(motion: SystemMotion, number: int) -> jax.Array:
    """States of one controller, followed by the angles of joints."""
    assert motion.control is not None
    return jnp.asarray(motion.control.start.states[number])


def _with_states(motion: SystemMotion, number: int, states: jax.Array) -> SystemMotion:
    """The motion with other states of one controller."""
    assert motion.control is not None
    every = list(motion.control.start.states)
    every[number] = jnp.concatenate([states, jnp.asarray(every[number])[len(states) :]])
    start = motion.control.start._replace(states=tuple(every))
    return motion._replace(control=motion.control._replace(start=start))


def _local_rates(
    law: ControlLaw, number: int, motion: SystemMotion
) -> Callable[[jax.Array, jax.Array, jax.Array], jax.Array]:
    """A function of displacements and rates (e, 12) of all ends, and of the states (k,): their rates (k,)."""
    moved = moved_markers(law, motion)

    def of(variations: jax.Array, velocities: jax.Array, states: jax.Array) -> jax.Array:
        read = readings_of(law, _states(motion, number), jax.vmap(pose)(moved(variations, velocities)))
        return rates_of(law, motion.time, read, states)

    return of


def _forces_by_states(law: ControlLaw, number: int, motion: SystemMotion) -> Callable[[jax.Array], jax.Array]:
    """A function of the states: forces (a, 12) on the a driven ends."""
    still = jnp.zeros((len(law.seen_ends), N_LOCAL))
    return lambda states: local_forces(law, number, _with_states(motion, number, states))(still, still)
