"""Curves over time in panels, such as computed and reference results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import (
    SOLID,
    TEXT_WIDTH,
    Stroke,
    draw_curve,
    legend_above,
    new_figure,
    save_figure,
    textbook_style,
)

__all__ = ["Panel", "Series", "plot_time_history"]

_LARGE = 1e4
"""If an axis reaches this value, its numbers are written with the prefixes k, M, G."""
NOISE = 1e-6
"""Values smaller than this fraction of the largest magnitude of the quantity are drawn as zero."""
_LEAST_SPAN = 10 * NOISE
"""Least range of an axis, relative to the largest magnitude: noise on a constant does not fill the axis."""


@dataclass(frozen=True)
class Series:
    """One curve: values (t,) at times (t,), with its label. NaN leaves a gap.

    Raises
    ------
    ModelError  times and values of different shapes, or no finite value
    """

    label: str
    times: NDArray[np.float64]
    values: NDArray[np.float64]
    stroke: Stroke = field(default=SOLID)

    def __post_init__(self) -> None:
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.ndim != 1 or times.shape != values.shape:
            raise ModelError(
                f"series '{self.label}': times of shape {times.shape} and values of shape {values.shape}; "
                "give two arrays of equal length"
            )
        if not np.isfinite(values).any():
            raise ModelError(f"series '{self.label}': no value is finite, so there is nothing to draw")


@dataclass(frozen=True)
class Panel:
    """One set of axes: the label of the quantity (with its unit) and the curves.

    like : largest magnitude of the quantity in all panels; by default in these curves. Values below 1e-6 of
        this magnitude are drawn as zero, and noise on a constant does not fill the axes
    """

    quantity: str
    series: Sequence[Series]
    like: float | None = None

    @property
    def largest(self) -> float:
        """The largest magnitude of the quantity."""
        if self.like is not None:
            return self.like
        return max(float(np.abs(each.values[np.isfinite(each.values)]).max()) for each in self.series)


def plot_time_history(
    path: Path | str, panels: Sequence[Panel | None], *, n_columns: int = 1, units: UnitSystem = UNNAMED
) -> Path:
    """Draw panels of curves over a common time axis, with one legend where all panels share their labels.

    panels : row by row; None leaves a position empty
    n_columns : number of panels side by side; with several, a label has the same colour in all panels

    Raises
    ------
    ModelError          no panel, or a panel without curves
    ResultFileError     the file cannot be written
    """
    drawn = [panel for panel in panels if panel is not None]
    if not drawn or not all(panel.series for panel in drawn):
        raise ModelError(f"cannot draw {path}: give at least one panel, and each panel at least one series")
    order = list(dict.fromkeys(series.label for panel in drawn for series in panel.series))
    with textbook_style():
        n_rows = -(-len(panels) // n_columns)
        figure = new_figure(height=0.5 + 2.2 * n_rows)
        table = figure.subplots(n_rows, n_columns, sharex=True, squeeze=False)
        grid = table.ravel()
        labels: list[str] = []
        for axes, panel in zip(grid, [*panels, *[None] * (len(grid) - len(panels))], strict=True):
            if panel is None:
                axes.set_axis_off()
                continue
            own = [series.label for series in panel.series]
            _draw_panel(axes, panel, [order.index(label) for label in own] if n_columns > 1 else None)
            if n_columns == 1 and own != labels and any(own):
                legend_above(axes)
            labels = labels or own
        if n_columns > 1:
            _legend_of_all(figure, grid.tolist(), order)
        for column in table.T:
            lowest = next(axes for axes in column[::-1] if axes.axison)
            lowest.set_xlabel(labelled("time", units.time))
            lowest.tick_params(labelbottom=True)
        figure.align_ylabels(table)
        return save_figure(figure, path)


def _draw_panel(axes: Axes, panel: Panel, ranks: Sequence[int] | None) -> None:
    """The curves of a panel, in the colours of their ranks, or in palette order."""
    largest = panel.largest
    for series, rank in zip(panel.series, ranks or _palette_ranks(panel.series), strict=True):
        values = np.where(np.abs(series.values) < NOISE * largest, 0.0, series.values)
        draw_curve(axes, series.times, values, series.stroke, rank, series.label)
    axes.set_ylabel(panel.quantity)
    axes.margins(x=0.0)
    low, high = axes.get_ylim()
    if high - low < _LEAST_SPAN * largest:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * _LEAST_SPAN * largest, middle + 0.5 * _LEAST_SPAN * largest)
    if max(abs(limit) for limit in axes.get_ylim()) >= _LARGE:
        # Ticks such as 0.4 M: a power of ten would be drawn in the corner, where the legend is.
        axes.yaxis.set_major_formatter(EngFormatter())
    else:
        # Ticks such as 0.006, for the same reason.
        axes.ticklabel_format(axis="y", scilimits=(-4, 4))


def _legend_of_all(figure: Figure, grid: Sequence[Axes], order: Sequence[str]) -> None:
    """One legend over all panels, each label once."""
    shown: dict[str, Artist] = {}
    for axes in grid:
        handles, labels = axes.get_legend_handles_labels()
        shown |= dict(zip(labels, handles, strict=True))
    columns = max(1, int((TEXT_WIDTH - 0.8) / (0.5 + 0.075 * max(map(len, order)))))
    handles = [shown[label] for label in order]
    figure.legend(handles, list(order), loc="outside upper left", ncols=min(columns, len(order)))


def _palette_ranks(series: Sequence[Series]) -> list[int]:
    """Number of earlier curves with colours from the palette, for each curve."""
    takes = np.array([one.stroke.colour is None for one in series], dtype=int)
    return (np.cumsum(takes) - takes).tolist()
