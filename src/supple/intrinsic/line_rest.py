"""Where a machine of intrinsic bodies rests."""

from __future__ import annotations

import jax
import numpy as np

from supple.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.intrinsic.line_statics import line_equilibrium
from supple.intrinsic.machine_of_lines import machine_of_lines
from supple.machine import System

__all__ = ["line_rest"]


def line_rest(system: System, *, time: float = 0.0, n_steps: int = 1) -> dict[str, IntrinsicMotion]:
    """Equilibrium of intrinsic bodies whose roots are held, at any deflection.

    Parameters
    ----------
    time : of the loads and laws
    n_steps : of the loads, from none to all of them; a step that fails is halved

    Returns
    -------
    IntrinsicMotion by body name, of one instant

    Raises ModelError and ConvergenceError as `line_equilibrium`.
    """
    machine = machine_of_lines(system, time)
    found = line_equilibrium(machine.lines, machine.start, time=time, n_steps=n_steps)
    one = jax.tree.map(lambda leaf: leaf[None], found.states)
    return machine.motions(np.array([time]), one)
