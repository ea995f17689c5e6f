"""One implicit step of lines and floating bodies with joints: first-order generalised-alpha.

The equations of a step are solved by modified Newton's method: the derivative, which costs as much as dozens
of residuals, is computed at the first iteration, and again only where the residual decreases slowly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from supple.arrays import AnyArray
from supple.equations.configuration import ControlState, ControlStep
from supple.equations.control_force import stepped
from supple.equations.inertia import mass_matrix
from supple.methods.intrinsic.implicit_step import ROUNDING, SLOW, FirstOrderCoefficients
from supple.methods.intrinsic.joined_equations import (
    JoinedInstant,
    JoinedRates,
    motion_residuals,
    moved_instant,
    residuals_of_joints,
    seen_motion,
)
from supple.methods.intrinsic.joined_machine import JoinedArrays


class JoinedStepping(NamedTuple):
    """Step rule, tolerances on relative residuals, and largest number of iterations of a step.

    tolerance : residual at which a step ends,  limit : residual above which a step has not converged
    """

    coefficients: FirstOrderCoefficients
    tolerance: float
    max_iterations: int
    limit: float


class JoinedState(NamedTuple):
    """State of a time integration.

    multipliers : (m,)      multipliers of the last step
    control : ControlState | None       state of the machine's controllers
    worst : ()              largest relative residual of a step since the start
    iterations : ()         iterations since the start
    """

    now: JoinedInstant
    rates: JoinedRates
    multipliers: AnyArray
    control: ControlState | None
    worst: AnyArray
    iterations: AnyArray

    @property
    def time(self) -> AnyArray:
        """Time of the state, s."""
        return self.now.time


class _Tangent(NamedTuple):
    """Derivative of the residuals by the unknowns, and its inverse, (N, N)."""

    slope: AnyArray
    inverse: AnyArray


_Carry = tuple[jax.Array, jax.Array, jax.Array, jax.Array, jax.Array, _Tangent]
"""Unknowns, residuals, their relative size, whether it decreases slowly, number of iterations, tangent."""


def joined_step(
    arrays: JoinedArrays, stepping: JoinedStepping, state: JoinedState, h: jax.Array
) -> JoinedState:
    """The state after a step h; forces are evaluated within the step, constraints at its end.

        y_1 = y_0 + h ((1 - gamma) y'_0 + gamma y'_1)
        (1 - alpha_m) y'_0 + alpha_m y'_1 = f(y at alpha_f) + joint forces,     g = 0 and g' = 0 at y_1

    rho_inf = 1 is the implicit midpoint rule, symmetric in time. States of controllers follow the trapezoidal
    rule: from the start of the step to the time at which loads act, and again from the start to the end.
    """
    alpha_m, alpha_f, gamma = stepping.coefficients
    now, before = state.now, state.rates
    n, m = arrays.n_floating, len(arrays.model.active)
    inverse = jnp.linalg.inv(mass_matrix(arrays.model, now.floating)[:n, :n]) if n else jnp.zeros((0, 0))
    flat, unravel = ravel_pytree(before)
    size = len(flat)

    def mixed(share: AnyArray, first: AnyArray, after: JoinedRates) -> JoinedRates:
        return jax.tree.map(lambda a, b: share * (first * a + (1 - first) * b), before, after)

    def missing(unknown: jax.Array) -> jax.Array:
        after = unravel(unknown[:size])
        multipliers, closing = unknown[size : size + m], unknown[size + m :]
        between = moved_instant(arrays, now, mixed(alpha_f * h, 1 - gamma, after), alpha_f * h)
        end = moved_instant(arrays, now, mixed(h, 1 - gamma, after), h)
        left = motion_residuals(
            arrays,
            between,
            mixed(1.0, 1 - alpha_m, after),
            multipliers,
            closing,
            lambda f: inverse @ f,
            state.control and ControlStep(state.control, alpha_f * h),
        )
        return jnp.concatenate([ravel_pytree(left)[0], *residuals_of_joints(arrays, end)])

    kinds, states = _kinds(arrays, before, m), _sizes(arrays, now, m)

    def measured(slope: jax.Array, unknown: jax.Array, left: jax.Array) -> jax.Array:
        """Largest residual of a kind of equations, relative to the size of its terms."""
        terms = jnp.abs(slope) @ (jnp.abs(unknown) + ROUNDING / stepping.tolerance / h * states)
        sums = jax.ops.segment_sum(jnp.stack([left, terms], axis=1) ** 2, kinds, int(kinds.max()) + 1)
        return jnp.max(jnp.sqrt(sums[:, 0] / jnp.maximum(sums[:, 1], 1e-300)))

    first = jnp.concatenate([flat, state.multipliers, jnp.zeros(m)])
    unknown, error, count = _solved(missing, measured, first, stepping)
    after = unravel(unknown[:size])
    # A step of zero length repeats its start.
    end = moved_instant(arrays, now, mixed(h, 1 - gamma, after), h)
    multipliers = unknown[size : size + m]
    ending = seen_motion(
        arrays, end, after, multipliers, state.control and ControlStep(state.control, jnp.asarray(h))
    )
    reached = JoinedState(
        end,
        after,
        multipliers,
        stepped(arrays.model, ending),
        jnp.maximum(state.worst, error),
        state.iterations + count,
    )
    return jax.tree.map(lambda a, b: jnp.where(h > 0, a, b), reached, state)


def _solved(
    missing: Callable[[jax.Array], jax.Array],
    measured: Callable[[jax.Array, jax.Array, jax.Array], jax.Array],
    first: jax.Array,
    stepping: JoinedStepping,
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Zero of `missing` by modified Newton's method from `first`: unknowns, relative residual, iterations.

    measured : relative residual from the derivative, the unknowns and the residuals
    """

    def twice(unknown: jax.Array) -> tuple[jax.Array, jax.Array]:
        left = missing(unknown)
        return left, left

    def made_anew(unknown: jax.Array, _: jax.Array, __: _Tangent) -> tuple[jax.Array, _Tangent]:
        # Value and derivative in one pass: the program is shorter, and compiles faster.
        slope, left = jax.jacfwd(twice, has_aux=True)(unknown)
        return left, _Tangent(slope, jnp.linalg.inv(slope))

    def kept(_: jax.Array, left: jax.Array, known: _Tangent) -> tuple[jax.Array, _Tangent]:
        return left, known

    def goes_on(carry: _Carry) -> jax.Array:
        _, _, error, _, count, _ = carry
        return (count < stepping.max_iterations) & (error > stepping.tolerance)

    def improve(carry: _Carry) -> _Carry:
        unknown, left, error, slow, count, known = carry
        left, known = jax.lax.cond(slow, made_anew, kept, unknown, left, known)
        unknown = unknown - known.inverse @ left
        left = missing(unknown)
        after = measured(known.slope, unknown, left)
        return unknown, left, after, ~(after <= SLOW * error), count + 1, known

    none = jnp.zeros((len(first), len(first)))
    begin = (
        first,
        jnp.zeros_like(first),
        jnp.asarray(jnp.inf),
        jnp.ones((), dtype=bool),
        jnp.zeros((), dtype=int),
        _Tangent(none, none),
    )
    unknown, _, error, _, count, _ = jax.lax.while_loop(goes_on, improve, begin)
    return unknown, error, count


def _kinds(arrays: JoinedArrays, rates: JoinedRates, m: int) -> np.ndarray:
    """Group number of each equation, in the order of the unknowns; a group has one residual norm."""
    lines, k = [], 0
    for line in rates.lines:
        sizes = (line.q1.size, line.q2.size, line.quaternion.size + line.position.size)
        lines += [np.full(size, k + own) for own, size in enumerate(sizes)]
        k += len(sizes)
    frames = [np.repeat([0, 1, 2], (3, 3, r)) for r in arrays.model.sizes[: arrays.n_bodies]]
    of_frames = np.concatenate([np.zeros(0, dtype=int), *frames])
    closed = [np.full(m, k + 6), np.full(m, k + 7)]
    return np.concatenate([*lines, of_frames + k, of_frames + k + 3, *closed]).astype(int)


def _sizes(arrays: JoinedArrays, now: JoinedInstant, m: int) -> jax.Array:
    """Sizes of the states, in the order of their rates, as the scale of rounding errors."""
    length = jnp.asarray(arrays.model.length, dtype=float)
    frames, first = [jnp.zeros(0)], 0
    for r in arrays.model.sizes[: arrays.n_bodies]:
        own = now.floating.coordinates[first : first + r]
        frames += [jnp.full(3, length), jnp.ones(3), jnp.abs(own)]
        first += r
    # The scale of root positions is the size of the machine, also for a root at the origin.
    lines = tuple(replace(jax.tree.map(jnp.abs, state), position=jnp.full(3, length)) for state in now.lines)
    sizes = JoinedRates(lines, jnp.abs(now.velocity), jnp.concatenate(frames))
    return jnp.concatenate([ravel_pytree(sizes)[0], jnp.zeros(2 * m)])
