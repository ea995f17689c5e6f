"""Plots of errors of reduced models on a logarithmic axis: over time, a parameter, or the eigenvalues."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.results.error_measures import MotionError
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import (
    COLOURS,
    INK,
    REFERENCE,
    Stroke,
    draw_curve,
    legend_above,
    new_figure,
    save_figure,
    textbook_style,
)

__all__ = ["plot_eigenvalue_error", "plot_error_over_parameter", "plot_rms_error"]

Bounds = Mapping[str, float]
_MARKERS = "osD^vP"


def plot_rms_error(
    path: Path | str,
    errors: Mapping[str, MotionError],
    *,
    published: Bounds = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw RMS errors over time on a logarithmic axis, with published bounds as labelled dashed lines.

    Parameters
    ----------
    errors : {label: MotionError}
    published : {label: value}      a bound with the label of an error is drawn in the colour of that error

    Raises
    ------
    ModelError          no errors, or an error that is zero throughout
    ResultFileError     the file cannot be written
    """
    if not errors:
        raise ModelError(f"cannot draw {path}: give at least one error over time")
    with _error_axes(labelled("time", units.time), labelled("RMS error", units.length)) as (figure, axes):
        for rank, (label, error) in enumerate(errors.items()):
            draw_curve(axes, error.times, _drawable(error.rms, label), Stroke(width=1.1), rank, label)
        _draw_bounds(axes, published, list(errors))
        axes.set_xlim(min(e.times[0] for e in errors.values()), max(e.times[-1] for e in errors.values()))
        legend_above(axes)
        return save_figure(figure, path)


def plot_error_over_parameter(
    path: Path | str,
    parameter: NDArray[np.float64],
    errors: Mapping[str, NDArray[np.float64]],
    *,
    parameter_label: str,
    error_label: str = "relative error (%)",
) -> Path:
    """Draw errors of several models over a parameter, such as the final speed, on a logarithmic axis.

    Parameters
    ----------
    parameter : array (k,)
    errors : {label: array (k,)}    NaN where a model failed

    Raises
    ------
    ModelError          no errors, arrays of different lengths, or an error that is zero throughout
    ResultFileError     the file cannot be written
    """
    if not errors:
        raise ModelError(f"cannot draw {path}: give at least one error")
    with _error_axes(parameter_label, error_label) as (figure, axes):
        for rank, (label, values) in enumerate(errors.items()):
            if len(values) != len(parameter):
                raise ModelError(
                    f"error '{label}': {len(values)} values for {len(parameter)} {parameter_label}"
                )
            marked = Stroke(marker=_MARKERS[rank % len(_MARKERS)])
            draw_curve(axes, parameter, _drawable(values, label), marked, rank, label)
        axes.set_xticks(np.asarray(parameter))
        legend_above(axes)
        return save_figure(figure, path)


def plot_eigenvalue_error(
    path: Path | str,
    estimates: Mapping[int, NDArray[np.float64]],
    tolerance: float,
    *,
    exact: Mapping[int, NDArray[np.float64]] | None = None,
) -> Path:
    """Draw the error of every eigenvalue for several numbers of retained modes. [Han2020] Fig. 4

    Parameters
    ----------
    estimates : {number of modes: (N,)} relative errors, infinite where the reduced body lacks the eigenvalue
    tolerance : float                   drawn as a dashed line
    exact     : {number of modes: (N,)} drawn dashed beside the estimates

    Raises
    ------
    ModelError          no errors; none of them positive and finite
    ResultFileError     the file cannot be written
    """
    if not estimates:
        raise ModelError(f"cannot draw {path}: give the errors for at least one number of modes")
    with _error_axes("elastic eigenvalue", "relative error", height=3.3) as (figure, axes):
        for rank, (n_kept, errors) in enumerate(estimates.items()):
            label, numbers = f"{n_kept} modes", np.arange(1, len(errors) + 1)
            marked = Stroke(width=1.1, marker=_MARKERS[rank % len(_MARKERS)])
            draw_curve(axes, numbers, _drawable(errors, label), marked, rank, label)
        for n_kept, errors in (exact or {}).items():
            label, numbers = f"{n_kept} modes, exact", np.arange(1, len(errors) + 1)
            draw_curve(axes, numbers, _drawable(errors, label), REFERENCE, 0, label)
        axes.axhline(tolerance, color=INK, linewidth=0.9, dashes=(1.5, 1.5))
        axes.annotate(
            f"tolerance {100 * tolerance:g} %",
            (0.0, tolerance),
            xycoords=axes.get_yaxis_transform(),
            xytext=(3.0, 2.0),
            textcoords="offset points",
            fontsize=7.5,
        )
        legend_above(axes)
        return save_figure(figure, path)


@contextmanager
def _error_axes(abscissa: str, ordinate: str, *, height: float = 3.1) -> Iterator[tuple[Figure, Axes]]:
    """Axes for errors on a logarithmic scale, in the style of the library within the block."""
    with textbook_style():
        figure = new_figure(height)
        axes = figure.subplots()
        axes.set_yscale("log")
        axes.set_xlabel(abscissa)
        axes.set_ylabel(ordinate)
        yield figure, axes


def _drawable(values: NDArray[np.float64], label: str) -> NDArray[np.float64]:
    """Values with gaps where a logarithmic axis cannot show them, as at an exact start."""
    drawn = np.where(np.isfinite(values) & (np.asarray(values) > 0.0), values, np.nan)
    if np.isnan(drawn).all():
        raise ModelError(f"error '{label}' is nowhere positive and finite: a logarithmic axis cannot show it")
    return drawn


def _draw_bounds(axes: Axes, published: Bounds, labels: list[str]) -> None:
    """Dashed lines on a logarithmic axis, which is extended for the label above the highest one."""
    axes.set_ylim(top=max(axes.get_ylim()[1], 2 * max(published.values(), default=0.0)))
    for label, value in published.items():
        colour = COLOURS[labels.index(label) % len(COLOURS)] if label in labels else COLOURS[-1]
        axes.axhline(value, color=colour, linewidth=1.0, dashes=(4.0, 2.0))
        axes.annotate(
            f"{'published' if label in labels else label}: {_power_of_ten(value)}",
            (1.0, value),
            xycoords=axes.get_yaxis_transform(),
            xytext=(-2.0, 2.0),
            textcoords="offset points",
            ha="right",
            va="bottom",
            color=colour,
            fontsize=7.5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
        )


def _power_of_ten(value: float) -> str:
    mantissa, exponent = f"{value:.1e}".split("e")
    return rf"${mantissa} \times 10^{{{int(exponent)}}}$"
