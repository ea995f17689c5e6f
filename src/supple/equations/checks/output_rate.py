"""Check that output times resolve the motion: a faster vibration appears as a slower one (aliasing).

Positions q alone do not reveal the faster vibration, but velocities v and accelerations a are stored, too.
With D the central difference of outputs at intervals H, the signal

    u = v - D q,        du/dt = a - D v

contains the velocity of a vibration of frequency w with the factor 1 - sin(w H) / (w H). The factor is near
zero for w H << pi, and near one above w H = pi, the limit of what outputs resolve. With root mean squares
|u| and |du/dt|, the unresolved vibration has the frequency w = |du/dt| / |u| and the amplitude
|u| / (w - sin(w H) / H).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from supple.equations.build_model import system_length
from supple.errors import ResolutionWarning
from supple.integrate import FixedStep, FloatingMotion, Run, Solution
from supple.machine import System

SHARE = 0.1
"""Smallest reported root mean square of a vibration, relative to that of the motion about its mean."""
NEGLIGIBLE = 1e-6
"""Smallest reported root mean square of a vibration, relative to the machine's size; for coordinates,
relative to those of a displacement of this size."""
WINDOWS = 8
SHORTEST = 32
"""Largest number of windows of a run, and fewest output times of each if there are several. Windows are used
to detect vibrations that decay."""
MOST_COLUMNS = 32
"""Largest number of coordinates that are checked one by one; random combinations represent more of them."""
PER_PERIOD = 10
"""Output times per period of a vibration in the recommended output step."""
FEWEST = 10
"""With fewer output times no check is made: they are single times of interest, not a curve."""


@dataclass(frozen=True)
class UnresolvedVibration:
    """A vibration that output times do not resolve: frequency (rad/s), share and amplitude.

    The share is the amplitude, relative to the root mean square of the motion about its mean.
    """

    frequency: float
    share: float
    amplitude: float
    """Root mean square"""


def hidden_vibration(
    positions: np.ndarray, velocities: np.ndarray, accelerations: np.ndarray, output_step: float
) -> UnresolvedVibration:
    """The unresolved vibration of a motion (t, m) at evenly spaced output times; zeros without one.

    Of the vibrations in all windows, it is the one with the largest amplitude.
    """
    n = len(positions)
    found = UnresolvedVibration(0.0, 0.0, 0.0)
    if n < FEWEST:
        return found

    def missed(values: np.ndarray, rates: np.ndarray) -> np.ndarray:
        return rates[1:-1] - (values[2:] - values[:-2]) / (2 * output_step)

    hidden, its_rate = missed(positions, velocities), missed(velocities, accelerations)
    size = _rms(positions - positions.mean(axis=0))
    number = min(WINDOWS, max(1, n // SHORTEST))
    for u, du in zip(np.array_split(hidden, number), np.array_split(its_rate, number), strict=True):
        # Tapered, as a window does not contain a whole number of periods.
        taper = np.sqrt(np.hanning(len(u) + 2)[1:-1, None])
        own, its_own_rate = _rms(taper * u), _rms(taper * du)
        if own > 0 and size > 0:
            frequency = its_own_rate / own
            if frequency * output_step <= np.pi:
                continue
            amplitude = _rms(u) / (frequency * (1 - np.sinc(frequency * output_step / np.pi)))
            if amplitude > found.amplitude:
                found = UnresolvedVibration(frequency, amplitude / size, amplitude)
    return found


def _rms(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(signal**2, axis=1))))


def report_output_rate(system: System, run: Run, solution: Solution) -> None:
    """Warn (ResolutionWarning) of a body whose vibration or rotation the output times do not resolve.

    This remains a warning in a strict run: the motion is correct, but its curves and pictures are not.
    """
    if len(solution.times) < FEWEST:
        return
    step = float(run.times[1] - run.times[0])
    length = system_length(system)
    scales = {placed.body.name: placed.body.coordinate_size for placed in system.bodies}
    worst: tuple[float, str, str] | None = None
    for name, motion in solution.bodies.items():
        if not isinstance(motion, FloatingMotion):
            continue
        for what, frequency in _too_fast(motion, step, (length, length * scales[name])):
            if worst is None or frequency > worst[0]:
                worst = frequency, name, what
    if worst is None:
        return
    frequency, name, what = worst
    needed = 2 * np.pi / frequency / PER_PERIOD
    control = run.step_control
    both = isinstance(control, FixedStep) and control.size > needed
    steps = "an output step and a step" if both else "an output step"
    message = (
        f"the output step of {step:.3g} is too long to show the motion of body '{name}': {what} "
        f"{frequency / (2 * np.pi):.3g} times per unit of time; outputs resolve {1 / (2 * step):.3g}, "
        f"so that curves and pictures show a slower motion. Set {steps} of {needed:.2g} or less"
    )
    warnings.warn(message, ResolutionWarning, stacklevel=3)


def _too_fast(motion: FloatingMotion, step: float, sizes: tuple[float, float]) -> Iterator[tuple[str, float]]:
    """Motions too fast for the outputs, described for the message, with frequencies in rad/s."""
    frame = motion.position, motion.velocity, motion.acceleration
    deformation = motion.coordinates, motion.coordinate_rates, motion.coordinate_accelerations
    for what, (positions, velocities, accelerations), size in (
        ("its frame vibrates", frame, sizes[0]),
        ("it vibrates", deformation, sizes[1]),
    ):
        columns = positions.shape[1]
        if not columns:
            continue
        mix = np.eye(columns)
        if columns > MOST_COLUMNS:  # a few random combinations represent thousands of nodes
            mix = np.random.default_rng(0).standard_normal((columns, MOST_COLUMNS)) / np.sqrt(MOST_COLUMNS)
        found = hidden_vibration(positions @ mix, velocities @ mix, accelerations @ mix, step)
        if found.share > SHARE and found.amplitude > NEGLIGIBLE * size:
            yield what, found.frequency
    spins = np.linalg.norm(motion.angular_velocity, axis=1)
    spin = float(np.median(spins))
    if spin * step > np.pi:
        yield "it rotates", spin
