"""A mode as a motion, for pictures and animations."""

from __future__ import annotations

import numpy as np

from supple.errors import ModelError
from supple.integrate import Solution, Statistics
from supple.linearization.machine_modes import MachineModes

__all__ = ["mode_motion"]


def mode_motion(
    modes: MachineModes, number: int, *, amplitude: float, n_instants: int = 24, n_periods: int = 1
) -> Solution:
    """One mode as a motion about the equilibrium, its decay left out.

        p(t) = a Re( shape exp(i w t) )

    Frames turn by finite rotations, so that a large amplitude shows no shear. A mode that does not oscillate
    swings once in a unit of time.

    Parameters
    ----------
    number : from 0, the slowest
    amplitude : a, of the largest translation of a node, unit of length

    Raises ModelError for a mode that is not there.
    """
    if not 0 <= number < len(modes.eigenvalues):
        raise ModelError(
            f"there is no mode {number}: the modes are numbered 0 to {len(modes.eigenvalues) - 1}"
        )
    machine, shape = modes.machine, modes.shapes[:, number]
    frequency = float(modes.frequencies[number])
    period = 2 * np.pi / frequency if frequency > 0 else 1.0
    phases = np.linspace(0, 2 * np.pi * n_periods, n_periods * n_instants + 1)[:-1]
    swing = np.real(np.outer(np.exp(1j * phases), shape))
    swing *= amplitude / max(_largest_translation(modes, number), 1e-300)
    bodies, first = {}, 0
    for placed in machine.system.bodies:
        after = first + 6 + placed.body.n_coordinates
        pose = placed.position, placed.rotation, placed.coordinates
        own, first = swing[:, first:after], after
        bodies[placed.body.name] = placed.body.motion_near(*pose, own, np.zeros_like(own))
    return Solution(
        times=phases / (2 * np.pi) * period,
        bodies=bodies,
        joint_forces={},
        statistics=Statistics(steps=0, iterations=0, rejected_steps=0, seconds=0.0),
    )


def _largest_translation(modes: MachineModes, number: int) -> float:
    """Of any node, interface or frame in a mode of the scale that it has."""
    shape, largest, first = modes.shapes[:, number], 0.0, 0
    for placed in modes.machine.system.bodies:
        body = placed.body
        own, first = shape[first : first + 6 + body.n_coordinates], first + 6 + body.n_coordinates
        rates = np.array([np.real(own), np.imag(own)])
        pose = placed.position, placed.rotation, placed.coordinates
        motion = body.motion_near(*pose, np.zeros_like(rates), rates)
        real, imaginary = np.concatenate(
            [
                motion.velocity[:, None],
                body.node_motion(motion, np.arange(len(body.nodes))).velocity,
                *(body.interface_motion(motion, end.name).velocity[:, None] for end in body.interfaces),
            ],
            axis=1,
        )
        largest = max(largest, float(np.linalg.norm(real + 1j * imaginary, axis=1).max()))
    return largest
