"""Forces between markers, as a term of the equations; tangents by differentiation."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import jax
import jax.numpy as jnp

from supple.arrays import AnyArray
from supple.equations.configuration import SystemMotion
from supple.equations.ends import blocks_on_bodies, forces_on_bodies, markers
from supple.equations.joint_force import all_multipliers
from supple.equations.machine_model import ForceGroup, Model
from supple.equations.marker import (
    N_LOCAL,
    Marker,
    displaced,
    generalized_force,
    pose,
    with_rates,
)
from supple.equations.places import MatrixBlock, Places, over
from supple.integrate import StepFactors
from supple.machine import TimeLaw
from supple.machine.pose import Wrench


def _on_local_freedoms(
    wrenches: Callable[..., tuple[Wrench, Wrench]],
    law: TimeLaw | None,
    parameters: tuple[AnyArray, ...],
    reaction: AnyArray | None,
    first: Marker,
    second: Marker,
    time: AnyArray,
) -> Callable[[jax.Array, jax.Array], jax.Array]:
    """Generalised forces (24,) of a force element as a function of displacements and rates (24,) each."""

    def of(variation: jax.Array, rates: jax.Array) -> jax.Array:
        one = with_rates(displaced(first, variation[:N_LOCAL]), rates[:N_LOCAL])
        other = with_rates(displaced(second, variation[N_LOCAL:]), rates[N_LOCAL:])
        value = reaction if law is None else law(time)
        on_first, on_second = wrenches(pose(one), pose(other), value, parameters)
        return jnp.concatenate([generalized_force(one, on_first), generalized_force(other, on_second)])

    return of


def _ends(forces: ForceGroup, motion: SystemMotion) -> tuple[Marker, Marker]:
    return (
        markers(forces.first, motion.configuration, motion.velocity),
        markers(forces.second, motion.configuration, motion.velocity),
    )


def _reactions(model: Model, forces: ForceGroup, motion: SystemMotion) -> AnyArray | None:
    """Joint multipliers on which the forces depend, (k, 2); None for forces without such a dependence."""
    if forces.reaction is None:
        return None
    return forces.reaction.take(all_multipliers(model, jnp.asarray(motion.multipliers)))


def force(model: Model, forces: ForceGroup, motion: SystemMotion) -> Iterator[tuple[Places, jax.Array]]:
    """Generalised forces on the bodies at both ends."""
    still = jnp.zeros(2 * N_LOCAL)

    def of_element(law, parameters, reaction, first, second):
        local = _on_local_freedoms(forces.wrenches, law, parameters, reaction, first, second, motion.time)
        both = local(still, still)
        return both[:N_LOCAL], both[N_LOCAL:]

    reactions = _reactions(model, forces, motion)
    local = over(of_element, forces.law, forces.parameters, reactions, *_ends(forces, motion))
    yield from forces_on_bodies(forces, local)


def tangent(
    model: Model, forces: ForceGroup, motion: SystemMotion, turns: jax.Array, factors: StepFactors
) -> Iterator[MatrixBlock]:
    """Derivative of the generalised forces by the new accelerations, at constant joint multipliers.

    The tangent does not contain the dependence of friction on the multipliers: with such friction, Newton's
    iteration converges linearly, at a rate equal to the share of friction in the balance.
    """
    still = jnp.zeros(2 * N_LOCAL)

    def of_element(law, parameters, reaction, first, second):
        local = _on_local_freedoms(forces.wrenches, law, parameters, reaction, first, second, motion.time)
        return jax.jacfwd(local, argnums=(0, 1))(still, still)

    reactions = _reactions(model, forces, motion)
    by_position, by_rate = over(of_element, forces.law, forces.parameters, reactions, *_ends(forces, motion))
    halves = slice(0, N_LOCAL), slice(N_LOCAL, 2 * N_LOCAL)
    for matrix, factor, own_turns in (
        (by_position, factors.by_position, turns),
        (by_rate, factors.by_velocity, None),
    ):
        local = tuple(tuple(factor * matrix[:, rows, columns] for columns in halves) for rows in halves)
        yield from blocks_on_bodies(forces, local, own_turns)
