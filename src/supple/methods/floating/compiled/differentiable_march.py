"""Time integration up to one instant as a function that JAX differentiates in forward mode.

Derivatives taken through the iterations of a step would have the error of the iteration's tangent. Here they
are derivatives of the discrete motion, by the implicit function theorem (`sensitivity_step`), and do not
depend on the iteration.
"""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero

from supple.arrays import AnyArray
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.elimination import ByLapack
from supple.methods.floating.compiled.sensitivity_step import StateChange, state_change, step_with_changes
from supple.methods.floating.compiled.state import Controls, State
from supple.methods.floating.compiled.time_step import substep

Inputs = tuple[Model, State, AnyArray]
"""A model, a state and an end time, or their tangents."""


def marched_to(controls: Controls, model: Model, state: State, end: AnyArray) -> State:
    """The state at a time, in as many steps as needed; after a failure, the state before the failed step.

    Forward-mode derivatives exist with respect to the numbers of the model, the state and the time.
    """

    @jax.custom_jvp
    def reached(model: Model, state: State, end: AnyArray) -> State:
        return jax.lax.while_loop(
            partial(_goes_on, end), partial(substep, ByLapack(), model, controls, end), state
        )

    reached.defjvp(partial(_with_changes, controls), symbolic_zeros=True)
    return reached(model, state, end)


def _goes_on(end: AnyArray, state: State) -> AnyArray:
    return (state.time < end) & ~state.failed


def _is_zero(tangent: object) -> bool:
    return isinstance(tangent, SymbolicZero)


def _along(value: AnyArray, tangent: AnyArray) -> jax.Array:
    """The change of a value along one direction, with a leading axis (1, ..)."""
    return jnp.zeros((1, *jnp.shape(value))) if _is_zero(tangent) else jnp.asarray(tangent)[None]


def _with_changes(
    controls: Controls, primals: tuple[Model, State, AnyArray], tangents: tuple[Model, State, AnyArray]
) -> tuple[State, State]:
    """The integrated state and its derivative along one direction."""
    (model, state, end), (by_model, by_state, by_end) = primals, tangents
    model_change = [
        None if _is_zero(own) else jnp.asarray(own)[None]
        for own in jax.tree.leaves(by_model, is_leaf=_is_zero)
    ]
    begun = jax.tree.map(_along, state_change(state), state_change(by_state))
    step = partial(step_with_changes, ByLapack(), model, controls, model_change, end, _along(end, by_end))
    last, change = jax.lax.while_loop(lambda known: _goes_on(end, known[0]), step, (state, begun))
    return last, _as_tangent(last, jax.tree.map(lambda leaf: leaf[0], change))


def _as_tangent(state: State, change: StateChange) -> State:
    """Derivatives of all parts of a state; zero for the parts that no step depends on."""

    def none(leaf: AnyArray) -> AnyArray:
        leaf = jnp.asarray(leaf)
        inexact = jnp.issubdtype(leaf.dtype, jnp.inexact)
        return jnp.zeros_like(leaf) if inexact else np.zeros(leaf.shape, jax.dtypes.float0)

    return jax.tree.map(none, state)._replace(**change.carried._asdict(), multipliers=change.multipliers)
