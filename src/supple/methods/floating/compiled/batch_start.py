"""Consistent initial states of many load cases: the common part is computed once, forces case by case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple, TypeAlias

import jax
import numpy as np
from jax.tree_util import PyTreeDef

from supple.arrays import AnyArray, Tree
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import (
    CompiledMachine,
    bordered_solve,
    forces_without_acceleration,
)
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import placed_configuration, placed_velocity
from supple.equations.machine_model import Model
from supple.equations.start_velocity import given_parts
from supple.integrate import Run
from supple.machine import System
from supple.methods.floating.compiled.engine import initial_state
from supple.methods.floating.compiled.state import State
from supple.programs.program_cache import CachedProgram

_AT_ONCE = 64
"""Number of cases whose forces are evaluated together; a shorter last set is padded to this number."""


Axes: TypeAlias = tuple[int | None, ...]
"""For each leaf: 0 where the cases differ, None where they share it"""


def differing(trees: Sequence[Tree]) -> Axes:
    """Batch axis of each leaf of pytrees of equal structure: 0 where they differ, else None."""
    columns = zip(*(jax.tree.leaves(tree) for tree in trees), strict=True)

    def equal(leaves: Sequence[AnyArray]) -> bool:
        first = leaves[0]
        others = (leaf for leaf in leaves[1:] if leaf is not first)
        return all(np.array_equal(np.asarray(leaf), np.asarray(first)) for leaf in others)

    return tuple(None if equal(column) else 0 for column in columns)


def stacked(trees: Sequence[Tree], axes: Axes) -> list[np.ndarray]:
    """The leaves of all pytrees: shared leaves once, those that differ stacked along a new first axis."""
    columns = zip(*(jax.tree.leaves(tree) for tree in trees), strict=True)
    return [
        np.asarray(column[0]) if axis is None else np.stack([np.asarray(leaf) for leaf in column])
        for column, axis in zip(columns, axes, strict=True)
    ]


def form_of(tree: Tree) -> tuple[PyTreeDef, list[tuple[int, ...]]]:
    """Structure of a pytree, and the shapes of its leaves."""
    leaves, structure = jax.tree.flatten(tree)
    return structure, [np.shape(leaf) for leaf in leaves]


class BatchStart(NamedTuple):
    """Models and consistent initial states of the cases."""

    models: list[Model]
    states: list[State]


def batch_start(cases: Sequence[System], run: Run) -> BatchStart:
    """Models and consistent states of cases, equal to those of `initial_state` for each case.

    Cases with the bodies, joints and initial motion of the first case differ in their forces alone. Their
    positions, velocities and redundant equations are those of the first case; their accelerations solve

        M vdot + G^T lambda = - forces,      G vdot = - d2g/dt2 at constant velocity
    """
    first = cases[0]
    model, state = _initial_state(first, run)
    models, states, alike = [model], [state], []
    for number, system in enumerate(cases[1:], 1):
        own = build_model(system, model.active, (first, model))
        if _starts_alike(first, model, system, own):
            # Share the arrays of the first case, so that nothing is stored or compared twice.
            own, begun = replace(own, groups=model.groups, joints=model.joints), state
            alike.append(number)
        else:
            own, begun = _initial_state(system, run)
        models.append(own)
        states.append(begun)
    if alike:
        machine = CompiledMachine(first, model)
        for number, (acceleration, multipliers) in zip(
            alike, _accelerations(machine, state, [models[i] for i in alike]), strict=True
        ):
            states[number] = state._replace(
                acceleration=acceleration, auxiliary=acceleration, multipliers=multipliers
            )
    return BatchStart(models, states)


def _initial_state(system: System, run: Run) -> tuple[Model, State]:
    """Initial state of one case, with a frozen tangent on CPUs only: other devices map the cases."""
    model, state = initial_state(system, run.times[0], run.step_control.first, run.validity)
    return model, state if jax.default_backend() == "cpu" else state._replace(kept=None)


def _starts_alike(first: System, model: Model, system: System, own: Model) -> bool:
    """Whether two cases differ only in their forces at the start."""

    def same(one: Tree, other: Tree) -> bool:
        if jax.tree.structure(one) != jax.tree.structure(other):
            return False
        return all(map(np.array_equal, jax.tree.leaves(one), jax.tree.leaves(other)))

    # Where forces depend on joint forces, or on controllers, each start is computed separately.
    if model.reads_reactions or own.reads_reactions or model.controllers or own.controllers:
        return False
    if [placed.body for placed in system.bodies] != [placed.body for placed in first.bodies]:
        return False
    return (
        same(placed_configuration(first), placed_configuration(system))
        and np.array_equal(placed_velocity(first), placed_velocity(system))
        and np.array_equal(given_parts(first), given_parts(system))
        and same(model.joints, own.joints)
        and same((model.length, model.mass), (own.length, own.mass))
    )


def _accelerations(
    machine: CompiledMachine, state: State, models: list[Model]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Initial accelerations and multipliers of models that differ in their forces alone."""
    velocity = np.asarray(state.velocity)
    terms = machine.joint_terms(float(state.time), state.configuration, velocity)
    mass = machine.metric(state.configuration)
    n = len(mass)
    forces = np.concatenate(
        [_forces(models[i : i + _AT_ONCE], state) for i in range(0, len(models), _AT_ONCE)]
    )
    bias = np.tile(terms.acceleration_bias, (len(forces), 1))
    solved = bordered_solve(mass, terms.jacobian, -forces.T, -bias.T)
    return [(column[:n], column[n:]) for column in solved.T]


def _forces(models: list[Model], state: State) -> np.ndarray:
    """Residuals (k, n) at zero accelerations and multipliers."""
    filled = models + models[-1:] * (_AT_ONCE - len(models))
    axes = differing(filled)
    program = _mapped_forces(jax.tree.structure(models[0]), axes)
    leaves = stacked(filled, axes)
    return np.asarray(program(leaves, state.time, state.configuration, state.velocity))[: len(models)]


@lru_cache(maxsize=32)
def _mapped_forces(model_structure: PyTreeDef, axes: Axes) -> CachedProgram:
    return CachedProgram(partial(_forces_of_cases, model_structure, axes), STARTING)


def _forces_of_cases(
    model_structure: PyTreeDef,
    axes: Axes,
    leaves: list[jax.Array],
    time: jax.Array,
    configuration: Configuration,
    velocity: jax.Array,
) -> jax.Array:
    def of_case(own: list[jax.Array]) -> jax.Array:
        model = jax.tree.unflatten(model_structure, own)
        return forces_without_acceleration(model, time, configuration, velocity)

    return jax.vmap(of_case, in_axes=(list(axes),), axis_size=_AT_ONCE)(leaves)
