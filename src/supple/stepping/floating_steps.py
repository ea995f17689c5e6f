"""Time steps of machines of rigid and reduced bodies, by their compiled time integration."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import numpy as np

from supple.arrays import AnyArray
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model
from supple.integrate import Run
from supple.machine import System
from supple.methods.floating.compiled.differentiable_march import marched_to
from supple.methods.floating.compiled.engine import controls, initial_state, system_motion
from supple.methods.floating.compiled.state import Controls, State


@dataclass(frozen=True, eq=False)
class FloatingSteps:
    """Time integration of rigid and reduced bodies; its `arrays` are the `Model` of the machine."""

    controls: Controls
    size: float
    n_velocities: int

    def reached(self, arrays: Model, state: State, end: AnyArray) -> State:
        """The state at the time `end`; its forward-mode derivatives are those of the time-discrete motion."""
        return marched_to(self.controls, arrays, state, end)

    def motion(self, _arrays: Model, state: State) -> SystemMotion:
        """The motion of a state."""
        return system_motion(state)

    def model(self, arrays: Model) -> Model:
        """The model: `arrays` itself."""
        return arrays


def floating_steps(system: System, run: Run) -> tuple[FloatingSteps, Model, State]:
    """The time steps of a machine, its arrays, and the consistent initial state of its run."""
    model, state = initial_state(system, run.start, run.step_control.first, run.validity)
    steps = FloatingSteps(controls(run), float(run.step_control.first), model.n_velocities)
    return steps, model, jax.tree.map(np.asarray, state)
