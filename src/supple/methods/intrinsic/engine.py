"""Engine of intrinsic bodies: time integration of their modes by an explicit, residual or implicit rule."""

from __future__ import annotations

import time as clock

import jax
import jax.numpy as jnp
import numpy as np

from supple.errors import ModelError
from supple.integrate import (
    FixedStep,
    GeneralizedAlpha,
    Leg,
    ResidualRungeKutta4,
    Run,
    Solution,
    Statistics,
    leg_size,
)
from supple.machine import System
from supple.methods.intrinsic.joined_engine import ITERATED, JoinedEngine
from supple.methods.intrinsic.line_march import (
    LineMarchState,
    LineRule,
    Stepping,
    compiled_march,
    first_march_state,
    full_leg,
    n_good,
)
from supple.methods.intrinsic.line_model import LineState
from supple.methods.intrinsic.line_system import LineSystem
from supple.methods.intrinsic.machine_of_lines import MachineOfLines, machine_of_lines
from supple.methods.intrinsic.stable_step import check_stable, with_chosen_step
from supple.methods.intrinsic.supported_root import is_joined

__all__ = ["IntrinsicEngine", "intrinsic_engine"]


def intrinsic_engine(system: System, run: Run) -> IntrinsicEngine | JoinedEngine:
    """`IntrinsicEngine` if joints only support the roots on the ground, otherwise `JoinedEngine`."""
    return JoinedEngine(system, run) if is_joined(system) else IntrinsicEngine(system, run)


_NAMES = ("q1", "q2", "quaternion", "position")
"""Parts of a line's state that a resumed run needs."""


class IntrinsicEngine:
    """`Engine` of intrinsic bodies, free or supported by the ground; its state is `LineMarchState`."""

    least_leg = 1

    def __init__(self, system: System, run: Run) -> None:
        if not isinstance(run.method, LineRule):
            raise ModelError(
                f"intrinsic bodies do not support {type(run.method).__name__}: use RungeKutta4(), "
                "ResidualRungeKutta4(n_kept) or GeneralizedAlpha(rho_inf), which conserves energy with "
                "rho_inf = 1"
            )
        self.rule: LineRule = run.method
        self._run = run = with_chosen_step(system, run)
        if not isinstance(run.step_control, FixedStep):
            raise ModelError(
                "intrinsic bodies with supported roots, or without joints, need FixedStep(size); adaptive "
                "steps are for bodies that joints hold: place released(body) with a joint, such as Fixed"
            )
        self._machine: MachineOfLines = machine_of_lines(system, run.start)
        step = float(run.times[1] - run.times[0])
        self.n_steps = max(1, int(np.ceil(step / run.step_control.size * (1 - 1e-9))))
        check_stable(self._machine, self.rule, step / self.n_steps)
        self._length = leg_size(len(run.times))

    @property
    def lines(self) -> LineSystem:
        """The machine as arrays for compiled code."""
        return self._machine.lines

    @property
    def tolerance(self) -> float:
        """Relative residual at which an implicit step ends."""
        return ITERATED * self._run.tolerances.residual

    def start(self, time: float) -> LineMarchState:
        """The bodies as placed; the modes above `n_kept` follow the lower ones statically."""
        begun = first_march_state(self._machine.lines, self.rule, time, self._machine.start)
        # NumPy types as in all later states: JAX would compile once more for Python numbers.
        return jax.tree.map(np.asarray, begun)

    def resumed(self, last: Solution) -> LineMarchState:
        """The exact state at the end of a recorded part of the run."""
        known = last.engine_state
        states = tuple(
            LineState(*(jnp.asarray(known[f"{number} {name}"]) for name in _NAMES))
            for number in range(len(self._machine.start))
        )
        return LineMarchState(
            jnp.asarray(float(last.times[-1])),
            states,
            jnp.asarray(known["rates"]),
            jnp.asarray(float(known["worst"])),
            jnp.asarray(int(known["iterations"])),
        )

    def march(self, state: LineMarchState, times: np.ndarray) -> Leg[LineMarchState]:
        """Integrate to each of the output times, in one call of the compiled program."""
        began = clock.perf_counter()
        # A short leg repeats its last time, with steps of zero length.
        reached = compiled_march(
            Stepping(self.rule, self.n_steps, self._run.tolerances.max_iterations),
            self.lines,
            state,
            full_leg(times, self._length),
            self.tolerance,
        )
        return self.leg(state, jax.device_get(reached), times, clock.perf_counter() - began)

    def leg(
        self, state: LineMarchState, reached: LineMarchState, times: np.ndarray, seconds: float
    ) -> Leg[LineMarchState]:
        """Leg of the states `reached` (leading axis: time), up to the first not finite or not converged.

        times : output times of the leg; `reached` may have more
        """
        n_reached = min(n_good(reached.states, np.asarray(reached.worst) <= self._limit()), len(times))
        last = jax.tree.map(lambda leaf: np.asarray(leaf[max(n_reached, 1) - 1]), reached)
        moving = int(np.count_nonzero(np.diff(times, prepend=float(state.time))))
        iterations = int(last.iterations - state.iterations)
        return Leg(
            states=jax.tree.map(lambda leaf: leaf[:n_reached], reached),
            n_reached=n_reached,
            last=last,
            statistics=Statistics(steps=moving * self.n_steps, iterations=iterations, seconds=seconds),
            stopped=None if n_reached == len(times) else self._why(reached, n_reached),
        )

    def _limit(self) -> float:
        match self.rule:
            case ResidualRungeKutta4():
                return self.rule.largest_contraction
            case GeneralizedAlpha():
                return 10 * self._run.tolerances.residual
            case _:
                return np.inf

    def _why(self, reached: LineMarchState, number: int) -> str:
        when = f"before t = {float(reached.time[number]):.6g}"
        worst = float(reached.worst[number])
        match self.rule:
            case ResidualRungeKutta4(n_kept=n):
                return (
                    f"the residual modes did not converge {when}: contraction {worst:.3g} per sweep "
                    f"(at most {self.rule.largest_contraction:g}). Keep more modes than {n} (n_kept)"
                )
            case GeneralizedAlpha():
                return (
                    f"a step did not converge {when}: relative residual {worst:.2g}. Take shorter steps than "
                    f"{self._run.step_control.first:g}, or allow more iterations (Tolerances)"
                )
            case _:
                return (
                    f"the motion is not finite {when}: take shorter steps than "
                    f"{self._run.step_control.first:g} (large strains raise the frequencies), or use "
                    "GeneralizedAlpha, which is stable at any step"
                )

    def solution(self, leg: Leg[LineMarchState]) -> Solution:
        """The motion of a leg, and joint forces from the balance of the bodies."""
        states: LineMarchState = leg.states
        last = leg.last
        kept = {
            f"{number} {name}": np.asarray(getattr(state, name))
            for number, state in enumerate(last.states)
            for name in _NAMES
        }
        kept |= {
            "rates": np.asarray(last.rates),
            "worst": np.asarray(float(last.worst)),
            "iterations": np.asarray(float(last.iterations)),
        }
        return self._machine.solution(
            np.asarray(states.time), states.states, leg.statistics, length=self._length, engine_state=kept
        )
