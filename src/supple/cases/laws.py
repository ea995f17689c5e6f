"""Laws of time of a case file as functions that the compiled equations can trace and differentiate."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from scipy.interpolate import CubicSpline

from supple.cases.law_tables import Constant, Law, Ramp, Sine, TableLaw
from supple.cases.law_tables import SpinUp as SpinUpTable
from supple.errors import ImportFormatError
from supple.machine.laws.spin_up import SpinUp

Function = Callable[[Any], Any]


def time_function(law: Law, folder: Path) -> Function:
    """The function of time t (s) that a law table describes; a table's file lies in or under `folder`.

        constant   value
        ramp       value s^3 (10 - 15 s + 6 s^2),   s = t / duration up to 1 (twice differentiable)
        sine       amplitude sin(2 pi frequency_hz t)
        spin-up    integral of a rate that grows smoothly from 0 to speed, see `supple.benchmark.SpinUp`
        table      natural cubic spline through the rows, constant beyond its ends

    Raises
    ------
    ImportFormatError   a table file that does not hold two columns of numbers with times that increase
    """
    match law:
        case Constant(value=value):
            return lambda t: value + 0.0 * t
        case Ramp(value=value, duration=duration):
            return lambda t: value * _smooth_step(t / duration)
        case Sine(amplitude=amplitude, frequency_hz=frequency):
            return lambda t: amplitude * jnp.sin(2.0 * math.pi * frequency * t)
        case SpinUpTable(speed=speed, duration=duration):
            return SpinUp(speed, duration)
        case TableLaw(file=file):
            return _spline(*read_time_table(folder / file))


def read_time_table(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and values (k,) of a CSV file with rows `time,value`; # begins a comment."""
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2)
    except ValueError as error:
        raise ImportFormatError(f"{path}: {error}; write rows of two numbers, time,value") from error
    if rows.shape[0] < 2 or rows.shape[1] != 2:
        raise ImportFormatError(
            f"{path} has {rows.shape[0]} rows of {rows.shape[1]} numbers; write two or more rows time,value"
        )
    if not np.isfinite(rows).all():
        raise ImportFormatError(f"{path} holds NaN or infinite numbers; remove these rows")
    backwards = np.flatnonzero(np.diff(rows[:, 0]) <= 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise ImportFormatError(
            f"{path}: times must increase, but row {row + 1} has {rows[row, 0]:g} after {rows[row - 1, 0]:g}"
        )
    return rows[:, 0], rows[:, 1]


def _smooth_step(s: Any) -> Any:
    s = jnp.clip(s, 0.0, 1.0)
    return s**3 * (10.0 + s * (-15.0 + 6.0 * s))


def _spline(times: np.ndarray, values: np.ndarray) -> Function:
    spline = CubicSpline(times, values, bc_type="natural")
    # Closed over as arrays so that the coefficients are constants of the compiled step.
    starts, coefficients = times[:-1], spline.c

    def value(t: Any) -> Any:
        t = jnp.clip(t, times[0], times[-1])
        piece = jnp.clip(jnp.searchsorted(starts, t, side="right") - 1, 0, len(starts) - 1)
        cubic = jnp.asarray(coefficients)[:, piece]
        return jnp.polyval(cubic, t - jnp.asarray(starts)[piece])

    return value
