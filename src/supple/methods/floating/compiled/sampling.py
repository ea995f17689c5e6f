"""Sampled controllers in a compiled run: the jump of the accelerations when they are called."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from supple.equations.compiled_machine import CompiledMachine, accelerations
from supple.equations.configuration import SystemMotion
from supple.equations.sampling import ControllerSampling
from supple.methods.floating.compiled.state import State

__all__ = ["sampled_control"]


def sampled_control(sampling: ControllerSampling, model: Any, state: State) -> State:
    """The state after calling the controllers that are due, with the accelerations for their new outputs."""
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
