"""Are the output times dense enough to show the motion? A vibration between them looks like a slower one.

Positions q alone cannot tell; but velocities v and accelerations a are stored beside them. With D the central
difference over two output steps H, the signal

    u = v - D q,        du/dt = a - D v

holds of a vibration of frequency w the part 1 - sin(w H) / (w H): nearly nothing where outputs are
dense, nearly all of it beyond their limit, w H = pi. Its root mean squares give the frequency,
|du/dt| / |u|, and the amplitude, |u| / (w - sin(w H) / H), of what the outputs do not show.
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

__all__ = ["Hidden", "hidden_vibration", "report_output_rate"]

SHARE = 0.1
"""Of the motion: a vibration of less does not matter."""
NEGLIGIBLE = 1e-6
"""Of the machine's size: motions below do not matter."""
WINDOWS = 8
SHORTEST = 32
"""Output times of a window at least: a vibration that decays is looked for where it is."""
MOST_COLUMNS = 32
PER_PERIOD = 10
FEWEST = 10
"""Output times: fewer are instants that somebody wants, and no curve."""


@dataclass(frozen=True)
class Hidden:
    """A vibration that output times do not show: rad/s, and its part of the whole motion."""

    frequency: float
    share: float
    amplitude: float
    """Root mean square"""


def hidden_vibration(
    positions: np.ndarray, velocities: np.ndarray, accelerations: np.ndarray, output_step: float
) -> Hidden:
    """What output times (t,), evenly spaced, do not show of a motion (t, m); its window of most."""
    n = len(positions)
    found = Hidden(0.0, 0.0, 0.0)
    if n < FEWEST:
        return found

    def missed(values: np.ndarray, rates: np.ndarray) -> np.ndarray:
        return rates[1:-1] - (values[2:] - values[:-2]) / (2 * output_step)

    hidden, its_rate = missed(positions, velocities), missed(velocities, accelerations)
    size = _rms(positions - positions.mean(axis=0))
    number = min(WINDOWS, max(1, n // SHORTEST))
    for u, du in zip(np.array_split(hidden, number), np.array_split(its_rate, number), strict=True):
        # Tapered, for a window holds no whole number of periods.
        taper = np.sqrt(np.hanning(len(u) + 2)[1:-1, None])
        own, its_own_rate = _rms(taper * u), _rms(taper * du)
        if own > 0 and size > 0:
            frequency = its_own_rate / own
            if frequency * output_step <= np.pi:
                continue
            amplitude = _rms(u) / (frequency * (1 - np.sinc(frequency * output_step / np.pi)))
            if amplitude > found.amplitude:
                found = Hidden(frequency, amplitude / size, amplitude)
    return found


def _rms(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(signal**2, axis=1))))


def report_output_rate(system: System, run: Run, solution: Solution) -> None:
    """Warn ResolutionWarning of a body whose vibration, or spin, the output times do not show.

    A warning even when the run is strict: the motion is right, what is drawn of it is not.
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
    also = ", and a step no longer," if isinstance(control, FixedStep) and control.size > needed else ""
    message = (
        f"the output step of {step:.3g} is too long to show the motion of body '{name}': {what} "
        f"{frequency / (2 * np.pi):.3g} times per unit of time, and outputs show {1 / (2 * step):.3g} at "
        "most, so that curves and pictures show a slower one instead. An output step of "
        f"{needed:.2g}{also} shows it"
    )
    warnings.warn(message, ResolutionWarning, stacklevel=3)


def _too_fast(motion: FloatingMotion, step: float, sizes: tuple[float, float]) -> Iterator[tuple[str, float]]:
    """What is too fast for the outputs, in words, and its frequency in rad/s."""
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
        if columns > MOST_COLUMNS:  # a few random combinations see what thousands of nodes do
            mix = np.random.default_rng(0).standard_normal((columns, MOST_COLUMNS)) / np.sqrt(MOST_COLUMNS)
        found = hidden_vibration(positions @ mix, velocities @ mix, accelerations @ mix, step)
        if found.share > SHARE and found.amplitude > NEGLIGIBLE * size:
            yield what, found.frequency
    spins = np.linalg.norm(motion.angular_velocity, axis=1)
    spin = float(np.median(spins))
    if spin * step > np.pi:
        yield "it turns", spin
