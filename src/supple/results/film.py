"""Output times and speed of an animation of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arguments import Positive, check_fields
from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.units import UnitSystem, plain_number

N_FRAMES = 60
"""Number of frames of an animation without a given speed."""
MOST_FRAMES = 2000
LARGEST_OFF = np.radians(5.0)
"""Largest deviation of a frame from the angle of a `RotorAngle`, rad; above it, ModelError."""


@dataclass(frozen=True)
class RotorAngle:
    """Frames at the times when a joint passes one angle: a rotor appears at rest.

    joint : name of the joint
    angle : rad, about its z axis; zero at assembly
    """

    joint: str
    angle: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Film:
    """Time window of a run, frame rate and speed of its animation.

    frames_per_second : at most 50; in a GIF, 100 / k with a whole number k
    speed : time of the run that one second of the animation shows, a time; default: 60 frames over the
        window
    start : start of the time window, a time; default: that of the run
    end : end of the time window, a time; default: that of the run
    at : angle of a rotor at which frames are taken, one per revolution

    Raises ModelError for more than 50 frames a second, a window that ends before it starts, or both a speed
    and the angle of a rotor.
    """

    frames_per_second: Positive = 12.0
    speed: Positive | None = None
    start: float | None = None
    end: float | None = None
    at: RotorAngle | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if self.frames_per_second > 50.0:
            raise ModelError(f"an animation of {self.frames_per_second:g} frames a second: give at most 50")
        if self.start is not None and self.end is not None and self.start >= self.end:
            raise ModelError(f"an animation from {self.start:g} to {self.end:g} is empty: give a later end")
        if self.speed is not None and self.at is not None:
            raise ModelError(
                "an animation has a speed, or one frame per passage of a rotor angle: remove one of them"
            )


WHOLE_RUN = Film()
"""Sixty frames over the whole run."""


def film_rows(film: Film, times: FloatArray, rate: float, angles: FloatArray | None = None) -> IntArray:
    """Index of the output time that each frame of an animation shows; an index may repeat.

        t_i = start + i speed / rate        frame i shows the output time nearest to t_i

    Without a speed, at most 60 different output times are spread over the window. With `film.at`, the output
    times are those of `standing_rows`.

    Parameters
    ----------
    times : (t,) of the run
    rate : frames per second of the file
    angles : (t,) rad, of the joint of `film.at`

    Raises
    ------
    ModelError  no output time in the window, too many frames, output times too far apart for the rotor
    """
    first, last = _window(film, times)
    if film.at is not None:
        assert angles is not None
        rows = first + standing_rows(angles[first : last + 1], film.at)
        _check_length(len(rows))
        return rows
    if film.speed is None:
        return np.unique(np.linspace(first, last, N_FRAMES).astype(np.int64))
    number = 1 + int(np.floor((times[last] - times[first]) * rate / film.speed + 1e-9))
    _check_length(number)
    wanted = times[first] + np.arange(number) * film.speed / rate
    after = np.clip(np.searchsorted(times, wanted), 1, max(len(times) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(times) - 1)
    return np.where(times[after] - wanted < wanted - times[before], after, before)


def _check_length(number: int) -> None:
    if number > MOST_FRAMES:
        raise ModelError(
            f"an animation of {number} frames exceeds {MOST_FRAMES}: give a higher speed or a shorter window"
        )


def _window(film: Film, times: FloatArray) -> tuple[int, int]:
    """Indices of the first and the last output time in the window; ModelError if it contains none."""
    slack = 1e-9 * float(np.abs(times).max())
    start = times[0] if film.start is None else film.start
    end = times[-1] if film.end is None else film.end
    inside = np.flatnonzero((times >= start - slack) & (times <= end + slack))
    if not len(inside):
        raise ModelError(
            f"an animation from {start:g} to {end:g} shows no output time: the run goes from {times[0]:g} to "
            f"{times[-1]:g}"
        )
    return int(inside[0]), int(inside[-1])


def standing_rows(angles: FloatArray, at: RotorAngle) -> IntArray:
    """Indices of the output times nearest to each passage of a joint through its angle.

    angles : (t,) rad, continuous over several revolutions
    Raises ModelError if the joint does not pass the angle, or is more than 5 deg from it at the nearest
    output time.
    """
    turns = (angles - at.angle) / (2 * np.pi)
    whole = np.round(turns)
    turns = np.where(np.abs(turns - whole) < 1e-9, whole, turns)
    floors = np.floor(turns)
    before = np.flatnonzero(np.diff(floors))
    passed = np.maximum(floors[before], floors[before + 1])
    nearer = np.abs(turns[before] - passed) <= np.abs(turns[before + 1] - passed)
    rows = np.unique(np.concatenate([np.where(nearer, before, before + 1), np.flatnonzero(turns == whole)]))
    if not len(rows):
        raise ModelError(
            f"joint '{at.joint}' does not pass {at.angle:g} rad in the animation: it rotates from "
            f"{angles.min():.4g} to {angles.max():.4g} rad"
        )
    off = off_angle(angles[rows], at)
    if off > LARGEST_OFF:
        raise ModelError(
            f"joint '{at.joint}' is {np.degrees(off):.3g} deg from {at.angle:g} rad at the nearest output "
            f"time: give output times at most {np.degrees(2 * LARGEST_OFF):g} deg apart, or another angle"
        )
    return rows.astype(np.int64)


def off_angle(angles: FloatArray, at: RotorAngle) -> float:
    """Largest deviation of angles (t,) from the angle of `at`, modulo a revolution, rad."""
    off = angles - at.angle
    return float(np.abs(off - 2 * np.pi * np.round(off / (2 * np.pi))).max())


def speed_words(times: FloatArray, rate: float, units: UnitSystem) -> str:
    """Speed of frames at times (t,), such as "0.05 x real time"; "" for a single frame."""
    if len(times) < 2 or times[-1] <= times[0]:
        return ""
    speed = float(times[-1] - times[0]) / (len(times) - 1) * rate
    second = units.in_si(time=1)
    if second is None:
        return f"{plain_number(speed, 2)} a second"
    words = plain_number(speed * second, 2)
    return "real time" if words == "1" else f"{words} × real time"
