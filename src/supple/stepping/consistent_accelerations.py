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

__all__ = ["acceleration_jump", "consistent_accelerations"]


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
    step = None if control is None else ControlStep(control, jnp.zeros(()))

    def solved(multipliers: Any) -> Any:
        forces = forces_without_acceleration(model, time, configuration, velocity, step, multipliers)
        return _solved(mass, terms.jacobian, forces, terms.acceleration_bias)

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


def acceleration_jump(
    before: Model, now: Model, time: Any, configuration: Configuration, velocity: Any, control: Any
) -> tuple[Any, Any]:
    """Changes of accelerations (n,) and multipliers (m,) between two models that differ in loads alone."""
    at = time, configuration, velocity
    if now.reads_reactions:
        first, second = (consistent_accelerations(each, *at, control) for each in (before, now))
        return second[0] - first[0], second[1] - first[1]
    mass, terms = mass_matrix(now.bodies_alone, configuration), joint_terms(now, *at)
    step = None if control is None else ControlStep(control, jnp.zeros(()))
    none = jnp.zeros(len(now.active))
    first, second = (forces_without_acceleration(each, *at, step, none) for each in (before, now))
    found = _solved(mass, terms.jacobian, second - first, none)
    return found[: len(mass)], found[len(mass) :]


def _solved(mass: Any, jacobian: Any, forces: Any, bias: Any) -> Any:
    """Accelerations and multipliers (n + m,) for the forces (n,) and the bias (m,) of the joints."""
    n, m = len(mass), len(bias)
    scale = jnp.trace(mass) / n
    top = jnp.concatenate([mass, scale * jacobian.T], axis=1)
    bottom = jnp.concatenate([scale * jacobian, jnp.zeros((m, m))], axis=1)
    right = jnp.concatenate([-forces, -scale * bias])[:, None]
    # The right-hand side is eliminated with the matrix, as in the time integration.
    whole = jnp.concatenate([jnp.concatenate([top, bottom]), right], axis=1)
    factors, _, _ = jax.lax.linalg.lu(whole)
    solution = jax.lax.linalg.triangular_solve(factors[:, :-1], factors[:, -1:], left_side=True)[:, 0]
    return jnp.concatenate([solution[:n], scale * solution[n:]])
