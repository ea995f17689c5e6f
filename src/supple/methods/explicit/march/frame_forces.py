"""What acts on frames besides contacts and explicit nodes, by the terms that all methods share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from supple.equations import marker_force, nodal_load
from supple.equations.balance import constraint_jacobian
from supple.equations.configuration import SystemMotion
from supple.equations.joint_force import constraints
from supple.equations.model import Model
from supple.equations.places import Places, assembled_vector
from supple.methods.explicit.frame_chart import configuration, on_points, velocity
from supple.methods.explicit.frame_model import FrameState, Generalized
from supple.methods.explicit.march.model import FrameArrays, MarchModel

__all__ = ["FrameForces", "frame_forces", "gravity_at", "joint_gaps", "joint_rows"]


class FrameForces(NamedTuple):
    """Of each frame: from laws and loads, of elements at rest, and what these add by their rates."""

    given: tuple[Generalized, ...]
    stored: tuple[Generalized, ...]
    dragged: tuple[Generalized, ...]


def gravity_at(model: MarchModel, time: Array) -> Array:
    """Gravity seen from a base that accelerates, (3,)."""
    return model.gravity - sum(law(time) for law in model.base_accelerations)


def frame_forces(
    machine: Model, frames: tuple[FrameArrays, ...], states: tuple[FrameState, ...], time: Array
) -> FrameForces:
    """At t_n, with the rates of the step before.

    machine : the frames as bodies, with their loads and force elements
    """
    charts = tuple(each.chart for each in frames)
    where, rates = configuration(charts, states), velocity(charts, states)
    none = jnp.zeros(len(machine.active))
    motion = SystemMotion(time, where, rates, jnp.zeros_like(rates), none)
    with_laws = replace(machine, forces=tuple(own for own in machine.forces if own.law is not None))
    alone = replace(machine, forces=tuple(own for own in machine.forces if own.law is None))
    given = assembled_vector(machine.n_velocities, [*_loads(machine, motion), *_elements(with_laws, motion)])
    stored = assembled_vector(
        machine.n_velocities, _elements(alone, motion._replace(velocity=jnp.zeros_like(rates)))
    )
    dragged = assembled_vector(machine.n_velocities, _elements(alone, motion)) - stored
    return FrameForces(*(_by_frame(machine, frames, states, forces) for forces in (given, stored, dragged)))


def _elements(machine: Model, motion: SystemMotion) -> Iterator[tuple[Places, Array]]:
    for group in machine.forces:
        yield from marker_force.force(machine, group, motion)


def _loads(machine: Model, motion: SystemMotion) -> Iterator[tuple[Places, Array]]:
    for load in machine.nodal_loads:
        yield load.velocities, nodal_load.force(load, motion)


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
    """Derivatives of the joints' equations for points (m, 4, 3) and modes (m, k) of each frame."""
    where = configuration(tuple(each.chart for each in frames), states)
    return _by_frame(machine, frames, states, constraint_jacobian(machine, time, where))


def joint_gaps(
    machine: Model, frames: tuple[FrameArrays, ...], states: tuple[FrameState, ...], time: Array
) -> Array:
    """The joints' equations, (m,)."""
    return constraints(machine, time, configuration(tuple(each.chart for each in frames), states))
