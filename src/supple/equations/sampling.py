"""Sampled controllers: their call times in a run, and the check of their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import jax
import numpy as np

from supple.equations.compiler_options import STARTING
from supple.equations.configuration import ControlState, ControlStep, SystemMotion
from supple.equations.control_force import readings_at
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.integrate import Leg, Run, Statistics
from supple.machine import SampledController, System
from supple.machine.control.controller import as_memory
from supple.programs.program_cache import CachedProgram


class _Timed(Protocol):
    """The state of an engine."""

    @property
    def time(self) -> Any:
        """Its time, s."""


S = TypeVar("S", bound=_Timed)

_SAME = 1e-6
"""Times that differ by less than this fraction of the period are equal: a call time so near to an output time
is moved to it."""


@dataclass(frozen=True, eq=False)
class ControllerSampling:
    """Sampled controllers of a machine, and the call times of each.

    A controller is called when the integration continues from a call time, not when it ends there. It is
    therefore called once if one part of a run ends at a call time and the next part begins there.
    """

    system: System
    instants: Mapping[int, np.ndarray]
    """Ascending call times of each controller; key: index of the controller in the system"""
    rounding: Mapping[int, float]
    """Largest difference between two times that count as one call time; key: index of the controller"""

    @property
    def every(self) -> np.ndarray:
        """The call times of all controllers, ascending."""
        return np.unique(np.concatenate(list(self.instants.values())))

    def later(self, time: float) -> np.ndarray:
        """The call times of all controllers after a time, ascending, without those due at the time itself."""
        after = [
            instants[instants > time + self.rounding[number]] for number, instants in self.instants.items()
        ]
        return np.unique(np.concatenate(after))

    def called(self, model: Model, motion: SystemMotion, control: ControlState) -> ControlState | None:
        """State of all controllers after the calls that are due; None if no call is due."""
        time = float(motion.time)
        # Up to rounding: if a longer run continues a shorter one, the last digits of their call times differ.
        due = [n for n, instants in self.instants.items() if abs(instants - time).min() <= self.rounding[n]]
        if not due:
            return None
        read = motion._replace(control=ControlStep(control, np.zeros(())))
        every = jax.tree.map(np.asarray, _read(model, read))
        held, memory = list(control.held), list(control.memory)
        for number in due:
            held[number], memory[number] = self._called(number, time, every[number], control.memory[number])
        return control._replace(held=tuple(held), memory=tuple(memory))

    def _called(self, number: int, time: float, readings: Any, memory: Any) -> tuple[Any, Any]:
        controller = self.system.controllers[number]
        assert isinstance(controller, SampledController)
        what = f"controller '{controller.name}' at t = {time:g}"
        given = {name: np.array(value) for name, value in memory.items()}
        found = controller.law(time, readings, given)
        if not isinstance(found, tuple) or len(found) != 2 or not isinstance(found[0], Mapping):
            raise ModelError(f"{what} must return (outputs, memory), two dictionaries; it returned {found!r}")
        outputs, after = found
        if set(outputs) != set(controller.drives):
            raise ModelError(
                f"{what} must return outputs for {sorted(controller.drives)}; it returned {sorted(outputs)}"
            )
        held = {}
        for name, element in controller.drives.items():
            value = np.array(outputs[name], dtype=float)
            if value.size != np.zeros(element.value_shape).size or not np.isfinite(value).all():
                raise ModelError(
                    f"{what}: output '{name}' must be finite, of shape {element.value_shape}, got {value}"
                )
            held[name] = value.reshape(element.value_shape)
        remembered = as_memory(controller.name, after)
        shapes = {name: value.shape for name, value in remembered.items()}
        # Compared with the memory before the call, not with `given`, which the law may have changed in place.
        if shapes != {name: np.shape(value) for name, value in memory.items()}:
            raise ModelError(
                f"{what}: its memory must keep its names and shapes, because result files store it. The law "
                f"returned {shapes}; define every entry in the initial memory, memory={{..}}"
            )
        return held, remembered


def sampling_of(system: System, run: Run) -> ControllerSampling | None:
    """Call times of a machine's controllers in a run; None without sampled controllers."""
    times = run.times
    found, rounding = {}, {}
    for number, controller in enumerate(system.controllers):
        if isinstance(controller, SampledController):
            count = int(np.floor((times[-1] - times[0]) / controller.every * (1 + 1e-12))) + 1
            instants = times[0] + controller.every * np.arange(count)
            nearest = times[np.clip(np.searchsorted(times, instants), 1, len(times) - 1)]
            before = times[np.clip(np.searchsorted(times, instants) - 1, 0, len(times) - 1)]
            rounding[number] = _SAME * controller.every
            for output in (before, nearest):
                instants = np.where(abs(instants - output) <= rounding[number], output, instants)
            found[number] = instants
    return ControllerSampling(system, found, rounding) if found else None


def march_sampled(
    sampling: ControllerSampling | None,
    march: Callable[[S, np.ndarray], Leg[S]],
    after_calls: Callable[[S], S],
    state: S,
    times: np.ndarray,
) -> Leg[S]:
    """Integrate to each output time, and interrupt the integration at call times.

    sampling : None without sampled controllers
    march : function that integrates to output times without interruption
    after_calls : function that returns a state after the calls that are due
    """
    now = float(state.time)
    if sampling is None or times[-1] <= now:
        return march(state, times)
    legs: list[Leg[S]] = []
    while now < times[-1]:
        state = after_calls(state)
        later = sampling.later(now)
        later = later[later < times[-1]]
        end = float(later[0]) if later.size else float(times[-1])
        outputs = times[(times > now) & (times <= end)]
        leg = march(state, np.unique(np.append(outputs, end)))
        if end not in times:  # a call time is not an output time
            kept = min(leg.n_reached, len(outputs))
            rows = jax.tree.map(lambda leaf, kept=kept: leaf[:kept], leg.states)
            leg = Leg(rows, kept, leg.last, leg.statistics, leg.stopped)
        legs.append(leg)
        state, now = leg.last, end
        if leg.stopped is not None:
            break
    return joined_legs(legs)


def joined_legs(legs: Sequence[Leg[S]]) -> Leg[S]:
    """Legs, each from the end of the one before, as one."""
    return Leg(
        states=jax.tree.map(lambda *own: np.concatenate(own), *(leg.states for leg in legs)),
        n_reached=sum(leg.n_reached for leg in legs),
        last=legs[-1].last,
        statistics=sum((leg.statistics for leg in legs), Statistics()),
        stopped=legs[-1].stopped,
    )


_read = CachedProgram(readings_at, STARTING)
