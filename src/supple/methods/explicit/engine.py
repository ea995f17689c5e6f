"""Engine of explicit time integration."""

from __future__ import annotations

import time as clock

import jax
import jax.numpy as jnp
import numpy as np

from supple.algebra.jax_settings import before_compiled_code
from supple.equations.checks.start_report import report_start
from supple.equations.control_series import series_name
from supple.equations.floating_solution import joint_multipliers
from supple.equations.joint_wrench import joint_wrenches
from supple.equations.sampling import march_sampled, sampling_of
from supple.errors import ModelError
from supple.integrate import FixedStep, Leg, Motion, Run, Solution, Statistics
from supple.machine import System
from supple.methods.explicit.check_machine import check_explicit_run, check_machine
from supple.methods.explicit.frame_chart import floating_motion
from supple.methods.explicit.march.build import Built, built
from supple.methods.explicit.march.frame_forces import frame_states
from supple.methods.explicit.march.interval import (
    Recorded,
    chosen_steps,
    frame_limits,
    march_to,
    nodes_limit,
    recorded,
)
from supple.methods.explicit.march.march_model import Energies, MarchState
from supple.methods.explicit.march.march_step import begun
from supple.methods.explicit.method import explicit_method
from supple.methods.explicit.motions import NodalMotion

__all__ = ["CONTACTS", "ENERGIES", "OBSTACLES", "STEPS", "ExplicitEngine"]

ENERGIES = "energies"
"""Name of the series of energies, J, in the order of `Energies`."""
STEPS = "steps"
"""Name of the series with the element step, s, and the number of element steps in one frame step."""
OBSTACLES = "obstacles"
"""Name of the series with displacement and velocity of each obstacle, (t, 6 o)."""
CONTACTS = "contacts"
"""Name of the series with the force on the nodes of each contact, then the point of this force, (t, 6 c)."""


class ExplicitEngine:
    """`Engine` for explicit time integration; `MarchState` is its state."""

    least_leg = 1

    def __init__(self, system: System, run: Run) -> None:
        before_compiled_code()
        check_explicit_run(run)
        method = explicit_method(run)
        check_machine(system, method)
        self._fixed = _fixed_step(run)
        self._run, self._system = run, system
        self._sampling = sampling_of(system, run)
        self._built = built(system, method, float(run.times[0]))
        self._check_step()

    @property
    def built(self) -> Built:
        """The system prepared for time integration, as arrays."""
        return self._built

    def steps(self) -> tuple[float, int]:
        """Element step at the start, s, and number of element steps in one frame step."""
        own, span = self._built, jnp.asarray(self._run.output_step)
        h, ratio, _ = chosen_steps(own.model, own.methods, own.start, jnp.asarray(self._fixed or 0.0), span)
        return float(h), int(ratio)

    def start(self, time: float) -> MarchState:
        """State of the parts as placed, corrected to satisfy the joints."""
        prepared = self._built
        if prepared.framed.change is not None:
            report_start(prepared.framed.change, self._run.validity)
        return begun(prepared.model, prepared.start._replace(time=jnp.asarray(time)))

    def resumed(self, last: Solution) -> MarchState:
        """State at the end of a recorded run, exact to the last bit; ModelError for another system."""
        start = self._built.start
        leaves, structure = jax.tree.flatten(start)
        stored = last.engine_state
        if sum(name.startswith("state ") for name in stored) != len(leaves):
            raise ModelError(
                "the recorded run belongs to another engine or another system: resume it with the system of "
                "its recording"
            )
        leaves_at_end = [
            jnp.asarray(np.asarray(stored[f"state {number}"]), dtype=leaf.dtype).reshape(leaf.shape)
            for number, leaf in enumerate(leaves)
        ]
        return jax.tree.unflatten(structure, leaves_at_end)

    def march(self, state: MarchState, times: np.ndarray) -> Leg[MarchState]:
        """Integrate to each of the output times; sampled controllers are called at their sample times."""
        return march_sampled(self._sampling, self._marched, self._sampled, state, times)

    def _sampled(self, state: MarchState) -> MarchState:
        """The state after calling the controllers that are due."""
        model = self._built.model
        assert self._sampling is not None
        assert model.machine is not None
        assert state.control is not None
        now = frame_states(model.machine, model.frames, state.frames, state.time)
        control = self._sampling.called(model.machine, now, jax.tree.map(np.asarray, state.control))
        return state if control is None else state._replace(control=jax.tree.map(jnp.asarray, control))

    def _marched(self, state: MarchState, times: np.ndarray) -> Leg[MarchState]:
        """Integrate to each of the output times without interruption."""
        began, machine = clock.perf_counter(), (self._built.model, self._built.methods)
        ahead = times[times > float(state.time)]
        rows: list[Recorded] = []
        if len(ahead) < len(times):
            now = recorded(*machine, state, jnp.asarray(0), jnp.asarray(self._first_step()))
            rows.append(jax.tree.map(lambda leaf: np.asarray(leaf)[None], now))
        before = int(state.steps)
        stopped, last = None, state
        if len(ahead):
            ends = jnp.asarray(np.pad(ahead, (0, _padded(len(ahead)) - len(ahead)), mode="edge"))
            last, after = march_to(*machine, state, jnp.asarray(self._fixed or 0.0), ends)
            after = jax.tree.map(lambda leaf: leaf[: len(ahead)], jax.device_get(after))
            bad = np.flatnonzero(after.trouble)
            if bad.size:
                stopped = self._failure(jax.tree.map(lambda leaf: leaf[bad[0]], after), float(last.initial))
                after = jax.tree.map(lambda leaf: leaf[: bad[0]], after)
            rows.append(after)
        joined = jax.tree.map(lambda *leaves: np.concatenate(leaves), *rows)
        statistics = Statistics(steps=int(last.steps) - before, seconds=clock.perf_counter() - began)
        return Leg(joined, len(joined.time), last, statistics, stopped)

    def solution(self, leg: Leg[MarchState]) -> Solution:
        """The motion of each part, and the series of energies, steps, obstacles, contacts and controllers."""
        rows: Recorded = leg.states
        prepared = self._built
        bodies: dict[str, Motion] = {}
        moved = [np.asarray(each).swapaxes(1, 2) for each in (rows.x, rows.v, rows.a)]
        for name, span in prepared.blocks.items():
            x, v, a = (each[:, prepared.nodes[name]] for each in moved)
            worst = (rows.plastic[span], rows.alive[span], rows.von_mises[span])
            plastic, alive, stress = (np.concatenate(each, axis=1) for each in worst)
            bodies[name] = NodalMotion(x, v, a, plastic, alive, stress)
        for (name, frame), marched in zip(prepared.frames.items(), rows.frames, strict=True):
            bodies[name] = floating_motion(frame, tuple(np.asarray(leaf) for leaf in marched))
        series = {ENERGIES: np.asarray(rows.energies), STEPS: np.column_stack([rows.step, rows.ratio])}
        if rows.obstacles:
            series[OBSTACLES] = np.concatenate([part for pair in rows.obstacles for part in pair], axis=1)
        if self._system.contacts:
            series[CONTACTS] = np.asarray(rows.contacts).reshape(len(rows.time), -1)
        if rows.controls:
            assert prepared.model.machine is not None
            names = [series_name(law.name) for law in prepared.model.machine.controllers]
            series |= dict(zip(names, map(np.asarray, rows.controls), strict=True))
        leaves = jax.tree.leaves(leg.last)
        kept = {f"state {number}": np.asarray(leaf, dtype=float) for number, leaf in enumerate(leaves)}
        times, forces, multipliers = np.asarray(rows.time), {}, {}
        if prepared.framed.machine is not None and prepared.framed.machine.joints:
            assert prepared.model.machine is not None
            active = prepared.model.machine.active
            # Joint forces are J^T mu here, -G^T lambda in the other engines.
            multipliers = joint_multipliers(prepared.framed.machine, active, -np.asarray(rows.pulls))
            forces = joint_wrenches(prepared.framed.machine, times, bodies, multipliers)
            kept["active"] = np.array(active, dtype=float)
        return Solution(
            times=times,
            bodies={placed.body.name: bodies[placed.body.name] for placed in self._system.bodies},
            joint_forces=forces,
            multipliers=multipliers,
            statistics=leg.statistics,
            series=series,
            engine_state=kept,
        )

    def _first_step(self) -> float:
        """Trial step at the start, s: 0.01 times the shortest of output step, fixed step and frame limits."""
        limits = [float(each.step_limit) for each in self._built.model.frames]
        return 0.01 * min([self._run.output_step, self._fixed or np.inf, *limits])

    def _check_step(self) -> None:
        step, prepared = self._fixed, self._built
        if prepared.model.blocks:
            limit = float(nodes_limit(prepared.model, prepared.start, 1.0))
        else:
            limit = min(float(each) for each in frame_limits(prepared.model, prepared.start))
        if step is None:
            if np.isinf(limit):
                raise ModelError(
                    "rigid bodies without springs are stable at any explicit step, so no default step can be "
                    "computed (a servo that is at its limit at the start is no spring): give "
                    "Run(step=FixedStep(size)), about a hundredth of the period of a revolution or a swing"
                )
            return
        if step > limit:
            raise ModelError(
                f"the step {step:g} s is above the stability limit of {limit:.4g} s; "
                f"leave it out, or give at most {0.9 * limit:.3g}"
            )

    def _failure(self, row: Recorded, initial: float) -> str:
        """Message with the cause of a stopped run and its remedies."""
        when = f"t = {float(row.time):.6g}, step {int(row.steps)}"
        e = dict(zip(Energies._fields, np.asarray(row.energies), strict=True))
        shorter = "a smaller safety" if self._fixed is None else "a shorter FixedStep"
        match int(row.trouble):
            case 1:
                return (
                    f"an element inverted (det F <= 0) before {when}: refine the mesh there, delete "
                    "elements above a limit of plastic strain, or use a law that resists inversion "
                    "(NeoHookean)"
                )
            case 2:
                return (
                    f"the motion is not finite at {when}: the step is too long for the "
                    f"deformed mesh; take {shorter}"
                )
            case 3:
                drift = sum(e.values()) - 2 * e["external"] - initial
                worst = max((name for name in e if name != "external"), key=lambda name: abs(e[name]))
                return (
                    f"the energy balance has an error of {drift:.3g} at {when}, more than 1 %; the "
                    f"largest term is {worst} ({e[worst]:.3g}), and {e['interface']:.3g} was lost at the "
                    "interface: take shorter steps, or a smaller largest_ratio"
                )
            case 5:
                where, remedy = (
                    ("between parts with different steps", "a smaller largest_ratio")
                    if row.ratio > 1
                    else ("by parts that rotate too far in a step", f"a FixedStep below {row.step:.3g}")
                )
                verb = "lost" if e["interface"] > 0 else "gained"
                return (
                    f"the interface energy drifts by more than 1 %: up to {when}, {abs(e['interface']):.3g} "
                    f"was {verb} {where}; take {remedy}"
                )
            case _:
                worst = min(("internal", "hourglass", "contact"), key=lambda name: e[name])
                why = (
                    "the contact opens within a step; take a smaller fraction or stiffness of the contact, or"
                    if worst == "contact"
                    else "the step is above the stability limit; take"
                )
                return (
                    f"the {worst} energy is negative ({e[worst]:.3g}) at {when}: spurious energy, because "
                    f"{why} {shorter}"
                )


def _padded(n: int) -> int:
    """Number of output times, rounded up to one of a few lengths, so that runs share a compiled program."""
    return 1 << (n - 1).bit_length() if n <= 32 else -(-n // 32) * 32


def _fixed_step(run: Run) -> float | None:
    """Fixed step of the run, s, or None for the stable step; ModelError for an adaptive step."""
    match run.step:
        case None:
            return None
        case FixedStep(size=size):
            return size
        case _:
            raise ModelError(
                f"explicit steps are limited by stability, not by an error: {type(run.step).__name__} is not "
                "supported; give FixedStep(size), or none"
            )
