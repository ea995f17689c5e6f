"""Initial accelerations of an exported machine after a change of its parameters, traceable by JAX."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from supple.equations.compiled_machine import forces_without_acceleration
from supple.equations.configuration import Configuration, ControlState, ControlStep
from supple.equations.converged_reactions import CONVERGED, MOST
from supple.equations.inertia import mass_matrix
from supple.equations.machine_model import Model
from supple.equations.starting_machine import joint_terms

__all__ = ["consistent_accelerations"]


def consistent_accelerations(
    model: Model, time: Any, configuration: Configuration, velocity: Any, control: ControlState | None
) -> tuple[Any, Any, Any]:
    """Accelerations (n,), multipliers (m,), and whether the iteration of friction and joint forces fails.

    Accelerations and multipliers solve `M vdot + G^T lambda = - forces`, `G vdot = - d2g/dt2`, with d2g/dt2
    at constant velocity.
    """
    terms = joint_terms(model, time, configuration, velocity)
    mass = mass_matrix(model.bodies_alone, configuration)
    n, m = len(mass), len(model.active)
    scale = jnp.trace(mass) / n
    top = jnp.concatenate([mass, scale * terms.jacobian.T], axis=1)
    bottom = jnp.concatenate([scale * terms.jacobian, jnp.zeros((m, m))], axis=1)
    matrix = jnp.concatenate([top, bottom])
    step = None if control is None else ControlStep(control, jnp.zeros(()))

    def solved(multipliers: Any) -> Any:
        forces = forces_without_acceleration(model, time, configuration, velocity, step, multipliers)
        right = jnp.concatenate([-forces, -scale * terms.acceleration_bias])
        # The right-hand side is eliminated with the matrix, as in the time integration.
        factors, _, _ = jax.lax.linalg.lu(jnp.concatenate([matrix, right[:, None]], axis=1))
        solution = jax.lax.linalg.triangular_solve(factors[:, :-1], factors[:, -1:], left_side=True)[:, 0]
        return jnp.concatenate([solution[:n], scale * solution[n:]])

    found = solved(jnp.zeros(m))
    if not model.reads_reactions:
        return found[:n], found[n:], jnp.asarray(False)

    def differs(state: Any) -> Any:
        _, before, own = state
        return jnp.max(abs(own[n:] - before)) > CONVERGED * jnp.max(abs(own[n:]))

    _, before, found = jax.lax.while_loop(
        lambda state: differs(state) & (state[0] < MOST),
        lambda state: (state[0] + 1, state[2][n:], solved(state[2][n:])),
        (0, jnp.zeros(m), found),
    )
    return found[:n], found[n:], ~(jnp.max(abs(found[n:] - before)) <= CONVERGED * jnp.max(abs(found[n:])))
