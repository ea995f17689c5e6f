"""Controllers, as a term of the equations: what they read, their states, and the loads they drive.

The states of a controller obey the trapezoidal rule over the step,

    z_1 = z_0 + h/2 ( f(t_0, y_0, z_0) + f(t_1, y_1, z_1) ),

solved for z_1 wherever the equations are evaluated: outputs are functions of the motion y_1 alone, and the
tangent is theirs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import jax
import jax.numpy as jnp

from supple.errors import ModelError
from supple.integrate import StepFactors
from supple.machine.forces.relative_motion import axial_motion, wrapped
from supple.multibody.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.multibody.equations.ends import columns_on_velocities, markers, turns_of
from supple.multibody.equations.marker import N_LOCAL, Marker, displaced, pose, with_rates
from supple.multibody.equations.marker_force import on_local_freedoms
from supple.multibody.equations.model import ControlLaw, Ends, Model
from supple.multibody.equations.places import Block, Places

__all__ = ["force", "readings_at", "stepped", "tangent"]

_ITERATIONS = 3
"""Of Newton, for the states of one step: one is exact where the rates are linear in the states."""


def force(model: Model, motion: SystemMotion) -> Iterator[tuple[Places, jax.Array]]:
    """Generalised forces on the bodies that controllers drive."""
    for number, law in enumerate(model.controllers):
        ends = _ends(law)
        still = jnp.zeros((len(ends), N_LOCAL))
        local = _local_forces(law, number, motion)(still, still)
        for end, own in zip(_driven(law), local, strict=True):
            if end.velocities is not None:
                yield end.velocities, _on_body(end, own)[None]


def tangent(model: Model, motion: SystemMotion, turns: jax.Array, factors: StepFactors) -> Iterator[Block]:
    """Change of these forces with the new accelerations."""
    for number, law in enumerate(model.controllers):
        ends = _ends(law)
        still = jnp.zeros((len(ends), N_LOCAL))
        by_place, by_rate = jax.jacfwd(_local_forces(law, number, motion), argnums=(0, 1))(still, still)
        for row, (driven, of_row) in enumerate(zip(_driven(law), by_place, strict=True)):
            for column, seen in enumerate(ends):
                if driven.velocities is None or seen.velocities is None:
                    continue
                own_turns = turns_of(seen, turns)
                places = columns_on_velocities(seen, of_row[None, :, column], own_turns)
                rates = columns_on_velocities(seen, by_rate[row][None, :, column], None)
                values = factors.by_position * places + factors.by_velocity * rates
                yield Block(driven.velocities, seen.velocities, _on_body(driven, values[0])[None])


def stepped(model: Model, motion: SystemMotion) -> ControlState | None:
    """The controllers at the end of a step; with a step of no length, their rates and angles there."""
    if not model.controllers:
        return None
    step = _step(motion)
    states, rates = [], []
    for number, law in enumerate(model.controllers):
        now = _readings(law, step.start.states[number], [_at(end, motion) for end in _ends(law)])
        own = _new_states(law, number, motion, now)
        angles = [now[each.name].angle for each in law.readers if each.of_joint]
        states.append(jnp.concatenate([own, jnp.stack(angles)]) if angles else own)
        rates.append(_rates(law, motion.time, now, own))
    return step.start._replace(states=tuple(states), rates=tuple(rates))


def readings_at(model: Model, motion: SystemMotion) -> tuple[dict[str, Any], ...]:
    """What each controller reads."""
    step = _step(motion)
    return tuple(
        _readings(law, step.start.states[number], [_at(end, motion) for end in _ends(law)])
        for number, law in enumerate(model.controllers)
    )


def _step(motion: SystemMotion) -> ControlStep:
    if motion.control is None:
        raise ModelError(
            "controllers act in the runs of rigid and reduced bodies, each by itself: for an equilibrium, "
            "modes, a batch or the error of a basis leave them out, replace(system, controllers=())"
        )
    return motion.control


def _ends(law: ControlLaw) -> list[Ends]:
    """All that a controller sees and drives: readers first."""
    read = [end for each in law.readers for end in (each.first, each.second)]
    return read + _driven(law)


def _driven(law: ControlLaw) -> list[Ends]:
    return [end for each in law.actuators for end in (each.force.first, each.force.second)]


def _at(end: Ends, motion: SystemMotion) -> Marker:
    own = markers(end, motion.configuration, motion.velocity)
    return jax.tree.map(lambda leaf: jnp.asarray(leaf)[0], own)


def _on_body(end: Ends, local: jax.Array) -> jax.Array:
    """Rows for the body's velocities (6 + r, ...) of those for the local freedoms (12, ...)."""
    return jnp.concatenate([local[:6], jnp.asarray(end.motion)[0].T @ local[6:]])


def _readings(law: ControlLaw, states: Any, seen: list[Marker]) -> dict[str, Any]:
    """By name; angles near those of the states, which count the turns."""
    found: dict[str, Any] = {}
    counted = len(law.initial)
    for number, reader in enumerate(law.readers):
        first, second = pose(seen[2 * number]), pose(seen[2 * number + 1])
        if not reader.of_joint:
            found[reader.name] = first
            continue
        own, before = axial_motion(first, second), states[counted]
        found[reader.name] = own._replace(angle=before + wrapped(own.angle - before))
        counted += 1
    return found


def _rates(law: ControlLaw, time: Any, readings: Mapping[str, Any], states: jax.Array) -> jax.Array:
    if law.rates is None:
        return jnp.zeros(0)
    rates = jnp.asarray(law.rates(time, readings, states), dtype=float)
    if rates.shape != states.shape:
        raise ModelError(
            f"the rates of a controller's states have shape {rates.shape}, its states {states.shape}"
        )
    return rates


def _new_states(law: ControlLaw, number: int, motion: SystemMotion, readings: Mapping[str, Any]) -> jax.Array:
    """`z_1`, (k,)."""
    step = _step(motion)
    old, rates = step.start.states[number][: len(law.initial)], step.start.rates[number]
    if law.rates is None:
        return old
    half = step.size / 2

    def left(states: jax.Array) -> jax.Array:
        return states - old - half * (rates + _rates(law, motion.time, readings, states))

    states = old + step.size * rates
    # Unrolled, so that derivatives pass: that of the last iteration is the exact one of the solution.
    for _ in range(_ITERATIONS):
        states = states - jnp.linalg.solve(jax.jacfwd(left)(states), left(states))
    return states


def _outputs(law: ControlLaw, number: int, motion: SystemMotion, readings: Mapping[str, Any]) -> Any:
    """By name of the actuator."""
    if law.outputs is None:
        return _step(motion).start.held[number]
    found = law.outputs(motion.time, readings, _new_states(law, number, motion, readings))
    names = {each.name for each in law.actuators}
    if not isinstance(found, Mapping) or set(found) != names:
        given = sorted(found) if isinstance(found, Mapping) else type(found).__name__
        raise ModelError(f"a controller's outputs must be a dictionary for {sorted(names)}, got {given}")
    return found


def _local_forces(law: ControlLaw, number: int, motion: SystemMotion) -> Any:
    """Forces (a, 12) on the driven ends as a function of displacements and rates (e, 12) of all ends."""
    still = [_at(end, motion) for end in _ends(law)]
    n_read = 2 * len(law.readers)

    def of(variations: jax.Array, rates: jax.Array) -> jax.Array:
        moved = [
            with_rates(displaced(marker, variation), rate)
            for marker, variation, rate in zip(still, variations, rates, strict=True)
        ]
        readings = _readings(law, _step(motion).start.states[number], moved)
        outputs = _outputs(law, number, motion, readings)
        forces, none = [], jnp.zeros(2 * N_LOCAL)
        for place, each in enumerate(law.actuators):
            first, second = moved[n_read + 2 * place : n_read + 2 * place + 2]
            own, parameters = jax.tree.map(
                lambda leaf: jnp.asarray(leaf)[0], (each.force.law, each.force.parameters)
            )
            added = jnp.reshape(jnp.asarray(outputs[each.name], dtype=float), each.shape)

            def value(time: Any, own: Any = own, added: Any = added) -> Any:
                return own(time) + added

            local = on_local_freedoms(each.force.wrenches, value, parameters, first, second, motion.time)
            forces.append(local(none, none).reshape(2, N_LOCAL))
        return jnp.concatenate(forces)

    return of
