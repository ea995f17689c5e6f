"""Compiled time integration with derivatives along some directions, advanced with each step.

States are those of the run without derivatives; a rejected step leaves the derivatives unchanged. The
derivatives are those of the discrete motion, with a fixed number of steps between two stops; the step size
varies with the stops.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import jax
import numpy as np

from supple.arrays import AnyArray
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.elimination import DenseElimination
from supple.methods.floating.compiled.programs import STOPS_AT_ONCE, ends_before_compiling, program_pair
from supple.methods.floating.compiled.sensitivity_step import StateChange, step_with_changes
from supple.methods.floating.compiled.state import Controls, State
from supple.methods.floating.compiled.time_step import through_stops


class MarchChanges(NamedTuple):
    """Derivatives of all inputs of a time integration along p directions."""

    model: Sequence[AnyArray | None]
    """For each leaf of the model (p, ..); None for a constant one"""
    start: StateChange
    stops: AnyArray
    """(p, k)"""


class MarchedWithChanges(NamedTuple):
    """Last state of an integration, and states and derivatives at its stops, (k, ..) and (k, p, ..)."""

    last: State
    states: State
    changes: StateChange


def march_with_changes(
    model: Model, controls: Controls, start: State, stops: np.ndarray, changes: MarchChanges, n_steps: float
) -> MarchedWithChanges:
    """Integrate through stops (k,), ascending, up to the first one that is not reached.

    n_steps : approximate number of steps, which selects the program
    """
    calls = np.pad(stops, (0, -len(stops) % STOPS_AT_ONCE), mode="edge").reshape(-1, STOPS_AT_ONCE)
    by_call = np.pad(changes.stops, ((0, 0), (0, calls.size - len(stops))), mode="edge")
    p = len(changes.stops)
    soon = ends_before_compiling((1 + p) * n_steps, model.n_velocities)
    program = _QUICK_MARCH if soon else _MARCH
    model, model_change = jax.device_put((model, list(changes.model)))
    last, change, parts = start, changes.start, []
    for number, own in enumerate(calls):
        along = by_call[:, number * STOPS_AT_ONCE : (number + 1) * STOPS_AT_ONCE]
        last, change, *found = program(model, controls, model_change, last, change, own, along)
        left = len(stops) - number * STOPS_AT_ONCE
        parts.append(jax.tree.map(lambda leaf, left=left: leaf[:left], jax.device_get(found)))
        if np.asarray(last.failed):
            break
    states, found = jax.tree.map(lambda *own: np.concatenate(own), *parts)
    return MarchedWithChanges(jax.device_get(last), states, found)


def _march(
    elimination: DenseElimination,
    model: Model,
    controls: Controls,
    model_change: Sequence[AnyArray | None],
    start: State,
    change: StateChange,
    stops: jax.Array,
    stop_changes: jax.Array,
) -> tuple[State, StateChange, State, StateChange]:
    """`march` with derivatives: last state and its derivatives, then states and derivatives at the stops."""

    def to_stop(row: jax.Array, known: tuple[State, StateChange]) -> tuple[State, StateChange]:
        step = partial(
            step_with_changes, elimination, model, controls, model_change, stops[row], stop_changes[:, row]
        )
        return jax.lax.while_loop(lambda known: (known[0].time < stops[row]) & ~known[0].failed, step, known)

    (last, change), (states, changes) = through_stops(
        (start, change), stops, to_stop, lambda known: (known[0]._replace(kept=None), known[1])
    )
    return last, change, states, changes


_MARCH, _QUICK_MARCH = program_pair(_march)
