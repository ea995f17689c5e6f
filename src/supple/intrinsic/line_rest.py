"""Where a machine of intrinsic bodies rests."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from supple.integrate import Solution, Statistics
from supple.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.intrinsic.line_statics import line_equilibrium
from supple.intrinsic.machine_of_lines import machine_of_lines
from supple.intrinsic.root_drive import RootDrive
from supple.intrinsic.root_reaction import reactions
from supple.machine import System
from supple.machine.laws.time_law import as_time_law

__all__ = ["line_rest", "resting_lines"]


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
    return dict(resting_lines(system, time=time, n_steps=n_steps).bodies)


def resting_lines(system: System, *, time: float = 0.0, n_steps: int = 1) -> Solution:
    """The same equilibrium as a motion of one instant, with the forces of the joints; arguments as there."""
    machine = machine_of_lines(system, time)
    still = replace(machine.lines, drives=tuple(_held(drive, time) for drive in machine.lines.drives))
    found = line_equilibrium(still, machine.start, time=time, n_steps=n_steps)
    times, one = np.array([time]), jax.tree.map(lambda leaf: leaf[None], found.states)
    machine = replace(machine, lines=still)
    forces, rates = jax.device_get(reactions(still, jnp.asarray(times), one))
    motions = machine.motions(times, one, rates)
    return Solution(
        times=times,
        bodies=motions,
        joint_forces=machine.joint_forces(forces, motions),
        statistics=Statistics(iterations=found.iterations),
        multipliers={joint.name: np.zeros((1, 0)) for joint in system.joints},
    )


def _held(drive: RootDrive | None, time: float) -> RootDrive | None:
    """A drive that stays where it is."""
    return drive and replace(drive, law=as_time_law(float(drive.law(time))))
