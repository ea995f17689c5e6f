"""Forces on frames except those of contacts and explicit nodes, by the terms shared with all methods."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.arrays import AnyArray
from supple.equations import control_force, marker_force, nodal_load
from supple.equations.balance import constraint_jacobian
from supple.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.equations.ends import markers
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.equations.marker import Marker, pose
from supple.equations.places import Places, assembled_vector, over
from supple.machine import Constant, ForceElement
from supple.machine.laws.time_law import TimeLaw
from supple.methods.explicit.frame_chart import configuration, on_points, velocity
from supple.methods.explicit.frame_model import FrameState, Generalized
from supple.methods.explicit.march.march_model import FrameArrays, MarchModel
from supple.value_content import fixed_function


class FrameForces(NamedTuple):
    """Forces on each frame.

    given : forces of loads, controllers, and force elements without stored energy
    stored, dragged : forces of elements with stored energy: at zero rates, and the change due to rates
    """

    given: tuple[Generalized, ...]
    stored: tuple[Generalized, ...]
    dragged: tuple[Generalized, ...]


def gravity_at(model: MarchModel, time: Array) -> Array:
    """Gravity relative to an accelerated base, (3,)."""
    return model.gravity - sum(law(time) for law in model.base_accelerations)


def frame_forces(
    machine: Model,
    stores: tuple[bool, ...],
    frames: tuple[FrameArrays, ...],
    states: tuple[FrameState, ...],
    time: Array,
    control: ControlState | None,
) -> FrameForces:
    """Forces at t_n, with the rates of the step before.

    machine : the frames as bodies, with their loads and force elements
    stores : whether each group of elements stores energy
    """
    motion = frame_states(machine, frames, states, time, control)
    at_rest = motion._replace(velocity=jnp.zeros_like(motion.velocity))
    storing = _some(machine, stores, True)
    n, others = machine.n_velocities, _some(machine, stores, False)
    controlled = control_force.force(machine, motion)
    loads = [(load.velocities, nodal_load.force(load, motion)) for load in machine.nodal_loads]
    given = assembled_vector(n, [*loads, *_elements(others, motion), *controlled])
    stored = assembled_vector(n, _elements(storing, at_rest))
    dragged = assembled_vector(n, _elements(storing, motion)) - stored
    return FrameForces(*(_by_frame(machine, frames, states, forces) for forces in (given, stored, dragged)))


def _some(machine: Model, stores: tuple[bool, ...], wanted: bool) -> Model:
    groups = zip(machine.forces, stores, strict=True)
    return replace(machine, forces=tuple(group for group, own in groups if own is wanted))


def frame_states(
    machine: Model,
    frames: tuple[FrameArrays, ...],
    states: tuple[FrameState, ...],
    time: Array,
    control: ControlState | None = None,
    step: Array | float = 0.0,
) -> SystemMotion:
    """The frames as floating bodies at t_n, with the rates of the step before.

    control : state of the controllers one step earlier;   step : length of that step, s
    """
    charts = tuple(each.chart for each in frames)
    rates = velocity(charts, states)
    none = jnp.zeros(len(machine.active))
    stepping = None if control is None else ControlStep(control, jnp.asarray(step))
    where = configuration(charts, states)
    return SystemMotion(time, where, rates, jnp.zeros_like(rates), none, stepping)


def storing_elements(machine: Model, loads: Iterable[ForceElement]) -> tuple[bool, ...]:
    """Whether each group of elements stores energy: it defines an energy, and no law drives it in time."""
    wrenches = [
        fixed_function(type(load).wrenches) for load in loads if type(load).energy is not ForceElement.energy
    ]
    return tuple(
        group.wrenches in wrenches and (group.law is None or isinstance(group.law, Constant))
        for group in machine.forces
    )


def stored_energy(
    loads: Iterable[ForceElement],
    stores: tuple[bool, ...],
    machine: Model,
    frames: tuple[FrameArrays, ...],
    states: tuple[FrameState, ...],
    time: Array,
) -> Array:
    """Stored energy of force elements, J."""
    energies = {fixed_function(type(load).wrenches): type(load).energy for load in loads}
    motion, total = frame_states(machine, frames, states, time), jnp.zeros(())
    for group in _some(machine, stores, True).forces:

        def own(
            law: TimeLaw | None,
            parameters: AnyArray,
            *ends: Marker,
            of: Callable[..., AnyArray] = energies[group.wrenches],
        ) -> Array:
            value = None if law is None else law(time)
            return jnp.asarray(of(*map(pose, ends), value, parameters))

        ends = (markers(end, motion.configuration, motion.velocity) for end in (group.first, group.second))
        total = total + over(own, group.law, group.parameters, *ends).sum()
    return total


def _elements(machine: Model, motion: SystemMotion) -> Iterator[tuple[Places, Array]]:
    for group in machine.forces:
        yield from marker_force.force(machine, group, motion)


def _by_frame(
    machine: Model, frames: tuple[FrameArrays, ...], states: tuple[FrameState, ...], forces: Array
) -> tuple[Generalized, ...]:
    """Generalised forces (.., n) of all frames as forces on the points and modes of each."""
    return tuple(
        on_points(own.chart, at, forces[..., part])
        for own, at, part in zip(frames, states, machine.slices, strict=True)
    )


def joint_rows(
    machine: Model, frames: tuple[FrameArrays, ...], states: tuple[FrameState, ...], time: Array
) -> tuple[Generalized, ...]:
    """Derivatives of the joints' equations by points (m, 4, 3) and modes (m, k) of each frame."""
    where = configuration(tuple(each.chart for each in frames), states)
    return _by_frame(machine, frames, states, constraint_jacobian(machine, time, where))


def joint_gaps(
    machine: Model, frames: tuple[FrameArrays, ...], states: tuple[FrameState, ...], time: Array
) -> Array:
    """Residuals of the joints' equations, (m,)."""
    return constraints(machine, time, configuration(tuple(each.chart for each in frames), states))
