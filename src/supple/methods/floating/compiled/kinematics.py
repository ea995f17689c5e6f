"""Kinematic runs: machines with zero degrees of freedom, and the forces that move them."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray
from supple.equations.balance import balance, constraint_jacobian
from supple.equations.build_model import build_model
from supple.equations.checks.start_report import report_start
from supple.equations.checks.strictness import warn_or_raise
from supple.equations.compiled_machine import CompiledMachine
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import Configuration, SystemMotion, advance
from supple.equations.consistent_start import consistent_start
from supple.equations.floating_solution import floating_solution, last_instant
from supple.equations.joint_force import constraints
from supple.equations.machine_model import Model
from supple.equations.starting_machine import JointTerms, joint_terms
from supple.equations.step_size import at_rounding, position_rounding
from supple.errors import ModelError, ValidityWarning
from supple.integrate import Leg, Run, Solution, Statistics
from supple.machine import System
from supple.programs.program_cache import CachedProgram

__all__ = ["KinematicEngine"]

_KINDS = ("rigid", "reduced", "full", "intrinsic")
"""Kinds of bodies that a kinematic run supports."""
_INSTANTS_AT_ONCE = 128
"""Number of instants of a call of the compiled program."""
MOST_ITERATIONS = 20
"""Largest number of Newton iterations that close the joints at an instant."""
_REACTIONS, _CONVERGED = 60, 1e-9
"""Most iterations for friction that depends on joint forces; relative change of the forces at convergence."""
DEAD_POINT = 1e-9
"""Ratio of smallest to largest singular value of the joints' Jacobian (rotations times the machine's size)
up to which the machine is at a dead point."""


class Instant(NamedTuple):
    """Configuration, motion and joint forces at one instant."""

    time: AnyArray
    configuration: Configuration
    velocity: AnyArray
    """(n,)"""
    acceleration: AnyArray
    multipliers: AnyArray
    """(m,)"""
    iterations: AnyArray
    """Number of Newton iterations up to this instant"""
    largest_turn: AnyArray
    """Largest rotation of a body between two successive instants up to this one, rad"""
    failed: AnyArray
    """True once the joints cannot be closed; the state remains that of the last instant with closed joints"""


def of_frames(terms: JointTerms, parts: Sequence[slice]) -> JointTerms:
    """Constraint terms of joints between rigid bodies: without columns for deformation.

    parts : slice of each body's velocities; the first six are those of its frame
    """
    jacobian = np.zeros_like(terms.jacobian)
    for part in parts:
        frame = slice(part.start, part.start + 6)
        jacobian[:, frame] = terms.jacobian[:, frame]
    return terms._replace(jacobian=jacobian)


class _ConstrainedMachine(CompiledMachine):
    """Machine whose redundant constraints are found for rigid bodies; deformable bodies have fewer."""

    def joint_terms(self, time: float, configuration: Configuration, velocity: np.ndarray) -> JointTerms:
        """Constraint terms of bodies that keep their shape."""
        return of_frames(super().joint_terms(time, configuration, velocity), self.joint_slices)


def check_held(system: System, run: Run) -> None:
    """Raise ModelError for controllers and bodies that a kinematic run does not support.

    Warns about bodies with coordinates, which are treated as rigid; ValidityError if strict.
    """
    if system.controllers:
        raise ModelError(
            "the machine has controllers, but in a kinematic run the joints alone prescribe the motion: "
            "integrate it, or leave out the controllers"
        )
    for placed in system.bodies:
        if placed.body.kind not in _KINDS:
            raise ModelError(
                f"body '{placed.body.name}' is {placed.body.kind}, but a kinematic run moves bodies without "
                "deformation: place a RigidBody, or a reduced, full or intrinsic body, which then keeps its "
                "placed shape"
            )
        if placed.body.n_coordinates:
            message = (
                f"body '{placed.body.name}' is treated as rigid in its placed shape: a kinematic run "
                "computes the forces on a rigid body of its mass, and its stress and section forces are "
                "those of this shape, without the forces of the motion. For these and its deformation, "
                "integrate"
            )
            warn_or_raise(message, ValidityWarning, run.validity)


def check_determined(system: System, active: Sequence[int]) -> None:
    """Raise ModelError where the joints leave a degree of freedom."""
    free = 6 * len(system.bodies) - len(active)
    if free:
        raise ModelError(
            f"the joints leave {free} degree{'s' * (free > 1)} of freedom, but a kinematic run needs none: "
            "prescribe each one (PrescribedRotation instead of Revolute, PrescribedTranslation "
            "instead of Prismatic), or simulate the machine with an integrator"
        )


def instants_between(begin: float, times: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Instants up to the output times, at most one step apart; and the indices of the output times."""
    intervals = np.diff(times, prepend=begin)
    ends = np.cumsum(np.maximum(np.ceil(intervals / step * (1 - 1e-9)), 1).astype(int))
    every = np.interp(np.arange(1, ends[-1] + 1), [0, *ends], [begin, *times])
    return every, ends - 1


def not_closed(time: float) -> str:
    """Message for a run that ends because the joints cannot be closed."""
    return (
        f"the joints cannot be closed at t = {time:.6g}: the machine is at a dead point, or its laws "
        "prescribe positions that its bodies cannot reach. Prescribe a motion that determines the machine at "
        "all times; if the machine moves far in one step, take a shorter step"
    )


class KinematicEngine:
    """`Engine` that solves the joints' equations for the frames of the bodies at each instant."""

    least_leg = 1

    def __init__(self, system: System, run: Run) -> None:
        check_held(system, run)
        self._system, self._run = system, run
        self._step = run.step_control.largest
        self._model: Model | None = None

    def start(self, time: float) -> Instant:
        """Initial instant with closed joints; ModelError where they leave a degree of freedom."""
        start = consistent_start(_ConstrainedMachine(self._system, build_model(self._system)), time)
        report_start(start.change, self._run.validity)
        model = start.machine.model
        check_determined(self._system, model.active)
        self._model = jax.device_put(model)
        still = np.zeros_like(start.velocity)
        placed = _instant(time, start.configuration, still, still, np.zeros(len(model.active)))
        _, rows = _march_instants(self._model, placed, np.full(_INSTANTS_AT_ONCE, float(time)))
        if rows.failed[0]:
            raise ModelError(not_closed(time))
        return jax.tree.map(lambda leaf: np.asarray(leaf)[0], rows)

    def resumed(self, last: Solution) -> Instant:
        """The state at the end of a recorded part."""
        active = tuple(int(index) for index in last.engine_state["active"])
        instant = last_instant(self._system, last)
        self._model = jax.device_put(build_model(self._system, active))
        return _instant(
            instant.time,
            instant.configuration,
            instant.velocity,
            instant.acceleration,
            instant.multipliers[list(active)],
        )

    def march(self, state: Instant, times: np.ndarray) -> Leg[Instant]:
        """Solve at each of the output times, with intermediate instants at most one step apart."""
        began = clock.perf_counter()
        every, outputs = instants_between(float(state.time), times, self._step)
        calls = np.pad(every, (0, -len(every) % _INSTANTS_AT_ONCE), mode="edge").reshape(
            -1, _INSTANTS_AT_ONCE
        )
        program = _march_instants.compiled(self._model, state, calls[0])
        ready = clock.perf_counter()
        last, parts = state, []
        for own in calls:
            last, rows = program(self._model, last, own)
            parts.append(jax.device_get(rows))
            if parts[-1].failed[-1]:
                break
        states = jax.tree.map(lambda *own: np.concatenate(own), *parts)
        n_instants = int(np.sum(~states.failed[: len(every)]))
        outputs = outputs[outputs < n_instants]
        after = jax.device_get(last)
        return Leg(
            states=jax.tree.map(lambda leaf: leaf[outputs], states),
            n_reached=len(outputs),
            last=after,
            statistics=Statistics(
                steps=n_instants,
                iterations=int(after.iterations - state.iterations),
                seconds=clock.perf_counter() - ready,
                compile_seconds=ready - began,
                largest_turn=float(after.largest_turn),
            ),
            stopped=not_closed(float(every[n_instants])) if after.failed else None,
        )

    def solution(self, leg: Leg[Instant]) -> Solution:
        """The motion of a leg."""
        assert self._model is not None
        states = jax.tree.map(np.asarray, leg.states)
        model = self._model
        motion = SystemMotion(
            states.time, states.configuration, states.velocity, states.acceleration, states.multipliers
        )
        active = {"active": np.array(model.active, dtype=float)}
        return floating_solution(
            self._system, model.slices, model.active, motion, leg.statistics, engine_state=active
        )


def _instant(
    time: float,
    configuration: Configuration,
    velocity: AnyArray,
    acceleration: AnyArray,
    multipliers: AnyArray,
) -> Instant:
    count = np.zeros((), dtype=int)
    placed = Configuration(*map(np.asarray, configuration))
    return Instant(
        time=np.asarray(float(time)),
        configuration=placed,
        velocity=np.asarray(velocity),
        acceleration=np.asarray(acceleration),
        multipliers=np.asarray(multipliers),
        iterations=count,
        largest_turn=np.zeros(()),
        failed=np.zeros((), dtype=bool),
    )


def _next_instant(model: Model, before: Instant, time: jax.Array) -> Instant:
    """The machine at a new time, from its state at the previous instant."""
    frames = np.concatenate([np.arange(part.start, part.start + 6) for part in model.slices])
    n = model.n_velocities

    def of_frames(values: jax.Array) -> jax.Array:
        return jnp.zeros(n).at[frames].set(values)

    h = time - before.time
    foreseen = h * before.velocity + h**2 / 2 * before.acceleration
    configuration, gap, iterations = _closed(
        model, time, advance(model, before.configuration, foreseen), frames
    )
    at_rest = joint_terms(model, time, configuration, jnp.zeros(n))
    jacobian = at_rest.jacobian[:, frames]
    velocity = of_frames(jnp.linalg.solve(jacobian, -at_rest.rate))
    bias = joint_terms(model, time, configuration, velocity).acceleration_bias
    acceleration = of_frames(jnp.linalg.solve(jacobian, -bias))

    def carried(multipliers: jax.Array) -> jax.Array:
        terms = balance(model, SystemMotion(time, configuration, velocity, acceleration, multipliers))
        return jnp.linalg.solve(jacobian.T, -(terms.residual - terms.joint)[frames])

    multipliers, last_change = carried(jnp.zeros(len(model.active))), jnp.zeros(())
    if model.reads_reactions:
        multipliers, last = jax.lax.fori_loop(
            0, _REACTIONS, lambda _, at: (carried(at[0]), at[0]), (multipliers, multipliers)
        )
        last_change = jnp.linalg.norm(multipliers - last) / (jnp.linalg.norm(multipliers) + 1e-300)
    scale = jnp.tile(jnp.array([1.0, 1.0, 1.0, model.length, model.length, model.length]), len(model.sizes))
    sizes = jnp.linalg.svd(jacobian / scale, compute_uv=False)
    rounding = model.length * position_rounding(model.length, configuration.origins)
    good = (gap <= rounding) & (sizes[-1] > DEAD_POINT * sizes[0]) & jnp.all(jnp.isfinite(acceleration))
    good = good & (last_change <= _CONVERGED)
    turned = jnp.einsum("bji,bjk->bik", before.configuration.rotations, configuration.rotations)
    cosine = jnp.clip((jnp.trace(turned, axis1=1, axis2=2) - 1) / 2, -1.0, 1.0)
    after = Instant(
        time=time,
        configuration=configuration,
        velocity=velocity,
        acceleration=acceleration,
        multipliers=multipliers,
        iterations=before.iterations + iterations,
        largest_turn=jnp.maximum(before.largest_turn, jnp.max(jnp.arccos(cosine))),
        failed=jnp.zeros((), dtype=bool),
    )
    stay = before._replace(failed=jnp.ones((), dtype=bool))
    return jax.tree.map(lambda a, b: jnp.where(good & ~before.failed, a, b), after, stay)


def _closed(
    model: Model, time: jax.Array, guess: Configuration, frames: np.ndarray
) -> tuple[Configuration, jax.Array, jax.Array]:
    """Newton's method on `g(q, t) = 0` to rounding error: configuration, residual, number of iterations."""

    def gap_of(configuration: Configuration) -> jax.Array:
        return jnp.max(jnp.abs(model.as_lengths(constraints(model, time, configuration))), initial=0.0)

    def unfinished(at: tuple[Configuration, jax.Array, jax.Array, jax.Array]) -> jax.Array:
        configuration, gap, before, iterations = at
        closed = at_rounding(model.length, configuration.origins, gap, before)
        return ~closed & jnp.isfinite(gap) & (iterations < MOST_ITERATIONS)

    def corrected(
        at: tuple[Configuration, jax.Array, jax.Array, jax.Array],
    ) -> tuple[Configuration, jax.Array, jax.Array, jax.Array]:
        configuration, gap, _, iterations = at
        jacobian = constraint_jacobian(model, time, configuration)[:, frames]
        change = jnp.linalg.solve(jacobian, -constraints(model, time, configuration))
        moved = advance(model, configuration, jnp.zeros(model.n_velocities).at[frames].set(change))
        return moved, gap_of(moved), gap, iterations + 1

    start = guess, gap_of(guess), jnp.asarray(jnp.inf), jnp.asarray(0)
    configuration, gap, _, iterations = jax.lax.while_loop(unfinished, corrected, start)
    return configuration, gap, iterations


def _instants(model: Model, start: Instant, times: jax.Array) -> tuple[Instant, Instant]:
    """All instants in sequence: the last one, and all of them stacked."""

    def one(before: Instant, time: jax.Array) -> tuple[Instant, Instant]:
        after = _next_instant(model, before, time)
        return after, after

    return jax.lax.scan(one, jax.tree.map(jnp.asarray, start), times)


_march_instants = CachedProgram(_instants, STARTING)
