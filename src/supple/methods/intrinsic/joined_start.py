"""Consistent start of joined lines and floating bodies: corrected velocities, rates, joint forces."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree
from scipy.linalg import block_diag

from supple.arrays import AnyArray
from supple.equations.build_model import row_scales, station_model, system_length
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import ControlState, ControlStep
from supple.equations.consistent_start import (
    check_friction_known,
    independent_constraints,
    placed_configuration,
    placed_velocity,
)
from supple.equations.inertia import mass_matrix
from supple.equations.joint_closure import check_joints_finite
from supple.equations.joint_force import constraints
from supple.equations.start_change import StartChange, StartEnergies
from supple.equations.start_velocity import given_parts, has_motion, impact_fit, levels_of_body, rigid_fit
from supple.equations.starting_machine import CONVERGED, MOST
from supple.errors import ModelError
from supple.machine import System
from supple.methods.intrinsic.intrinsic_body import body_of
from supple.methods.intrinsic.joined_equations import (
    JoinedInstant,
    JoinedRates,
    motion_residuals,
    moved_instant,
    residuals_of_joints,
    steady_rates,
)
from supple.methods.intrinsic.joined_machine import JoinedArrays, JoinedMachine, with_stations
from supple.methods.intrinsic.machine_of_lines import amplitudes_of, frame_to_root, rigid_motion
from supple.programs.program_cache import CachedProgram

OPEN = 1e-6
"""Largest residual of a joint as placed, a length relative to the machine's size or an angle in rad."""


def joined_start(machine: JoinedMachine, time: float) -> tuple[JoinedArrays, JoinedInstant, StartChange]:
    """The machine without redundant equations, its initial instant on the joints, and the change by them.

    Velocities are corrected as for floating bodies (`start_velocity`).
    Raises ModelError for an open joint, or a law without a finite value. Warns RedundantConstraintWarning
    about joints with redundant equations.
    """
    closed = closed_machine(machine, time)
    return closed.arrays, *_on_joints(machine, closed)


class ClosedMachine(NamedTuple):
    """A machine without redundant equations, as placed.

    rows, rates : Jacobian by the velocities, and rates, of all equations of joints
    active : numbers of the independent equations
    metric : mass matrix of all velocities
    """

    arrays: JoinedArrays
    now: JoinedInstant
    active: np.ndarray
    rows: np.ndarray
    rates: np.ndarray
    metric: np.ndarray


def closed_machine(
    machine: JoinedMachine, time: float, known: tuple[int, ...] | None = None
) -> ClosedMachine:
    """The machine as placed, without redundant joint equations; raises and warns as `joined_start`.

    known : numbers of the independent equations of a machine whose joints are closed, or count as closed: on
        a rotating machine, joints to the ground are those to a rotating platform; None: they are computed
    """
    arrays, seen = machine.arrays, machine.seen
    placed = jax.tree.map(jnp.asarray, placed_configuration(seen))
    given = JoinedInstant(
        jnp.asarray(float(time)),
        machine.states,
        placed,
        jnp.asarray(placed_velocity(seen)[: arrays.n_floating]),
    )
    now, *found = _BEGUN(arrays, given)
    gaps, rows, rates, metric = map(np.asarray, found)
    check_joints_finite(machine.system, gaps, rates)
    if known is None:
        _check_closed(machine, gaps)
        known = independent_constraints(seen, rows, metric)
    active = np.array(known, dtype=int)
    if len(active) < len(gaps):
        kept = tuple(active.tolist())
        arrays = replace(arrays, model=station_model(seen, arrays.n_bodies, kept))
        check_friction_known(seen, kept)
    return ClosedMachine(arrays, now, active, rows, rates, metric)


def _begun(
    arrays: JoinedArrays, given: JoinedInstant
) -> tuple[JoinedInstant, jax.Array, jax.Array, jax.Array, jax.Array]:
    """The instant with its stations placed; residuals, Jacobian and rates of the joints; mass matrix."""
    now = given._replace(floating=with_stations(arrays, given.floating, given.lines))
    gaps = constraints(arrays.model, now.time, now.floating)
    return now, gaps, *_rows(arrays, now), velocity_metric(arrays, now)


def _check_closed(machine: JoinedMachine, gaps: np.ndarray) -> None:
    relative = np.abs(gaps) / row_scales(machine.seen, system_length(machine.system))
    if relative.max(initial=0.0) > OPEN:
        worst = int(np.argmax(relative))
        joint, row = [(joint.name, row) for joint in machine.system.joints for row in joint.rows][worst]
        raise ModelError(
            f"joint '{joint}' is open in the initial configuration: {row} has a gap of {gaps[worst]:.3g}. "
            "Place the bodies so that both ends meet; coordinates determine the shape of an intrinsic body"
        )


Velocities = tuple[jax.Array, tuple[jax.Array, ...]]
"""Velocities of the floating bodies, and amplitudes of each line; or forces on them."""


def _velocities(now: JoinedInstant) -> Velocities:
    return now.velocity, tuple(state.q1 for state in now.lines)


def _with_velocities(now: JoinedInstant, velocities: Velocities) -> JoinedInstant:
    floating, amplitudes = velocities
    lines = tuple(replace(state, q1=q1) for state, q1 in zip(now.lines, amplitudes, strict=True))
    return now._replace(velocity=floating, lines=lines)


def _rows(arrays: JoinedArrays, now: JoinedInstant) -> tuple[jax.Array, jax.Array]:
    """Derivative (m, z) of the rates of the joints' equations by all velocities, and these rates."""
    flat, unravel = ravel_pytree(_velocities(now))

    def rates(velocities: jax.Array) -> jax.Array:
        return residuals_of_joints(arrays, _with_velocities(now, unravel(velocities)))[1]

    return jax.jacfwd(rates)(flat), rates(flat)


def velocity_metric(arrays: JoinedArrays, now: JoinedInstant) -> jax.Array:
    """Mass matrix of all velocities; the modes are mass-normalised."""
    n = arrays.n_floating
    lines = sum(len(state.q1) for state in now.lines)
    metric = jnp.eye(n + lines)
    return metric.at[:n, :n].set(mass_matrix(arrays.model, now.floating)[:n, :n])


def _on_joints(machine: JoinedMachine, closed: ClosedMachine) -> tuple[JoinedInstant, StartChange]:
    """The instant with velocities that satisfy its joints, and their change from the given ones."""
    _, now, active, all_rows, all_rates, metric = closed
    flat, unravel = ravel_pytree(_velocities(now))
    rows, rates = all_rows[active], all_rates[active]
    soft = np.linalg.solve(metric, rows.T)
    compliance = rows @ soft
    parts, motions = _rigid_motions(machine)
    by_body = [
        [motion @ own for own in levels_of_body(given, motion.T @ metric[part, part] @ motion)]
        for part, motion, given in zip(parts, motions, given_parts(_ordered(machine)), strict=True)
    ]
    is_impact = has_motion(machine.system)
    fit = (
        impact_fit(rates)
        if is_impact
        else rigid_fit(
            [np.asarray(block_diag(*own)) for own in zip(*by_body, strict=True)],
            rows,
            rates,
            row_scales(machine.seen, system_length(machine.system))[active],
            lambda: np.linalg.inv(compliance),
        )
    )
    deforming = -soft @ np.linalg.solve(compliance, fit.left)
    before = np.asarray(flat)
    after = before + np.sum(fit.by_level, axis=0) + deforming
    against = deforming if is_impact else fit.by_level[-1]
    unmet = np.zeros(len(all_rates))
    unmet[active] = fit.unmet

    def energies(velocity: np.ndarray) -> np.ndarray:
        products = velocity * (metric @ velocity)
        return np.array([products[part].sum() / 2 for part in parts])

    def frames(velocity: np.ndarray) -> np.ndarray:
        fitted = zip(parts, motions, strict=True)
        return np.array([np.linalg.lstsq(own, velocity[part], rcond=None)[0] for part, own in fitted])

    change = StartChange.of_positions_and_velocities(
        _ordered(machine),
        residual=np.zeros(len(all_rates)),
        closed=placed_configuration(machine.system),
        rates=all_rates,
        unmet=unmet,
        largest_rate=fit.largest,
        velocities=(frames(before), frames(after)),
        energies=StartEnergies(*map(energies, (before, after, against, deforming))),
    )
    return _with_velocities(now, unravel(after)), change


def _ordered(machine: JoinedMachine) -> System:
    """The machine with floating bodies first, in the order of its velocities."""
    return replace(machine.system, bodies=(*machine.others, *machine.lines))


def _rigid_motions(machine: JoinedMachine) -> tuple[list[slice], list[np.ndarray]]:
    """Slice of each body's velocities, and these velocities (n, 6) for rigid motion of its frame."""
    parts = list(machine.arrays.model.slices[: machine.arrays.n_bodies])
    motions = [np.eye(part.stop - part.start, 6) for part in parts]
    for placed, state in zip(machine.lines, machine.states, strict=True):
        body = body_of(placed)
        motion = rigid_motion(body, np.asarray(state.q2)) @ frame_to_root(placed)
        motions.append(amplitudes_of(body, motion))
        first = parts[-1].stop if parts else 0
        parts.append(slice(first, first + len(motions[-1])))
    return parts, motions


def instant_rates(
    arrays: JoinedArrays, now: JoinedInstant, control: ControlState | None = None
) -> tuple[JoinedRates, jax.Array]:
    """Rates at an instant that satisfies its joints, and the multipliers.

        M a + J^T lambda = -b,     J a = -c

    At a = 0, b are the residuals of the equations of motion and c the second time derivatives of g. The
    solution is iterated where friction in b depends on lambda, at most `MOST` times; NaN if this does not
    converge.
    """
    m, n = len(arrays.model.active), arrays.n_floating
    lines = steady_rates(arrays, now.lines, tuple(state.q1 for state in now.lines))
    steady = JoinedRates(lines, jnp.zeros(n), now.velocity)
    none = jnp.zeros(m)
    held = control and ControlStep(control, jnp.zeros(()))

    def unbalanced(multipliers: jax.Array) -> Velocities:
        left = motion_residuals(arrays, now, steady, multipliers, none, jnp.zeros_like, held)
        return left.acceleration, tuple(line.q1 for line in left.lines)

    flat, unravel = ravel_pytree(unbalanced(none))
    if not m:
        found, multipliers = -jnp.linalg.solve(velocity_metric(arrays, now), flat), none
    else:

        def rates_later(s: jax.Array) -> jax.Array:
            later = moved_instant(arrays, now, jax.tree.map(lambda r: s * r, steady), s)
            return residuals_of_joints(arrays, later)[1]

        _, bias = jax.jvp(rates_later, (jnp.zeros(()),), (jnp.ones(()),))
        rows, _ = _rows(arrays, now)
        matrix = jnp.block([[velocity_metric(arrays, now), rows.T], [rows, jnp.zeros((m, m))]])
        solved = -jnp.linalg.solve(matrix, jnp.concatenate([flat, bias]))
        if arrays.model.reads_reactions:
            inverse, size = jnp.linalg.inv(matrix), len(flat)

            def again(carry: tuple[jax.Array, jax.Array, AnyArray]) -> tuple[jax.Array, jax.Array, AnyArray]:
                known, _, count = carry
                left = ravel_pytree(unbalanced(known[size:]))[0] - rows.T @ known[size:]
                after = -inverse @ jnp.concatenate([left, bias])
                return after, jnp.max(jnp.abs(after - known)), count + 1

            def differs(known: jax.Array, change: jax.Array) -> jax.Array:
                return ~(change <= CONVERGED * jnp.max(jnp.abs(known)))

            solved, change, _ = jax.lax.while_loop(
                lambda carry: (carry[2] < MOST) & differs(*carry[:2]),
                again,
                (solved, jnp.asarray(jnp.inf), 0),
            )
            solved = jnp.where(differs(solved, change), jnp.nan, solved)
        found, multipliers = solved[: len(flat)], solved[len(flat) :]
    acceleration, firsts = unravel(found)
    moving = tuple(replace(line, q1=first) for line, first in zip(lines, firsts, strict=True))
    return JoinedRates(moving, acceleration, now.velocity), multipliers


_BEGUN = CachedProgram(_begun, STARTING)
