"""Derivatives of one time step with respect to numbers of the model, its start and its end.

With `x` the new accelerations and multipliers, `y` the state at the start of a step and `p` numbers of the
model, a step solves `F(x, y, p) = 0` and returns `y_1 = Y(x, y, p)`. Along a direction (dy, dp)

    F_x dx = - (F_y dy + F_p dp),        dy_1 = Y_x dx + Y_y dy + Y_p dp

by the implicit function theorem, at the solution. These are derivatives of the discrete motion, independent
of the iteration. The products are exact (forward mode). `F_x` is inverted once for all directions in the form
used by Newton's iteration; corrections are repeated until the last one is small (`_EXACT`, `_ROUNDING`).
Source: staggered direct method [CaracotsiosStewart1985].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray
from supple.equations.configuration import Configuration, ControlState
from supple.equations.control_force import stepped
from supple.equations.coordinate_scales import position_scale
from supple.equations.machine_model import Model
from supple.integrate import StepRule
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.iterate import evaluate, linearized, motion_of
from supple.methods.floating.compiled.state import Controls, State
from supple.methods.floating.compiled.step_equations import step_inverse
from supple.methods.floating.compiled.time_step import equal_steps, is_last, substep

Residuals = tuple[jax.Array, jax.Array]
"""Residuals (n,) of the bodies and (m,) of the joints."""

_EXACT = 1e-9
"""Largest last correction, relative to the derivative, of accelerations and multipliers."""
_ROUNDING = 1e-13
"""Largest last correction, relative to the derivative, of positions: effect of rounding in constraints."""
_MOST = 20
"""Largest number of corrections, after which the derivatives are nan; two suffice with an exact tangent."""


class Carried(NamedTuple):
    """The part of the state at the start of a step on which the result of the step depends."""

    time: AnyArray
    configuration: Configuration
    velocity: AnyArray
    acceleration: AnyArray
    auxiliary: AnyArray
    control: ControlState | None


class StateChange(NamedTuple):
    """Derivatives of a state along p directions, a leading axis on every array."""

    carried: Carried
    multipliers: AnyArray
    """(p, m)"""


def state_change(state: State) -> StateChange:
    """The parts of a state that have derivatives."""
    return StateChange(_carried(state), state.multipliers)


def _carried(state: State) -> Carried:
    return Carried(*(getattr(state, name) for name in Carried._fields))


class _Solved(NamedTuple):
    """The unknowns of a step."""

    acceleration: AnyArray
    multipliers: AnyArray


def step_with_changes(
    elimination: DenseElimination,
    model: Model,
    controls: Controls,
    model_change: Sequence[AnyArray | None],
    end: jax.Array,
    end_change: jax.Array,
    known: tuple[State, StateChange],
) -> tuple[State, StateChange]:
    """A state and its derivatives after trying one step; arguments as for `changed_by_step`."""
    before, change = known
    after = substep(elimination, model, controls, end, before)
    along = partial(changed_by_step, elimination, model, controls, model_change, before, change, after)
    accepted = after.steps > before.steps
    return after, jax.lax.cond(accepted, lambda: along(end, end_change), lambda: change)


def changed_by_step(
    elimination: DenseElimination,
    model: Model,
    controls: Controls,
    model_change: Sequence[AnyArray | None],
    before: State,
    change: StateChange,
    after: State,
    end: jax.Array,
    end_change: jax.Array,
) -> StateChange:
    """Derivatives after an accepted step; nan where they do not converge.

    model_change : for each leaf of the model (p, ..), None for a constant one
    end, end_change : the next stop, reached in equal steps, and its derivatives (p,)
    """
    rule = StepRule(controls.coefficients, (end - before.time) / equal_steps(before, end))
    equations, varied = _equations(model, controls, model_change, before, end)
    solved = _Solved(after.acceleration, after.multipliers)
    _, product = jax.linearize(equations, varied, _carried(before), end, solved)
    known = [each for each in model_change if each is not None], change.carried, end_change
    along_all = jax.vmap(product, in_axes=(0, 0, 0, 0))
    at = evaluate(model, rule, before, solved.acceleration, solved.multipliers, controls.residual_tolerance)
    correction = step_inverse(elimination, model, linearized(rule, before, at))
    found, carried = _solution(model, rule, change, partial(along_all, *known), jax.vmap(correction))
    return StateChange(carried, found.multipliers)


def _equations(
    model: Model, controls: Controls, model_change: Sequence[AnyArray | None], before: State, end: jax.Array
) -> tuple[Callable[..., tuple[Residuals, Carried]], list[jax.Array]]:
    """Residuals and end state of a step as a function of the model's varying leaves; and these leaves."""
    leaves, structure = jax.tree.flatten(model)
    places = [number for number, own in enumerate(model_change) if own is not None]
    # The number of steps to the stop is fixed; their size varies with the stop.
    number, remaining = equal_steps(before, end), end - before.time
    ends = is_last(remaining / number, remaining)

    def equations(
        varied: list[jax.Array], carried: Carried, end: jax.Array, solved: _Solved
    ) -> tuple[Residuals, Carried]:
        every = list(leaves)
        for place_, own in zip(places, varied, strict=True):
            every[place_] = own
        own = jax.tree.unflatten(structure, every)
        rule = StepRule(controls.coefficients, (end - carried.time) / number)
        start = before._replace(**carried._asdict())
        trial = evaluate(own, rule, start, *solved, controls.residual_tolerance)
        handed_on = Carried(
            time=jnp.where(ends, end, carried.time + rule.h),
            configuration=trial.configuration,
            velocity=trial.velocity,
            acceleration=solved.acceleration,
            auxiliary=rule.auxiliary(solved.acceleration, carried.acceleration, carried.auxiliary),
            control=stepped(own, motion_of(rule, start, trial)),
        )
        return (trial.residual, trial.constraint_residual), handed_on

    return equations, [jnp.asarray(leaves[place_], dtype=float) for place_ in places]


class _Correcting(NamedTuple):
    """Current iterate of the derivatives of a step's unknowns."""

    found: _Solved
    carried: Carried
    """Derivatives at the end of the step, for the iterate before the last correction"""
    unsolved: jax.Array
    corrections: jax.Array


def _solution(
    model: Model,
    rule: StepRule,
    change: StateChange,
    product: Callable[[_Solved], tuple[Residuals, Carried]],
    correction: Callable[[jax.Array, jax.Array], jax.Array],
) -> tuple[_Solved, Carried]:
    """Derivatives of the unknowns of a step, and of its end state."""
    scale = position_scale(model)
    n = len(scale)

    def size(found: jax.Array) -> jax.Array:
        """Norm of accelerations and multipliers (p, n + m) for each direction."""
        accelerations = jnp.max(jnp.abs(found[:, :n] / scale), axis=1)
        forces = jnp.max(jnp.abs(found[:, n:]), axis=1, initial=0.0) / (model.mass * model.length)
        return jnp.maximum(accelerations, forces)

    origins, rotations, coordinates = change.carried.configuration
    p = len(origins)
    moved = jnp.maximum(
        jnp.max(jnp.abs(origins.reshape(p, -1)), axis=1) / model.length,
        jnp.max(jnp.abs(rotations.reshape(p, -1)), axis=1),
    )
    if coordinates.shape[1]:
        own = jnp.concatenate([scale[part.start + 6 : part.stop] for part in model.deforming_slices])
        moved = jnp.maximum(moved, jnp.max(jnp.abs(coordinates / own), axis=1))
    rounding = _ROUNDING * moved / rule.factors.by_position

    def corrected(old: _Correcting) -> _Correcting:
        residuals, carried = product(old.found)
        found = jnp.concatenate(old.found, axis=1)
        step = correction(*residuals)
        # With this comparison NaN counts as unsolved.
        unsolved = ~jnp.all(size(step) <= _EXACT * size(found) + rounding)
        new = jnp.where(unsolved, found + step, found)
        return _Correcting(_Solved(new[:, :n], new[:, n:]), carried, unsolved, old.corrections + 1)

    none = _Solved(jnp.zeros((p, n)), jnp.zeros_like(change.multipliers))
    begun = _Correcting(none, change.carried, jnp.ones((), dtype=bool), jnp.zeros((), dtype=int))
    end = jax.lax.while_loop(lambda old: old.unsolved & (old.corrections < _MOST), corrected, begun)
    return jax.tree.map(lambda leaf: jnp.where(end.unsolved, jnp.nan, leaf), (end.found, end.carried))
