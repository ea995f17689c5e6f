"""Interface of the methods: start, time integration and results of a machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from supple.integrate.solution import Solution, Statistics

__all__ = ["Engine", "Leg", "Progress", "Recorder", "StepProgress"]

S = TypeVar("S")

Progress = Callable[[float], None]
"""Called with the completed fraction of a run, 0 to 1."""
StepProgress = Callable[[str, float], None]
"""Called with the name of the current step of the work and the completed fraction of this step, 0 to 1."""
Recorder = Callable[[Solution], None]
"""Called with the solution of each completed leg; the first leg of a new run is the initial state."""


@dataclass(frozen=True)
class Leg(Generic[S]):
    """A part of a run: the states at the output times that it reached.

    states                  the states reached, in the data structure of the engine
    n_reached : int         number of these states
    last : S                the state from which to continue
    statistics : Statistics
    stopped : str | None    cause if the leg ended before its last output time, else None
    """

    states: Any
    n_reached: int
    last: S
    statistics: Statistics = field(default_factory=Statistics)
    stopped: str | None = None


class Engine(Protocol[S]):
    """A machine prepared for one method; S is the type of its state."""

    @property
    def least_leg(self) -> int:
        """Recommended smallest number of output times of a leg.

        With fewer, conversion and recording of the leg take longer than its steps. Defined after `start` or
        `resumed`.
        """
        ...

    def start(self, time: float) -> S:
        """The initial state, consistent: joints closed, constraints independent."""
        ...

    def resumed(self, last: Solution) -> S:
        """The state at the end of a recorded part; exact if `last` includes an `engine_state`."""
        ...

    def march(self, state: S, times: np.ndarray) -> Leg[S]:
        """Integrate to each of the output times (k,), the first of which may be the time of `state`."""
        ...

    def solution(self, leg: Leg[S]) -> Solution:
        """The motion of a leg that reached at least one output time, with the `engine_state` at its end."""
        ...
