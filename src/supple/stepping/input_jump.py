"""The jump of the accelerations when the inputs of a machine change between two steps.

The time integration takes the accelerations at both ends of a step. Without their jump, an input that changes
at the start of a step would act as one that changes linearly within the step: half a step too late.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from supple.equations.machine_model import Model
from supple.methods.floating.compiled.state import State
from supple.stepping.consistent_accelerations import acceleration_jump
from supple.stepping.external_inputs import ExternalInputs

__all__ = ["after_jump"]


def after_jump(inputs: ExternalInputs, arrays: Model, state: State, held: Any, given: Any) -> State:
    """The state with the accelerations and joint forces of new inputs; unchanged for equal inputs.

    held, given : (i,) inputs before and after
    """

    @jax.custom_jvp
    def jump(differs: Any, before: Model, now: Model, at: Any) -> tuple[Any, Any]:
        none = jnp.zeros_like(state.acceleration), jnp.zeros_like(state.multipliers)
        return jax.lax.cond(differs, lambda: acceleration_jump(before, now, *at), lambda: none)

    @jump.defjvp
    def _(primals: Any, tangents: Any) -> Any:  # also of equal inputs, at which a jump has a derivative
        changed = jax.jvp(lambda *given: acceleration_jump(*given[:2], *given[2]), primals[1:], tangents[1:])
        return jump(*primals), changed[1]

    at = (state.time, state.configuration, state.velocity, state.control)
    models = inputs.given(arrays, held), inputs.given(arrays, given)
    by_acceleration, by_force = jump(jnp.any(given != held), *models, at)
    return state._replace(
        acceleration=state.acceleration + by_acceleration,
        auxiliary=state.auxiliary + by_acceleration,
        multipliers=state.multipliers + by_force,
    )
