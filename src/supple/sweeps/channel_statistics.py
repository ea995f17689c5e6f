"""Statistics of channels over a run."""

from __future__ import annotations

import numpy as np

from supple.arrays import FloatArray

STATISTICS = ("mean", "minimum", "maximum", "standard deviation", "time of minimum", "time of maximum")
"""Names of the statistics, in the order of `channel_statistics`; the last two are in the unit of time."""


def channel_statistics(times: FloatArray, values: FloatArray) -> FloatArray:
    """Statistics (6, c) of channels over the duration of a run.

        mean = 1/T integral y dt,   deviation^2 = 1/T integral (y - mean)^2 dt     (trapezoidal rule)

    times : (t,) at least two;  values : (t, c)
    """
    weights = np.zeros(len(times))
    weights[:-1] += 0.5 * np.diff(times)
    weights[1:] += 0.5 * np.diff(times)
    weights /= times[-1] - times[0]
    mean = weights @ values
    low, high = values.argmin(axis=0), values.argmax(axis=0)
    columns = np.arange(values.shape[1])
    return np.stack(
        [
            mean,
            values[low, columns],
            values[high, columns],
            np.sqrt(weights @ (values - mean) ** 2),
            times[low],
            times[high],
        ]
    )
