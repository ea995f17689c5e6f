"""Accelerations of an exported machine after a change of its parameters or inputs, traceable by JAX.

The time integration takes the accelerations at both ends of a step. Without their jump, an input that changes
at the start of a step would act as one that changes linearly within the step: half a step too late.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray, Tree
from supple.equations.compiled_machine import forces_without_acceleration
from supple.equations.configuration import Configuration, ControlState, ControlStep
from supple.equations.inertia import mass_matrix
from supple.equations.machine_model import Model
from supple.equations.starting_machine import CONVERGED, MOST, joint_terms
from supple.methods.floating.compiled.state import State
from supple.stepping.external_inputs import ExternalInputs


def consistent_accelerations(
    model: Model,
    time: AnyArray,
    configuration: Configuration,
    velocity: AnyArray,
    control: ControlState | None,
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Accelerations (n,), multipliers (m,), and whether the iteration of friction and joint forces fails.

    Accelerations and multipliers solve `M vdot + G^T lambda = - forces`, `G vdot = - d2g/dt2`, with d2g/dt2
    at constant velocity.
    """
    terms = joint_terms(model, time, configuration, velocity)
    mass = mass_matrix(model.bodies_alone, configuration)
    n, m = len(mass), len(model.active)
    step = None if control is None else ControlStep(control, jnp.zeros(()))

    def solved(multipliers: AnyArray) -> AnyArray:
        forces = forces_without_acceleration(model, time, configuration, velocity, step, multipliers)
        return _solved(mass, terms.jacobian, forces, terms.acceleration_bias)

    found = solved(jnp.zeros(m))
    if not model.reads_reactions:
        return found[:n], found[n:], jnp.asarray(False)

    def differs(state: Tree) -> AnyArray:
        _, before, own = state
        return jnp.max(abs(own[n:] - before)) > CONVERGED * jnp.max(abs(own[n:]))

    _, before, found = jax.lax.while_loop(
        lambda state: differs(state) & (state[0] < MOST),
        lambda state: (state[0] + 1, state[2][n:], solved(state[2][n:])),
        (0, jnp.zeros(m), found),
    )
    return found[:n], found[n:], ~(jnp.max(abs(found[n:] - before)) <= CONVERGED * jnp.max(abs(found[n:])))


def after_jump(inputs: ExternalInputs, arrays: Model, state: State, held: AnyArray, given: AnyArray) -> State:
    """The state with the accelerations and joint forces of new inputs; unchanged for equal inputs.

    held, given : (i,) inputs before and after
    """

    @jax.custom_jvp
    def jump(differs: AnyArray, before: Model, now: Model, at: Tree) -> tuple[AnyArray, AnyArray]:
        none = jnp.zeros_like(state.acceleration), jnp.zeros_like(state.multipliers)
        return jax.lax.cond(differs, lambda: _acceleration_jump(before, now, *at), lambda: none)

    @jump.defjvp
    def _(primals: Tree, tangents: Tree) -> Tree:  # also of equal inputs, at which a jump has a derivative
        changed = jax.jvp(lambda *given: _acceleration_jump(*given[:2], *given[2]), primals[1:], tangents[1:])
        return jump(*primals), changed[1]

    at = (state.time, state.configuration, state.velocity, state.control)
    models = inputs.given(arrays, held), inputs.given(arrays, given)
    by_acceleration, by_force = jump(jnp.any(given != held), *models, at)
    return state._replace(
        acceleration=state.acceleration + by_acceleration,
        auxiliary=state.auxiliary + by_acceleration,
        multipliers=state.multipliers + by_force,
    )


def _acceleration_jump(
    before: Model,
    now: Model,
    time: AnyArray,
    configuration: Configuration,
    velocity: AnyArray,
    control: ControlState | None,
) -> tuple[AnyArray, AnyArray]:
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


def _solved(mass: AnyArray, jacobian: AnyArray, forces: AnyArray, bias: AnyArray) -> AnyArray:
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
