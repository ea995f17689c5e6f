"""A measurement: times and values of an observable."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from supple.arguments import check_numbers, check_text
from supple.errors import ModelError
from supple.machine import System
from supple.sensitivity.observable import observables_of

__all__ = ["Measurement"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measured history of one channel of a sensor.

    observable : name of the sensor or other observable with values (t, c)
    times : (k,)            ascending, within the run; a cubic spline interpolates the computed values
    values : (k,)           in the units of the model; nan or infinite for missing values
    channel : str | int     name of the channel, or number of the column; 0 for a single channel
    deviation : float | (k,)    standard deviation of the noise; None only in a fit of one measurement, where
        it follows from the residuals
    Raises ModelError for other shapes, times that do not ascend, a deviation that is not positive.
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
    def weights(self) -> Array:
        """Reciprocal deviations (k',) of the k' finite measured values; ones without known deviations."""
        deviation = 1.0 if self.deviation is None else np.asarray(self.deviation)
        return np.broadcast_to(1 / deviation, np.shape(self.times))[self.known]

    def column(self, system: System, observables: Any) -> int:
        """Column number of the channel in its observable; ModelError if a name does not exist."""
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

    def residuals(self, times: Array, values: Mapping[str, Array], column: int) -> Array:
        """Residuals (k',): computed minus measured values, divided by the deviations.

        times : (t,) output times of the run;   values : by observable, (t, c)
        """
        computed = self.at_times(times, values[self.observable], column)
        return self.weights * (computed - np.asarray(self.values)[self.known])

    def at_times(self, times: Array, values: Array, column: int) -> Array:
        """A column of values (t, c), interpolated at the times of the finite measured values, (k',).

        Raises ModelError for measured times outside the run, or a column that does not exist.
        """
        own = np.asarray(self.times)[self.known]
        slack = 1e-9 * (times[-1] - times[0])
        if own.size and (own[0] < times[0] - slack or own[-1] > times[-1] + slack):
            raise ModelError(
                f"measurement of '{self.observable}': its times from {own[0]:g} to {own[-1]:g} go beyond the "
                f"run from {times[0]:g} to {times[-1]:g}: extend the run, or remove the other times"
            )
        if values.ndim != 2 or not 0 <= column < values.shape[1]:
            raise ModelError(
                f"measurement of '{self.observable}': it has values of shape {values.shape}, and column "
                f"{column} of (t, c) was measured"
            )
        return CubicSpline(times, values[:, column])(own)
