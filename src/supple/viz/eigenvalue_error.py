"""Eigenvalue errors over the mode number, for several numbers of fixed-interface modes. [Han2020] Fig. 4"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.viz.rms_error import drawable
from supple.viz.style import (
    INK,
    REFERENCE,
    SOLID,
    Stroke,
    draw_curve,
    legend_above,
    new_figure,
    save_figure,
    textbook_style,
)

__all__ = ["plot_eigenvalue_error"]

Array = NDArray[np.float64]


def plot_eigenvalue_error(
    path: Path | str,
    estimates: Mapping[int, Array],
    tolerance: float,
    *,
    exact: Mapping[int, Array] | None = None,
) -> Path:
    """Draw the error of every eigenvalue for several numbers of retained modes, on a logarithmic axis.

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
    with textbook_style():
        figure = new_figure(height=3.3)
        axes = figure.subplots()
        for rank, (n_kept, errors) in enumerate(estimates.items()):
            label = f"{n_kept} modes"
            marked = Stroke(colour=SOLID.colour, width=1.1, marker="osD^vP"[rank % 6])
            draw_curve(axes, np.arange(1, len(errors) + 1), drawable(errors, label), marked, rank, label)
        for n_kept, errors in (exact or {}).items():
            label = f"{n_kept} modes, exact"
            numbers = np.arange(1, len(errors) + 1)
            draw_curve(axes, numbers, drawable(errors, label), REFERENCE, 0, label)
        axes.axhline(tolerance, color=INK, linewidth=0.9, dashes=(1.5, 1.5))
        axes.annotate(
            f"tolerance {100 * tolerance:g} %",
            (0.0, tolerance),
            xycoords=axes.get_yaxis_transform(),
            xytext=(3.0, 2.0),
            textcoords="offset points",
            fontsize=7.5,
        )
        axes.set_yscale("log")
        axes.set_xlabel("elastic eigenvalue")
        axes.set_ylabel("relative error")
        legend_above(axes, len(estimates) + len(exact or {}))
        return save_figure(figure, path)
