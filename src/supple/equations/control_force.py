"""Controllers, as a term of the equations: their readings, their states, and the loads they drive.

The states z of a controller with readings y obey the trapezoidal rule over a step h,

    z_1 = z_0 + h/2 ( f(t_0, y_0, z_0) + f(t_1, y_1, z_1) ),

which is solved for z_1 at each evaluation of the equations of motion. The outputs at the end of the step are
then functions of the time and of the readings y_1 alone. The tangent includes the derivatives of the outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.equations.ends import markers
from supple.equations.machine_model import Actuator, ControlLaw, Ends, Model
from supple.equations.marker import (
    N_LOCAL,
    Marker,
    displaced,
    generalized_force,
    pose,
    with_rates,
)
from supple.equations.places import MatrixBlock, Places, member
from supple.errors import ModelError
from supple.integrate import StepFactors
from supple.machine.forces.relative_motion import AxialMotion, axial_motion, wrapped
from supple.machine.pose import Pose, Wrench

Readings = dict[str, Pose | AxialMotion]
"""Readings of a controller by name: of an end, or of a joint."""


_ITERATIONS = 3
"""Newton iterations for the states of one step; a single one is exact if the rates are linear in them."""


def force(model: Model, motion: SystemMotion) -> Iterator[tuple[Places, jax.Array]]:
    """Generalised forces on the bodies that controllers drive."""
    for number, law in enumerate(model.controllers):
        zero = jnp.zeros((len(law.seen_ends), N_LOCAL))
        local = local_forces(law, number, motion)(zero, zero)
        for rows in by_body(law.driven_ends).values():
            places, carried = moved_with(law.driven_ends, rows)
            yield places, (carried.T @ local[np.array(rows)].reshape(-1))[None]


def tangent(
    model: Model, motion: SystemMotion, turns: jax.Array, factors: StepFactors
) -> Iterator[MatrixBlock]:
    """Derivative of `force` with respect to the accelerations at the end of the step."""
    for number, law in enumerate(model.controllers):
        ends, driven = law.seen_ends, law.driven_ends
        zero = jnp.zeros((len(ends), N_LOCAL))
        by_place, by_rate = jax.jacfwd(local_forces(law, number, motion), argnums=(0, 1))(zero, zero)
        for rows in by_body(driven).values():
            row_places, on_bodies = moved_with(driven, rows)
            for body, columns in by_body(ends).items():
                column_places, by_velocities = moved_with(ends, columns)
                _, by_increments = moved_with(ends, columns, turns[body])
                of_places, of_rates = (
                    part[np.array(rows)][:, :, np.array(columns)].reshape(len(on_bodies), -1)
                    for part in (by_place, by_rate)
                )
                change = factors.by_position * of_places @ by_increments
                change = change + factors.by_velocity * of_rates @ by_velocities
                yield MatrixBlock(row_places, column_places, (on_bodies.T @ change)[None])


def stepped(model: Model, motion: SystemMotion) -> ControlState | None:
    """State of the controllers at the end of a step; None without controllers.

    In a step of zero length the states z are constant. Their rates and the joint angles are computed anew.
    """
    if not model.controllers:
        return None
    step = _step(motion)
    states, rates = [], []
    for number, law in enumerate(model.controllers):
        now = readings_of(law, step.start.states[number], _poses(law, motion))
        own = _new_states(law, number, motion, now)
        angles = [each.angle for each in now.values() if isinstance(each, AxialMotion)]
        states.append(jnp.concatenate([own, jnp.stack(angles)]) if angles else own)
        rates.append(rates_of(law, motion.time, now, own))
    return step.start._replace(states=tuple(states), rates=tuple(rates))


def outputs(model: Model, motion: SystemMotion) -> tuple[jax.Array, ...]:
    """Outputs (c,) of each controller, in the order of the elements that it drives."""
    found = []
    for number, (law, readings) in enumerate(zip(model.controllers, readings_at(model, motion), strict=True)):
        given = _outputs(law, number, motion, readings)
        found.append(jnp.concatenate([_added(law, each, given).ravel() for each in law.actuators]))
    return tuple(found)


def readings_at(model: Model, motion: SystemMotion) -> tuple[Readings, ...]:
    """The readings of each controller."""
    step = _step(motion)
    return tuple(
        readings_of(law, step.start.states[number], _poses(law, motion))
        for number, law in enumerate(model.controllers)
    )


def first_states(model: Model) -> np.ndarray:
    """Initial states of all traced controllers, one controller after the other."""
    return np.concatenate([np.zeros(0), *(np.asarray(law.initial) for law in model.controllers)])


def resting_control(model: Model, states: AnyArray) -> ControlStep | None:
    """A step of zero length, with constant states of the controllers; None without controllers.

    For controllers traced by JAX, not for sampled ones.
    """
    if not model.controllers:
        return None
    every = []
    for law, own in zip(model.controllers, states_by_controller(model, states), strict=True):
        every.append(np.array([*own, *(reader.near for reader in law.readers if reader.of_joint)]))
    none = tuple(np.zeros(np.shape(law.initial)) for law in model.controllers)
    empty: tuple[dict[str, AnyArray], ...] = tuple({} for _ in every)
    return ControlStep(ControlState(tuple(every), none, empty, empty), np.zeros(()))


def states_by_controller(model: Model, states: AnyArray) -> list[np.ndarray]:
    """The states of each controller among those of all."""
    sizes = [np.size(law.initial) for law in model.controllers]
    return np.split(np.asarray(states), np.cumsum(sizes)[:-1]) if sizes else []


def _step(motion: SystemMotion) -> ControlStep:
    if motion.control is None:
        raise ModelError(
            "the system has controllers, which this analysis does not support (only runs and equilibria do): "
            "remove them with replace(system, controllers=())"
        )
    return motion.control


def by_body(ends: list[Ends]) -> dict[int, list[int]]:
    """Numbers of the ends on each body, without the ground."""
    found: dict[int, list[int]] = {}
    for number, end in enumerate(ends):
        if not end.on_ground:
            found.setdefault(end.bodies[0], []).append(number)
    return found


def moved_with(
    ends: list[Ends], numbers: list[int], turn: AnyArray | None = None
) -> tuple[Places, jax.Array]:
    """Positions of a body's velocities in the vector of all velocities, and a matrix (12 k, 6 + r).

    The matrix maps these velocities to the local freedoms of the body's k ends. With `turn` (3, 3), it
    applies to increments of the frame's rotation vector instead of its angular velocity; `turn` maps these
    increments to rotations.
    """
    frame = jax.scipy.linalg.block_diag(jnp.eye(3), jnp.eye(3) if turn is None else turn)
    parts = [jax.scipy.linalg.block_diag(frame, jnp.asarray(ends[number].motion)[0]) for number in numbers]
    places = ends[numbers[0]].velocities
    assert places is not None
    return places, jnp.concatenate(parts)


def _all_markers(law: ControlLaw, motion: SystemMotion) -> Marker:
    """All ends in their present state, stacked."""
    every = [markers(end, motion.configuration, motion.velocity) for end in law.seen_ends]
    return jax.tree.map(lambda *leaves: jnp.concatenate([jnp.asarray(leaf) for leaf in leaves]), *every)


def moved_markers(law: ControlLaw, motion: SystemMotion) -> Callable[[jax.Array, jax.Array], Marker]:
    """All ends, stacked, as a function of their displacements and rates (e, 12)."""
    present = _all_markers(law, motion)

    def of(variations: jax.Array, rates: jax.Array) -> Marker:
        return jax.vmap(with_rates)(jax.vmap(displaced)(present, variations), rates)

    return of


def _poses(law: ControlLaw, motion: SystemMotion) -> Pose:
    """Poses of all ends, stacked."""
    return jax.vmap(pose)(_all_markers(law, motion))


def readings_of(law: ControlLaw, states: AnyArray, seen: Pose) -> Readings:
    """Readings by name; joint angles include the revolutions counted in the states."""
    found: Readings = {}
    counted = len(law.initial)
    for number, reader in enumerate(law.readers):
        first, second = member(seen, 2 * number), member(seen, 2 * number + 1)
        if not reader.of_joint:
            found[reader.name] = first
            continue
        own, before = axial_motion(first, second), states[counted]
        found[reader.name] = own._replace(angle=before + wrapped(own.angle - before))
        counted += 1
    return found


def rates_of(law: ControlLaw, time: AnyArray, readings: Readings, states: jax.Array) -> jax.Array:
    """`f(t, y, z)`, (k,)."""
    if law.rates is None:
        return jnp.zeros(0)
    of_states = f"controller '{law.name}': the rates of its states"
    rates = _real(_called(law, "rates", time, readings, states), of_states)
    if rates.shape != states.shape:
        raise ModelError(
            f"{of_states} have shape {rates.shape}, the states {states.shape}: return one rate for each state"
        )
    return rates


def _called(law: ControlLaw, name: str, *arguments: Any) -> Any:
    """Result of `outputs` or `rates`; ModelError if it cannot be traced, or reads an unknown name."""
    try:
        return getattr(law, name)(*arguments)
    except (jax.errors.ConcretizationTypeError, jax.errors.TracerArrayConversionError) as error:
        raise ModelError(
            f"controller '{law.name}': its function {name} needs the value of a traced array: write "
            "jnp.where instead of if, and jax.numpy instead of math and numpy; or use a SampledController, "
            "whose law is plain Python"
        ) from error
    except KeyError as error:
        raise ModelError(
            f"controller '{law.name}': its function {name} uses {error}; available are {sorted(arguments[1])}"
        ) from error


def _real(value: Any, what: str) -> jax.Array:
    try:
        return jnp.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{what} must be real numbers, got {value}") from error


def _new_states(law: ControlLaw, number: int, motion: SystemMotion, readings: Readings) -> jax.Array:
    """`z_1`, (k,)."""
    step = _step(motion)
    old, rates = step.start.states[number][: len(law.initial)], step.start.rates[number]
    if law.rates is None:
        return old
    half = step.size / 2

    def residual(states: jax.Array) -> jax.Array:
        return states - old - half * (rates + rates_of(law, motion.time, readings, states))

    states = old + step.size * rates
    # Unrolled for differentiation: the derivative of the last iteration is exactly that of the solution.
    for _ in range(_ITERATIONS):
        states = states - jnp.linalg.solve(jax.jacfwd(residual)(states), residual(states))
    return states


def _outputs(
    law: ControlLaw, number: int, motion: SystemMotion, readings: Readings
) -> Mapping[str, AnyArray]:
    """Outputs by name of the actuator."""
    if law.outputs is None:
        return _step(motion).start.held[number]
    states = _new_states(law, number, motion, readings)
    found = _called(law, "outputs", motion.time, readings, states)
    names = {each.name for each in law.actuators}
    if not isinstance(found, Mapping) or set(found) != names:
        given = sorted(found) if isinstance(found, Mapping) else type(found).__name__
        raise ModelError(
            f"controller '{law.name}': its outputs must be a dictionary for {sorted(names)}, got {given}"
        )
    return found


def _added(law: ControlLaw, driven: Actuator, given: Mapping[str, AnyArray]) -> jax.Array:
    """The output for a driven element, in the shape of the value of the element's law."""
    what = f"controller '{law.name}': its output '{driven.name}'"
    added = _real(given[driven.name], what)
    if added.size != np.prod(driven.shape):
        raise ModelError(f"{what} must have the shape {driven.shape}, got {added.shape}")
    return jnp.reshape(added, driven.shape)


def local_forces(
    law: ControlLaw, number: int, motion: SystemMotion
) -> Callable[[jax.Array, jax.Array], jax.Array]:
    """Function that returns the forces (a, 12) on the driven ends, a in number.

    Its arguments are the displacements and the rates, (e, 12) each, of all ends of `seen_ends`.
    """
    at = moved_markers(law, motion)
    n_read = 2 * len(law.readers)

    def of(variations: jax.Array, rates: jax.Array) -> jax.Array:
        moved = at(variations, rates)
        poses = jax.vmap(pose)(moved)
        readings = readings_of(law, _step(motion).start.states[number], poses)
        given = _outputs(law, number, motion, readings)
        loads: list[Wrench] = []
        for place, each in enumerate(law.actuators):
            own, parameters = member((each.force.law, each.force.parameters), 0)
            ends = member(poses, n_read + 2 * place), member(poses, n_read + 2 * place + 1)
            assert own is not None
            loads += each.force.wrenches(*ends, own(motion.time) + _added(law, each, given), parameters)
        every = jax.tree.map(lambda *leaves: jnp.stack(leaves), *loads)
        return jax.vmap(generalized_force)(jax.tree.map(lambda leaf: leaf[n_read:], moved), every)

    return of
