"""Responses of several models over time, and beside them their errors on a logarithmic axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from supple.errors import ModelError
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import PALE_INK, draw_curve, new_figure, save_figure, textbook_style
from supple.viz.time_history import Series

__all__ = ["Response", "plot_response_errors"]

_LARGE = 1e4
_FEWEST_DECADES, _MOST_DECADES = 1.0, 12.0


@dataclass(frozen=True, eq=False)
class Response:
    """One quantity (with its unit) over time, from the reference and from models at the same times."""

    quantity: str
    reference: Series
    models: Sequence[Series]


def plot_response_errors(
    path: Path | str,
    responses: Sequence[Response],
    *,
    until: float | None = None,
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw each response on the left, and the distance of every model from the reference on the right.

    Parameters
    ----------
    responses : one row of panels each, all of the same models
    until : time    end of the comparison, such as the start of chaotic motion; drawn as a dashed line

    Raises
    ------
    ModelError          no response, or one without a model; a model at other times
    ResultFileError     the file cannot be written
    """
    if not responses or not all(response.models for response in responses):
        raise ModelError(f"cannot draw {path}: give at least one response, each of at least one model")
    for model, times in ((one, each.reference.times) for each in responses for one in each.models):
        if not np.array_equal(model.times, times):
            raise ModelError(f"series '{model.label}' is not at the times of the reference: no error to draw")
    with textbook_style():
        figure = new_figure(height=0.6 + 1.75 * len(responses))
        grid = figure.subplots(len(responses), 2, sharex=True, squeeze=False)
        for (left, right), response in zip(grid, responses, strict=True):
            times = response.reference.times
            for rank, model in enumerate(response.models):
                draw_curve(left, times, model.values, model.stroke, rank, model.label)
                error = np.abs(model.values - response.reference.values)
                draw_curve(right, times, np.where(error > 0, error, np.nan), model.stroke, rank, model.label)
            reference = response.reference
            draw_curve(left, times, reference.values, reference.stroke, 0, reference.label)
            left.set_ylabel(response.quantity)
            if max(abs(limit) for limit in left.get_ylim()) >= _LARGE:
                left.yaxis.set_major_formatter(EngFormatter())
            right.set_yscale("log")
            _limit_decades(right)
            right.set_ylabel("error")
            for axes in (left, right):
                axes.margins(x=0.0)
                if until is not None and until < times[-1]:
                    axes.axvline(until, color=PALE_INK, linewidth=0.8, dashes=(2.0, 2.0))
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=2)
        for axes in grid[-1]:
            axes.set_xlabel(labelled("time", units.time))
        figure.align_ylabels(grid)
        return save_figure(figure, path)


def _limit_decades(axes: Axes) -> None:
    """Limit the decades below the largest error, so that an exact start does not flatten the curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(bottom=max(low, high * 10**-_MOST_DECADES))
    if high / low < 10**_FEWEST_DECADES:
        axes.set_ylim(low / 3, high * 3)
