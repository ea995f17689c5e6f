"""A measurement: measured values of a sensor over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from supple.arguments import check_numbers, check_text
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.machine import System
from supple.sensitivity.observable import Observables, observables_of

__all__ = ["Measurement"]


@dataclass(frozen=True, eq=False)
class Measurement:
    """Measured values, over time, of one channel of a sensor.

    observable : name of the sensor, or of another observable of the machine; its computed values are (t, c)
    times : (k,)            ascending, within the run; a cubic spline interpolates the computed values at them
    values : (k,)           in the units of the model; nan or infinite for missing values
    channel : str | int     name of the channel, or number of its column from 0
    deviation : float | (k,)    standard deviation of the measurement noise. None is possible in a fit of one
        measurement only; the deviation is then computed from the residuals
    Raises ModelError for arrays of other shapes, times that do not ascend, a deviation that is not positive.
    """

    observable: str
    times: ArrayLike
    values: ArrayLike
    channel: str | int = 0
    deviation: ArrayLike | None = None

    def __post_init__(self) -> None:
        what = f"measurement of '{self.observable}'"
        check_text("measurement, observable", self.observable, "the name of an observable")
        for name in ("times", "values") if self.deviation is None else ("times", "values", "deviation"):
            check_numbers(f"{what}, {name}", getattr(self, name))
            object.__setattr__(self, name, np.array(getattr(self, name), dtype=float))
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.ndim != 1 or values.shape != times.shape or not np.all(np.diff(times) > 0):
            raise ModelError(
                f"{what}: needs ascending times (k,) and as many values, got shapes {times.shape} and "
                f"{values.shape}"
            )
        if self.deviation is not None:
            deviation = np.asarray(self.deviation)
            if deviation.shape not in ((), times.shape) or not np.all(deviation > 0):
                raise ModelError(f"{what}: give a positive deviation, one number or one for every time")

    @property
    def known(self) -> NDArray[np.bool_]:
        """Mask (k,): True for finite measured values."""
        return np.isfinite(np.asarray(self.values))

    @property
    def weights(self) -> FloatArray:
        """Reciprocal deviations (k',) of the k' finite measured values; ones if `deviation` is None."""
        deviation = 1.0 if self.deviation is None else np.asarray(self.deviation)
        return np.broadcast_to(1 / deviation, np.shape(self.times))[self.known]

    def column(self, system: System, observables: Observables) -> int:
        """Column number of the channel; ModelError for an unknown name of an observable or a channel."""
        found = observables_of(observables, system)
        if self.observable not in found:
            raise ModelError(
                f"measurement of '{self.observable}': there is no such observable, only {', '.join(found)}"
            )
        if isinstance(self.channel, int):
            return self.channel
        names = [each.name for each in found[self.observable].channels(system)]
        if self.channel not in names:
            raise ModelError(
                f"measurement of '{self.observable}': it has no channel '{self.channel}', only "
                f"{', '.join(names)}"
            )
        return names.index(self.channel)

    def at_times(self, times: FloatArray, values: FloatArray, column: int) -> FloatArray:
        """Computed values (k',), interpolated at the times of the k' finite measured values.

        times, values, column : output times (t,), computed values (t, c), and the column to interpolate
        Raises ModelError for measured times outside the run, or a column that does not exist.
        """
        own = np.asarray(self.times)[self.known]
        slack = 1e-9 * (times[-1] - times[0])
        if own.size and (own[0] < times[0] - slack or own[-1] > times[-1] + slack):
            raise ModelError(
                f"measurement of '{self.observable}': its times from {own[0]:g} to {own[-1]:g} go beyond the "
                f"run from {times[0]:g} to {times[-1]:g}: extend the run, or remove the times outside it"
            )
        if values.ndim != 2 or not 0 <= column < values.shape[1]:
            raise ModelError(
                f"measurement of '{self.observable}': the computed values have shape {values.shape}, "
                f"without a column {column} of the channel; give values (t, c) and an existing channel"
            )
        return CubicSpline(times, values[:, column])(own)
