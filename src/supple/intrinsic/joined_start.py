"""A consistent start of joined lines and floating bodies: velocities on the joints, rates, joint forces."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from supple.algebra.kept_programs import KeptProgram
from supple.errors import ModelError, StartWarning
from supple.intrinsic.joined_equations import (
    Instant,
    Motion,
    joint_rates,
    motion_residuals,
    moved,
    shape_rates,
)
from supple.intrinsic.joined_machine import JoinedArrays, JoinedMachine, seen_model, with_stations
from supple.intrinsic.line_model import LineState
from supple.multibody.equations.build_model import row_scales
from supple.multibody.equations.compiler_options import STARTING
from supple.multibody.equations.consistent_start import (
    independent_constraints,
    placed_configuration,
    placed_velocity,
)
from supple.multibody.equations.inertia import mass_matrix
from supple.multibody.equations.joint_force import constraints

__all__ = ["JoinedStart", "instant_rates", "joined_start"]

OPEN = 1e-6
"""Of the machine's size, and rad."""
CHANGED = 1e-5
"""Of the kinetic energy."""


class JoinedStart(NamedTuple):
    """The machine without redundant equations, and where and how it begins, on its joints."""

    arrays: JoinedArrays
    now: Instant


def joined_start(machine: JoinedMachine, time: float) -> JoinedStart:
    """Velocities are changed by the least motion, in kinetic energy, that the joints allow.

    Raises ModelError for a joint that is open. Warns StartWarning of velocities that joints do not allow,
    RedundantConstraintWarning of joints that hold what others hold.
    """
    arrays, seen = machine.arrays, machine.seen
    placed = jax.tree.map(jnp.asarray, placed_configuration(seen))
    given = Instant(
        jnp.asarray(float(time)),
        machine.states,
        placed,
        jnp.asarray(placed_velocity(seen)[: arrays.n_floating]),
    )
    now, gaps, rows, missed, metric = _BEGUN(arrays, given)
    _check_closed(machine, np.asarray(gaps))
    active = independent_constraints(seen, np.asarray(rows), np.asarray(metric))
    if len(active) < len(gaps):
        n_floating = len(arrays.model.sizes) - arrays.n_held
        arrays = replace(arrays, model=seen_model(seen, n_floating, active))
        rows, missed = rows[np.array(active)], missed[np.array(active)]
    if len(active):
        now = _on_joints(machine, now, np.asarray(rows), np.asarray(missed), np.asarray(metric))
    return JoinedStart(arrays, now)


def _begun(
    arrays: JoinedArrays, given: Instant
) -> tuple[Instant, jax.Array, jax.Array, jax.Array, jax.Array]:
    """The instant with its stations in place, and of its joints the gaps, rows and rates; the metric."""
    now = given._replace(floating=with_stations(arrays, given.floating, given.lines))
    gaps = constraints(arrays.model, now.time, now.floating)
    return now, gaps, *_rows(arrays, now), _metric(arrays, now)


def _check_closed(machine: JoinedMachine, gaps: np.ndarray) -> None:
    labels = [(joint.name, row) for joint in machine.system.joints for row in joint.rows]
    relative = np.abs(gaps) / row_scales(machine.seen)
    if relative.max(initial=0.0) > OPEN:
        worst = int(np.argmax(relative))
        joint, row = labels[worst]
        raise ModelError(
            f"joint '{joint}' is open in the initial configuration: {row} is off by {gaps[worst]:.3g}. Place "
            "the bodies so that both ends meet; an intrinsic body is as bent as its coordinates say"
        )


def _velocities(now: Instant) -> tuple[Any, Any]:
    return now.velocity, tuple(state.q1 for state in now.lines)


def _with_velocities(now: Instant, velocities: tuple[Any, Any]) -> Instant:
    floating, amplitudes = velocities
    lines = tuple(replace(state, q1=q1) for state, q1 in zip(now.lines, amplitudes, strict=True))
    return now._replace(velocity=floating, lines=lines)


def _rows(arrays: JoinedArrays, now: Instant) -> tuple[jax.Array, jax.Array]:
    """Derivative (m, z) of the rates of the joints' equations for all velocities, and these rates."""
    flat, unravel = ravel_pytree(_velocities(now))

    def rates(velocities: jax.Array) -> jax.Array:
        return joint_rates(arrays, _with_velocities(now, unravel(velocities)))

    return jax.jacfwd(rates)(flat), rates(flat)


def _metric(arrays: JoinedArrays, now: Instant) -> jax.Array:
    """Mass matrix of all velocities: modes are mass-normal."""
    n = arrays.n_floating
    lines = sum(len(state.q1) for state in now.lines)
    metric = jnp.eye(n + lines)
    return metric.at[:n, :n].set(mass_matrix(arrays.model, now.floating)[:n, :n])


def _on_joints(
    machine: JoinedMachine, now: Instant, rows: np.ndarray, missed: np.ndarray, metric: np.ndarray
) -> Instant:
    flat, unravel = ravel_pytree(_velocities(now))
    soft = np.linalg.solve(metric, rows.T)
    change = -soft @ np.linalg.solve(rows @ soft, missed)
    given = np.asarray(flat)
    energy, lost = given @ metric @ given, change @ metric @ change
    if energy > 0 and lost > CHANGED * energy:
        after = (given + change) @ metric @ (given + change)
        names = ", ".join(f"'{joint.name}'" for joint in machine.system.joints)
        warnings.warn(
            f"the joints ({names}) do not allow the initial velocities, which were changed: the kinetic "
            f"energy is {after / 2:.4g} instead of {energy / 2:.4g}. Give velocities that the joints allow",
            StartWarning,
            stacklevel=2,
        )
    return _with_velocities(now, unravel(flat + change))


def instant_rates(arrays: JoinedArrays, now: Instant) -> tuple[Motion, jax.Array]:
    """Rates of an instant on its joints, and the multipliers of these.

    Equations of motion and d2g/dt2 = 0:  M a + J^T lambda = -b,  J a = -c,  with b and c at a = 0.
    """
    m, n = len(arrays.model.active), arrays.n_floating
    lines = tuple(
        LineState(jnp.zeros_like(state.q1), *shape_rates(model, state, state.q1))
        for model, state in zip(arrays.lines, now.lines, strict=True)
    )
    steady = Motion(lines, jnp.zeros(n), now.velocity)
    none = jnp.zeros(m)
    left = motion_residuals(arrays, now, steady, none, none, jnp.zeros_like)
    flat, unravel = ravel_pytree((left.acceleration, tuple(line.q1 for line in left.lines)))
    if not m:
        found, multipliers = -jnp.linalg.solve(_metric(arrays, now), flat), none
    else:

        def later(s: jax.Array) -> jax.Array:
            return joint_rates(arrays, moved(arrays, now, jax.tree.map(lambda r: s * r, steady), s))

        _, bias = jax.jvp(later, (jnp.zeros(()),), (jnp.ones(()),))
        rows, _ = _rows(arrays, now)
        matrix = jnp.block([[_metric(arrays, now), rows.T], [rows, jnp.zeros((m, m))]])
        solved = -jnp.linalg.solve(matrix, jnp.concatenate([flat, bias]))
        found, multipliers = solved[: len(flat)], solved[len(flat) :]
    acceleration, firsts = unravel(found)
    moving = tuple(replace(line, q1=first) for line, first in zip(lines, firsts, strict=True))
    return Motion(moving, acceleration, now.velocity), multipliers


_BEGUN = KeptProgram(_begun, STARTING)
