"""Every step of a compiled run, not only those that end at output times."""

from __future__ import annotations

import warnings
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.equations.machine_model import Model
from supple.equations.stops import Stops, padded_stops, stepping_instants
from supple.errors import RedundantConstraintWarning, StartWarning
from supple.integrate import Run, Solution, Statistics
from supple.machine import System
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.engine import as_solution, controls, initial_state
from supple.methods.floating.compiled.padded_motion import in_own_coordinates, with_padding_coordinates
from supple.methods.floating.compiled.programs import ends_before_compiling, program_pair
from supple.methods.floating.compiled.state import Controls, State
from supple.methods.floating.compiled.time_step import substep

_STEPS_AT_ONCE = 128
"""Number of steps of a call of the compiled program."""
_FEWEST_STOPS = 128
"""Least number of stops of a call; fewer are padded, so that short runs share a program."""


class EveryStep(NamedTuple):
    """The motion of a run at the initial time and at the end of each step."""

    solution: Solution
    outputs: np.ndarray
    """(k,) indices of the output times among the times of the solution"""


def as_outputs(solution: Solution) -> EveryStep:
    """A run whose steps all end at output times."""
    return EveryStep(solution, np.arange(len(solution.times)))


def every_step(system: System, run: Run, solution: Solution) -> EveryStep:
    """All steps of a finished run: the run itself if it has one step per output, otherwise a second run."""
    if solution.statistics.steps == len(solution.times) - 1:
        return as_outputs(solution)
    with warnings.catch_warnings():  # the first run has issued them
        warnings.simplefilter("ignore", RedundantConstraintWarning)
        warnings.simplefilter("ignore", StartWarning)
        filled = with_padding_coordinates(system)
        model, state = initial_state(filled, run.times[0], run.step_control.first)
    times = solution.times
    stops, _ = Stops(run.times, stepping_instants([system], run)).on_the_way(float(times[0]), times[1:])
    stops = padded_stops(stops, fewest=_FEWEST_STOPS)
    soon = ends_before_compiling(solution.statistics.steps, model.n_velocities)
    program = _march_steps_quickly if soon else _march_steps
    model = jax.device_put(model)
    parts = [jax.tree.map(lambda leaf: np.asarray(leaf)[None], state._replace(kept=None))]
    while state.time < times[-1] and not state.failed:
        state, states = program(model, controls(run), state, stops)
        parts.append(jax.tree.map(np.asarray, states))
    states = jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)
    # After its end or a failure, the integration repeats its last state.
    _, first = np.unique(states.time, return_index=True)
    taken = as_solution(filled, model, jax.tree.map(lambda leaf: leaf[first], states), Statistics())
    taken = in_own_coordinates(system, taken)
    return EveryStep(taken, np.searchsorted(taken.times, times))


def _next_steps(
    elimination: DenseElimination, model: Model, settings: Controls, start: State, stops: jax.Array
) -> tuple[State, State]:
    """The next accepted steps towards some stops (k,): the last state, and all states stacked."""

    def next_step(state: State, _: None) -> tuple[State, State]:
        end = stops[jnp.minimum(jnp.searchsorted(stops, state.time, side="right"), len(stops) - 1)]
        taken = jax.lax.while_loop(
            lambda s: (s.steps == state.steps) & (s.time < end) & ~s.failed,
            partial(substep, elimination, model, settings, end),
            state,
        )
        return taken, taken._replace(kept=None)

    return jax.lax.scan(next_step, start, None, length=_STEPS_AT_ONCE)


_march_steps, _march_steps_quickly = program_pair(_next_steps)
