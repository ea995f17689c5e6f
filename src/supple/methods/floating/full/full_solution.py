"""Conversion of the states of machines with full bodies to a solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import jax
import numpy as np

from supple.arrays import Tree
from supple.equations.configuration import SystemMotion
from supple.equations.control_series import control_series
from supple.equations.floating_solution import StationMotions, floating_solution
from supple.integrate import Solution, Statistics
from supple.methods.floating.full.full_state import FullState
from supple.methods.floating.full.full_system import FullSystem


def full_solution(
    machine: FullSystem,
    states: Sequence[FullState],
    statistics: Statistics,
    engine_state: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> Solution:
    """The motion through some states, with the forces of the joints."""

    def over_time(name: str) -> Tree:
        return jax.tree.map(lambda *own: np.array(own), *(getattr(state, name) for state in states))

    items = "time", "configuration", "velocity", "acceleration", "multipliers"
    motion, active = SystemMotion(*map(over_time, items)), machine.model.active
    return floating_solution(
        machine.system,
        machine.slices,
        active,
        motion,
        statistics,
        engine_state,
        _seen(machine, states),
        _control_series(machine, states),
    )


def _control_series(machine: FullSystem, states: Sequence[FullState]) -> dict[str, np.ndarray]:
    if not machine.model.controllers:
        return {}
    motions = [machine.border_motion(state) for state in states]
    motion = jax.tree.map(lambda *own: np.stack(own), *motions)
    return control_series(machine.model, motion, motion.control.start)


def _seen(machine: FullSystem, states: Sequence[FullState]) -> StationMotions | None:
    if not machine.lines:
        return None
    bodies, stations = {}, {}
    for line in machine.lines:
        motion = line.motion(machine.body_states(line.index, states))
        bodies[machine.system.bodies[line.index].body.name] = motion
        stations |= line.station_motions(motion)
    return StationMotions(machine.seen, bodies, stations)
