"""Time steps of machines with intrinsic bodies that are connected by joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray, Tree
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model
from supple.integrate import Run
from supple.machine import At, System
from supple.methods.intrinsic.joined_engine import JoinedEngine
from supple.methods.intrinsic.joined_equations import all_velocities, station_twists
from supple.methods.intrinsic.joined_machine import JoinedArrays, JoinedMachine
from supple.methods.intrinsic.joined_start import instant_rates
from supple.methods.intrinsic.joined_step import JoinedState, JoinedStepping, joined_step


class SteppedState(NamedTuple):
    """The state of the time integration between two steps."""

    time: AnyArray
    failed: AnyArray
    """Whether the step did not converge, shape (); the state is then that before the step"""
    march: JoinedState


@dataclass(frozen=True, eq=False)
class JoinedSteps:
    """Implicit time integration of intrinsic and floating bodies; the same functions as `FloatingSteps`."""

    stepping: JoinedStepping
    size: float
    n_velocities: int

    def reached(self, arrays: JoinedArrays, state: SteppedState, end: AnyArray) -> SteppedState:
        """The state at the time `end`, or before the first step that does not converge."""
        number = jnp.ceil((end - state.time) / self.size * (1 - 1e-9))
        h = (end - state.time) / jnp.maximum(number, 1.0)

        def goes_on(carry: tuple[AnyArray, SteppedState]) -> AnyArray:
            return (carry[0] < number) & ~carry[1].failed

        def one(carry: tuple[AnyArray, SteppedState]) -> tuple[AnyArray, SteppedState]:
            count, before = carry
            march = joined_step(arrays, self.stepping, before.march, h)
            time = jnp.where(count + 1 < number, before.time + h, end)
            march = march._replace(now=march.now._replace(time=time))
            finite = jnp.stack([jnp.isfinite(leaf).all() for leaf in jax.tree.leaves(march.now)]).all()
            good = finite & (march.worst <= self.stepping.limit)
            kept = jax.tree.map(lambda a, b: jnp.where(good, a, b), march, before.march)
            return count + 1, SteppedState(jnp.where(good, time, before.time), ~good, kept)

        state = jax.tree.map(jnp.asarray, state)
        return jax.lax.while_loop(goes_on, one, (jnp.zeros(()), state))[1]

    def motion(self, arrays: JoinedArrays, state: SteppedState) -> SystemMotion:
        """The motion of a state, with accelerations and joint forces from the equations of motion."""
        march = state.march
        now, lines = march.now, march.now.lines
        rates, multipliers = instant_rates(arrays, now, march.control)

        def twists(states: Tree) -> jax.Array:
            return station_twists(arrays, states, tuple(own.q1 for own in states))

        accelerations = jax.jvp(twists, (lines,), (rates.lines,))[1]
        return SystemMotion(
            state.time,
            now.floating,
            all_velocities(arrays, now),
            jnp.concatenate([rates.acceleration, accelerations]),
            multipliers,
        )

    def model(self, arrays: JoinedArrays) -> Model:
        """The model of floating bodies and stations."""
        return arrays.model


def joined_steps(
    system: System, run: Run, also: Sequence[At]
) -> tuple[JoinedSteps, JoinedMachine, SteppedState]:
    """The time integration of a machine, its `JoinedMachine`, and the consistent initial state of its run.

    also : further stations, which sensors read
    """
    engine = JoinedEngine(system, run, also)
    march = jax.tree.map(np.asarray, engine.start(run.start))
    n = engine.machine.arrays.n_floating + sum(len(line.q1) for line in march.now.lines)
    start = SteppedState(np.asarray(march.now.time, dtype=float), np.zeros((), dtype=bool), march)
    return JoinedSteps(engine.stepping, engine.step, n), engine.machine, start
