"""Conversion of instants of lines and floating bodies to a solution."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from supple.equations.floating_solution import body_motions, joint_multipliers
from supple.equations.joint_wrench import joint_wrenches
from supple.integrate import Motion, Solution, Statistics
from supple.methods.intrinsic.joined_equations import JoinedInstant, JoinedRates
from supple.methods.intrinsic.joined_machine import JoinedMachine
from supple.methods.intrinsic.machine_of_lines import line_motion

__all__ = ["joined_solution"]


def joined_solution(
    machine: JoinedMachine,
    now: JoinedInstant,
    velocities: np.ndarray,
    rates: JoinedRates,
    multipliers: np.ndarray,
    statistics: Statistics,
    engine_state: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> Solution:
    """Stacked instants (leading axis: time) as a solution, with joint forces.

    velocities : (t, n)     velocities of all bodies of the model, including stations
    """
    arrays, seen, times = machine.arrays, machine.seen, np.asarray(now.time)
    model, still = arrays.model, np.zeros((len(times), 6 * arrays.n_coupled))
    accelerations = np.concatenate([rates.acceleration, still], axis=1)
    floating = body_motions(seen, model.slices, now.floating, velocities, accelerations)
    of_joints = joint_multipliers(seen, model.active, multipliers)
    bodies: dict[str, Motion] = {
        placed.body.name: line_motion(placed, own, None, state, rate.q1, times)
        for placed, own, state, rate in zip(machine.lines, arrays.lines, now.lines, rates.lines, strict=True)
    }
    names = [placed.body.name for placed in machine.system.bodies]
    bodies |= {name: motion for name, motion in floating.items() if name in names}
    return Solution(
        times=times,
        bodies={name: bodies[name] for name in names},
        joint_forces=joint_wrenches(seen, times, floating, of_joints),
        statistics=statistics,
        engine_state=engine_state,
        multipliers=of_joints,
    )
