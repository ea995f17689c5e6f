"""A mode as a motion, for pictures and animations."""

from __future__ import annotations

import numpy as np

from supple.errors import ModelError
from supple.integrate import FramedMotion, Solution
from supple.linearization.machine_modes import MachineModes

__all__ = ["mode_motion"]

LARGEST_TURN = 1.0
"""rad, largest rotation of a frame; it limits the amplitude of modes that mainly rotate bodies."""


def mode_motion(
    modes: MachineModes, number: int, *, amplitude: float, n_instants: int = 24, n_periods: int = 1
) -> Solution:
    """One mode as a motion about the equilibrium, without its decay.

        p(t) = a Re( shape exp(i w t) )

    Frames rotate by finite rotations, so that a large amplitude causes no shear in the picture. A mode that
    does not oscillate is shown with one cycle per unit of time.

    Parameters
    ----------
    number : number of the mode, from 0 for the slowest
    amplitude : largest translation of a node, unit of length, which determines a; reduced if a frame would
        rotate by more than one radian
    n_instants : number of instants per period

    Raises ModelError for a mode that does not exist.
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
    translation, turn = _largest_translation_and_turn(modes, number)
    swing *= 1 / max(translation / amplitude, turn / LARGEST_TURN, 1e-300)
    return machine.motion_near(swing, np.zeros_like(swing), phases / (2 * np.pi) * period)


def _largest_translation_and_turn(modes: MachineModes, number: int) -> tuple[float, float]:
    """Largest translation of any node, interface or frame, and rotation of any frame, in an unscaled mode."""
    shape, largest, turn = modes.shapes[:, number], 0.0, 0.0
    moving = modes.machine.moving_at(np.array([shape.real, shape.imag]))
    for body in (placed.body for placed in modes.machine.system.bodies):
        motion = moving.motion(body.name, FramedMotion)
        real, imaginary = np.concatenate(
            [
                motion.velocity[:, None],
                body.node_motion(motion, np.arange(len(body.nodes))).velocity,
                *(body.interface_motion(motion, end.name).velocity[:, None] for end in body.interfaces),
            ],
            axis=1,
        )
        largest = max(largest, float(np.linalg.norm(real + 1j * imaginary, axis=1).max()))
        about, and_about = motion.angular_velocity
        turn = max(turn, float(np.linalg.norm(about + 1j * and_about)))
    return largest, turn
