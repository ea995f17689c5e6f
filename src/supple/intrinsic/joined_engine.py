"""The engine of machines in which joints connect intrinsic bodies with each other and with others."""

from __future__ import annotations

import time as clock
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.kept_programs import KeptProgram
from supple.errors import ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Leg, Run, Solution, Statistics, leg_size
from supple.intrinsic.chosen_step import with_chosen_step
from supple.intrinsic.full_leg import full_leg
from supple.intrinsic.implicit_step import FirstOrderCoefficients, first_order_coefficients
from supple.intrinsic.joined_equations import Instant, Motion, all_velocities
from supple.intrinsic.joined_machine import JoinedArrays, JoinedMachine, joined_machine
from supple.intrinsic.joined_solution import joined_solution
from supple.intrinsic.joined_start import instant_rates, joined_start
from supple.intrinsic.joined_step import JoinedState, joined_step
from supple.machine import System
from supple.multibody.checks.start import report_start
from supple.multibody.equations.compiler_options import STARTING

__all__ = ["ITERATED", "JoinedEngine"]

ITERATED = 1e-4
"""Of the run's tolerance: to what implicit steps are solved, so that the energy shows the rule alone."""


class JoinedEngine:
    """An `Engine` of intrinsic, rigid and reduced bodies and their joints; `JoinedState` is its state."""

    def __init__(self, system: System, run: Run) -> None:
        run = with_chosen_step(system, run)
        if not isinstance(run.method, GeneralizedAlpha):
            raise ModelError(
                f"joints that connect intrinsic bodies do not take {type(run.method).__name__}: give "
                "GeneralizedAlpha(rho_inf); explicit rules step bodies whose roots the ground holds"
            )
        if not isinstance(run.step_control, FixedStep):
            raise ModelError(
                "intrinsic bodies are stepped with FixedStep(size): an adaptive step is not for them"
            )
        self._run = run
        self._machine: JoinedMachine = joined_machine(system, run.start)
        self._arrays = self._machine.arrays
        self._coefficients = first_order_coefficients(run.method.rho_inf)
        step = float(run.times[1] - run.times[0])
        self._n_steps = max(1, int(np.ceil(step / run.step_control.size * (1 - 1e-9))))
        self._length = leg_size(len(run.times))

    def start(self, time: float) -> JoinedState:
        """Velocities on the joints, consistent rates and joint forces."""
        self._arrays, begun, change = joined_start(self._machine, time)
        report_start(change, self._run.validity)
        # Of NumPy's types as all later instants: JAX would compile once more for numbers of Python's.
        now = jax.tree.map(np.asarray, begun)
        _, rates, multipliers = self._outputs(jax.tree.map(lambda leaf: leaf[None], now))
        first, forces = jax.tree.map(lambda leaf: leaf[0], (rates, multipliers))
        return JoinedState(now, first, forces, jnp.zeros(()), jnp.zeros((), dtype=int))

    def resumed(self, last: Solution) -> JoinedState:
        """The state at the end of a recorded part, exact."""
        leaves, structure = jax.tree.flatten(self.start(self._run.start))
        known = [last.engine_state[f"leaf {number}"] for number in range(len(leaves))]
        return structure.unflatten(
            [
                jnp.asarray(own, dtype=leaf.dtype).reshape(leaf.shape)
                for own, leaf in zip(known, leaves, strict=True)
            ]
        )

    def march(self, state: JoinedState, times: np.ndarray) -> Leg[JoinedState]:
        """To each of the output times, in one call of the compiled program."""
        began = clock.perf_counter()
        # A short leg repeats its end, where steps have no length.
        tolerances = self._run.tolerances
        reached = _march(
            self._arrays,
            state,
            full_leg(times, self._length),
            self._coefficients,
            ITERATED * tolerances.residual,
            self._n_steps,
            tolerances.max_iterations,
        )
        reached = jax.device_get(reached)
        good = self._good(reached)[: len(times)]
        n_reached = len(times) if good.all() else int(np.argmin(good))
        moving = int(np.count_nonzero(np.diff(times, prepend=float(state.now.time))))
        last = jax.tree.map(lambda leaf: jnp.asarray(leaf[max(n_reached, 1) - 1]), reached)
        return Leg(
            states=jax.tree.map(lambda leaf: leaf[:n_reached], reached),
            n_reached=n_reached,
            last=last,
            statistics=Statistics(
                steps=moving * self._n_steps,
                iterations=int(last.iterations - state.iterations),
                seconds=clock.perf_counter() - began,
            ),
            stopped=None if good.all() else self._why(reached, n_reached),
        )

    def _good(self, reached: JoinedState) -> np.ndarray:
        sizes = [np.abs(leaf).reshape(len(leaf), -1).sum(axis=1) for leaf in jax.tree.leaves(reached.now)]
        return np.isfinite(np.sum(sizes, axis=0)) & (reached.worst <= 10 * self._run.tolerances.residual)

    def _why(self, reached: JoinedState, number: int) -> str:
        return (
            f"a step did not converge before t = {float(reached.now.time[number]):.6g}: relative residual "
            f"{float(reached.worst[number]):.2g}. Take shorter steps than {self._run.step_control.first:g}, "
            "allow more iterations (Tolerances), or look for a singular position of the joints"
        )

    def _outputs(self, now: Instant) -> tuple[Any, Motion, Any]:
        """Velocities of the model's bodies, rates and multipliers at instants."""
        n = len(now.time)
        return jax.tree.map(lambda leaf: leaf[:n], _outputs(self._arrays, full_leg(now, self._length)))

    def solution(self, leg: Leg[JoinedState]) -> Solution:
        """The motion of a leg; forces of joints and accelerations are those of its very instants."""
        now: Instant = leg.states.now
        velocities, rates, multipliers = jax.device_get(self._outputs(now))
        state = {
            f"leaf {number}": np.asarray(leaf, dtype=float)
            for number, leaf in enumerate(jax.tree.leaves(leg.last))
        }
        machine = self._machine._replace(arrays=self._arrays)
        return joined_solution(machine, now, velocities, rates, multipliers, leg.statistics, state)


def _march_joined(
    arrays: JoinedArrays,
    start: JoinedState,
    times: jax.Array,
    coefficients: FirstOrderCoefficients,
    tolerance: Any,
    n_steps: Any,
    most: Any,
) -> JoinedState:
    def to_output(state: JoinedState, end: jax.Array) -> tuple[JoinedState, JoinedState]:
        h = (end - state.now.time) / n_steps

        last = jax.lax.fori_loop(
            0, n_steps, lambda _, now: joined_step(arrays, coefficients, tolerance, most, now, h), state
        )
        last = last._replace(now=last.now._replace(time=end))
        return last, last

    return jax.lax.scan(to_output, start, times)[1]


def _rates_at(arrays: JoinedArrays, states: Instant) -> tuple[jax.Array, Motion, jax.Array]:
    return jax.vmap(lambda now: (all_velocities(arrays, now), *instant_rates(arrays, now)))(states)


_march = KeptProgram(_march_joined, STARTING)
_outputs = KeptProgram(_rates_at, STARTING)
