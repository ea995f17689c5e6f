"""Derivatives of residual and outputs at equilibrium with respect to motions, reactions and inputs."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray, Tree
from supple.equations.balance import balance
from supple.equations.compiled_machine import CompiledStart
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import ControlStep, SystemMotion, advance
from supple.equations.control_force import stepped
from supple.equations.steady_motion import in_turning_axes
from supple.machine.laws.instants import uneven_times
from supple.stepping.external_inputs import ExternalInputs
from supple.stepping.sensed_outputs import SensedOutputs

Array = np.ndarray
_INSTANTS = 101
"""Number of times at which loads are compared."""
_ROUNDING = 1e-9
"""Largest change that counts as rounding, as a fraction of the largest entry of the same array."""


class MotionChanges(NamedTuple):
    """Small changes about the equilibrium, in the axes of the bodies; or derivatives with respect to them."""

    position: AnyArray
    """(n,)"""
    velocity: AnyArray
    """(n,)"""
    acceleration: AnyArray
    """(n,)"""
    control: AnyArray
    """(c,) states of controllers"""
    reactions: AnyArray
    """(m,) multipliers of the joints"""
    inputs: AnyArray
    """(i,)"""


class SmallMotions(NamedTuple):
    """Derivatives at equilibrium, each an array (.., size of the change).

    residual : derivatives (n, ..) of the residual of the equations of motion, in the axes of the bodies
    outputs : derivatives (o, ..) of the outputs
    rest : (o,) outputs in the equilibrium
    """

    residual: MotionChanges
    outputs: MotionChanges
    rest: Array

    def along(self, changes: MotionChanges) -> tuple[Array, Array]:
        """Changes of reactions (m, k) and of outputs (o, k) for k columns of other changes.

        The reactions follow from `G^T dl = - dr`; the motions must satisfy the joints.
        """
        moved = zip(self.residual, changes, strict=True)
        left: AnyArray = sum(np.asarray(one) @ change for one, change in moved if change is not None)
        reactions = np.linalg.lstsq(np.asarray(self.residual.reactions), -left, rcond=None)[0]
        read = zip(self.outputs, changes._replace(reactions=reactions), strict=True)
        return reactions, np.asarray(sum(np.asarray(one) @ change for one, change in read))


def small_motions(
    rest: CompiledStart, time: float, given: ExternalInputs, sensed: SensedOutputs
) -> SmallMotions:
    """Derivatives of residual and outputs of a machine at equilibrium, by JAX's forward mode."""
    model, n = rest.model, rest.model.n_velocities
    axes = in_turning_axes(model, rest.configuration)
    sizes = [np.size(law.initial) for law in model.controllers]

    def motion(at: MotionChanges) -> SystemMotion:
        still = _at_rest(rest, np.asarray(time))
        control = still.control
        if control is not None:
            own = jnp.split(at.control, np.cumsum(sizes)[:-1])
            states = tuple(
                jnp.asarray(state).at[: len(change)].add(change)
                for state, change in zip(control.start.states, own, strict=True)
            )
            control = control._replace(start=control.start._replace(states=states))
        return still._replace(
            configuration=advance(model, rest.configuration, axes @ at.position),
            velocity=axes @ at.velocity,
            acceleration=axes @ at.acceleration,
            multipliers=rest.multipliers + at.reactions,
            control=control,
        )

    def outputs(at: MotionChanges, before: AnyArray) -> AnyArray:
        inputs = given.start + at.inputs
        read = replace(sensed, reads=given.given(sensed.reads, inputs))
        return read.at(given.given(model, inputs), motion(at), before, 0.0)

    def residual(at: MotionChanges) -> AnyArray:
        return axes.T @ balance(given.given(model, given.start + at.inputs), motion(at)).residual

    def derivatives(at: MotionChanges) -> tuple[MotionChanges, MotionChanges, AnyArray]:
        before = outputs(at, jnp.zeros(len(sensed.variables)))
        both = jax.jacfwd(lambda change: (residual(change), outputs(change, before)))(at)
        return *both, before

    lengths = (n, n, n, sum(sizes), len(rest.multipliers), len(given.start))
    still = MotionChanges(*map(np.zeros, lengths))
    found = jax.jit(derivatives).lower(still).compile(STARTING)(still)
    return SmallMotions(*jax.tree.map(np.asarray, found))


def varies_in_time(rest: CompiledStart, begin: float, end: float) -> bool:
    """Whether forces, joints or controllers of a machine at rest differ at 101 unevenly spaced times."""

    def terms(time: AnyArray) -> Tree:
        motion = _at_rest(rest, time)
        found, after = balance(rest.model, motion), stepped(rest.model, motion)
        return found.applied + found.inertia, found.constraint_residual, () if after is None else after.rates

    times = uneven_times(begin, end, _INSTANTS)
    program = jax.jit(lambda every: jax.lax.map(terms, every)).lower(times).compile(STARTING)
    every = [np.asarray(leaf) for leaf in jax.tree.leaves(program(times)) if leaf.size]
    # Without laws that depend on time, the values are equal to the last digit.
    return any(np.ptp(each, axis=0).max() > _ROUNDING * np.abs(each).max() for each in every)


def _at_rest(rest: CompiledStart, time: AnyArray) -> SystemMotion:
    control = None if rest.control is None else ControlStep(rest.control, np.zeros(()))
    at = rest.configuration, rest.velocity, rest.acceleration, rest.multipliers
    return SystemMotion(time, *at, control)
