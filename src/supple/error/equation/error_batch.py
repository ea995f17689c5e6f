"""The error equation of many runs in the same columns, marched in one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial

import jax
import numpy as np

from supple.arrays import AnyArray
from supple.equations.compiler_options import MARCHING
from supple.error.equation.error_history import ErrorEquation
from supple.error.equation.linearised_march import (
    ElasticGain,
    ErrorState,
    GainHistory,
    StepOfRun,
    march_error,
)
from supple.error.equation.steps_of_run import blocks_of_run, standing
from supple.integrate import Coefficients
from supple.methods.floating.compiled.batch_start import Axes, differing, stacked
from supple.programs.program_cache import CachedProgram

AT_ONCE = 64


def first_together(
    equations: Sequence[ErrorEquation], *, rest: float = 0.0, at_once: int | None = None
) -> list[ErrorState]:
    """`ErrorEquation.first` of runs with equal numbers of steps, whose bodies share one error space.

    The effect of the deformation is computed once, from sample times of all runs together.

    rest : for runs that start in equilibrium: length of a first step, much longer than all vibration periods,
        which moves the true motion to its own equilibrium; 0: runs that start as placed
    at_once : number of runs per call, for which the program is compiled; None: all of them, at most 64
    """
    number = at_once or min(AT_ONCE, len(equations))
    gains, histories = _gains(equations)
    found: list[ErrorState] = []
    for begin in range(0, len(equations), number):
        rows = range(begin, min(begin + number, len(equations)))
        found += _marched(
            [equations[row] for row in rows],
            gains,
            [histories[row] for row in rows],
            number,
            rest,
        )
    return found


def _gains(
    equations: Sequence[ErrorEquation],
) -> tuple[tuple[ElasticGain, ...], list[tuple[GainHistory, ...]]]:
    """Shared matrices of nonlinear bodies, and the weights and damping of every run."""
    names, gains, histories = [], [], []
    for name, assessed in equations[0].bodies.items():
        if assessed.full.body.is_linear:
            continue
        times = [equation.bodies[name].retardation_time for equation in equations]
        damped = equations[int(np.argmax(times))]
        motions = [equation.point.bodies[name] for equation in equations]
        together = motions[0]._replace(
            coordinates=np.concatenate([each.coordinates for each in motions]),
            rates=np.concatenate([each.rates for each in motions]),
        )
        gain, history = damped.gained(name, together)
        ends = np.cumsum([len(each.coordinates) for each in motions])[:-1]
        names.append(name)
        gains.append(gain)
        split = zip(*(np.split(leaf, ends) for leaf in history), strict=True)
        histories.append(
            [
                own._replace(retardation=np.full(len(own.force), time))
                for own, time in zip((GainHistory(*parts) for parts in split), times, strict=True)
            ]
        )
    of_runs: list[tuple[GainHistory, ...]] = [tuple(own) for own in zip(*histories, strict=True)]
    of_runs = of_runs or [()] * len(equations)
    for equation, own in zip(equations, of_runs, strict=True):
        equation.share_gains(dict(zip(names, zip(gains, own, strict=True), strict=True)))
    return tuple(gains), of_runs


def _marched(
    equations: Sequence[ErrorEquation],
    gains: tuple[ElasticGain, ...],
    histories: Sequence[tuple[GainHistory, ...]],
    at_once: int,
    rest: float,
) -> list[ErrorState]:
    """The march of one chunk of runs; a smaller chunk is filled up with its last run."""
    numbers = [*range(len(equations)), *[len(equations) - 1] * (at_once - len(equations))]
    models = [equations[i].model for i in numbers]
    axes = differing(models)
    program = _mapped_march(jax.tree.structure(models[0]), axes)
    leaves = stacked(models, axes)
    coefficients = equations[0].coefficients

    def marched(states: ErrorState, blocks: Sequence[StepOfRun]) -> ErrorState:
        return jax.device_get(
            program(leaves, gains, coefficients, states, _stacked([blocks[i] for i in numbers]))
        )

    points = [equation.point.motion for equation in equations]
    starts = [equation.start_vectors() for equation in equations]
    position, velocity = (np.stack([starts[i][part] for i in numbers]) for part in (0, 1))
    none = np.zeros_like(velocity)
    state = ErrorState(position, velocity, none, none, np.zeros((len(numbers), len(models[0].active))))
    standstill = [standing(*each) for each in zip(points, histories, strict=True)]
    if rest:
        # One step so long that only stiffness resists.
        moved = marched(state, [block._replace(h=np.full_like(block.h, rest)) for block in standstill])
        position = position + moved.position[:, 0]
        state = state._replace(position=position)
    begun = marched(state, standstill)
    acceleration = begun.acceleration[:, 0]
    state = ErrorState(position, velocity, acceleration, acceleration, begun.multipliers[:, 0])
    parts = [jax.tree.map(lambda leaf: leaf[:, None], state)]
    for blocks in zip(*(blocks_of_run(*each) for each in zip(points, histories, strict=True)), strict=True):
        number = blocks[0][1]
        states = marched(state, [block for block, _ in blocks])
        state = jax.tree.map(lambda leaf, last=number - 1: leaf[:, last], states)
        parts.append(jax.tree.map(lambda leaf, n=number: leaf[:, :n], states))
    whole = jax.tree.map(lambda *each: np.concatenate(each, axis=1), *parts)
    return [jax.tree.map(lambda leaf, own=own: leaf[own], whole) for own in range(len(equations))]


def _stacked(trees: Sequence[StepOfRun]) -> StepOfRun:
    return jax.tree.map(lambda *leaves: np.stack(leaves), *trees)


@lru_cache(maxsize=16)
def _mapped_march(model_structure: jax.tree_util.PyTreeDef, axes: Axes) -> CachedProgram:
    """The compiled march over cases, for one pattern of shared and differing arguments."""
    return CachedProgram(partial(_march_over_cases, model_structure, axes), MARCHING)


def _march_over_cases(
    model_structure: jax.tree_util.PyTreeDef,
    axes: Axes,
    leaves: list[AnyArray],
    gains: tuple[ElasticGain, ...],
    coefficients: Coefficients,
    states: ErrorState,
    blocks: StepOfRun,
) -> ErrorState:
    def one_case(own: list[AnyArray], state: ErrorState, block: StepOfRun) -> ErrorState:
        model = jax.tree.unflatten(model_structure, own)
        return march_error(model, gains, coefficients, state, block)[1]

    return jax.vmap(one_case, in_axes=(list(axes), 0, 0))(leaves, states, blocks)
