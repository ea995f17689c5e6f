"""Sampled controllers in a compiled march: it stops at their instants, and goes on with what they give."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np

from supple.equations.compiled_machine import CompiledMachine, accelerations
from supple.equations.configuration import SystemMotion
from supple.equations.sampling import Sampling
from supple.integrate import Leg, Statistics
from supple.methods.floating.compiled.state import State

__all__ = ["march_sampled"]


def march_sampled(
    sampling: Sampling,
    marched: Callable[[State, np.ndarray], Leg[State]],
    model: Any,
    state: State,
    times: np.ndarray,
) -> Leg[State]:
    """To each of the output times by a march between instants."""
    now = float(state.time)
    if times[-1] <= now:
        return marched(state, times)
    every = sampling.every
    legs: list[Leg[State]] = []
    while now < times[-1]:
        state = _sampled(sampling, model, state)
        later = every[(every > now) & (every < times[-1])]
        end = float(later[0]) if later.size else float(times[-1])
        outputs = times[(times > now) & (times <= end)]
        leg = marched(state, np.unique(np.append(outputs, end)))
        if end not in times:  # an instant alone is no output
            kept = min(leg.n_reached, len(outputs))
            rows = jax.tree.map(lambda leaf, kept=kept: leaf[:kept], leg.states)
            leg = Leg(rows, kept, leg.last, leg.statistics, leg.stopped)
        legs.append(leg)
        state, now = leg.last, end
        if leg.stopped is not None:
            break
    parts = [leg.states for leg in legs]
    return Leg(
        states=jax.tree.map(lambda *own: np.concatenate(own), *parts),
        n_reached=sum(leg.n_reached for leg in legs),
        last=legs[-1].last,
        statistics=sum((leg.statistics for leg in legs), Statistics()),
        stopped=legs[-1].stopped,
    )


def _sampled(sampling: Sampling, model: Any, state: State) -> State:
    """After calling the controllers that are due, with accelerations that belong to their outputs."""
    if state.control is None:
        return state
    velocity, configuration = np.asarray(state.velocity), jax.tree.map(np.asarray, state.configuration)
    instant = SystemMotion(np.asarray(float(state.time)), configuration, velocity, velocity, np.zeros(0))
    control = sampling.called(model, instant, state.control)
    if control is None:
        return state
    machine = CompiledMachine(sampling.system, model)
    acceleration, multipliers = accelerations(machine, instant, control)
    return state._replace(
        acceleration=acceleration, auxiliary=acceleration, multipliers=multipliers, control=control
    )
