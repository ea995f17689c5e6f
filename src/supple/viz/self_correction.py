"""Plot of the rounds of a self-correcting reduction: error over the number of coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from supple.errors import ModelError
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import (
    REFERENCE,
    Stroke,
    draw_curve,
    legend_above,
    new_figure,
    save_figure,
    textbook_style,
)

__all__ = ["RoundErrors", "plot_rounds", "plot_self_correction"]


@dataclass(frozen=True, eq=False)
class RoundErrors:
    """Errors of the k rounds of one body, in the unit of length.

    sizes : (k,)                numbers of coordinates
    estimated : (k,)            errors; not finite where a round has no estimate
    missing_motion : (k,)       largest RMS over the nodes of the motion outside the basis of the round
    allowed : (k,)              allowed errors
    true : (k,)                 errors relative to a full run; by default unknown
    Raises ModelError without rounds, or for arrays of different lengths.
    """

    sizes: ArrayLike
    estimated: ArrayLike
    missing_motion: ArrayLike
    allowed: ArrayLike
    true: ArrayLike | None = None

    def __post_init__(self) -> None:
        if self.true is None:
            object.__setattr__(self, "true", np.full(np.shape(self.sizes), np.nan))
        for name, value in vars(self).items():
            object.__setattr__(self, name, np.asarray(value, dtype=np.float64))
        lengths = {name: np.shape(value) for name, value in vars(self).items()}
        if len(set(lengths.values())) != 1 or np.ndim(self.sizes) != 1 or not np.size(self.sizes):
            raise ModelError(
                f"rounds of a self-correction: give one number of each kind per round, not {lengths}"
            )


def plot_self_correction(
    path: Path | str, bodies: Mapping[str, RoundErrors], *, units: UnitSystem = UNNAMED
) -> Path:
    """Draw estimated error, missing motion and allowed error of every round, one panel per body.

    Raises
    ------
    ModelError          no bodies
    ResultFileError     the file cannot be written
    """
    if not bodies:
        raise ModelError(f"cannot draw {path}: give the rounds of at least one body")
    with textbook_style():
        figure = new_figure(height=0.6 + 2.6 * len(bodies))
        grid = figure.subplots(len(bodies), squeeze=False)[:, 0]
        for axes, (name, errors) in zip(grid, bodies.items(), strict=True):
            _draw_rounds(axes, errors)
            axes.set_ylabel(labelled(f"{name}: RMS error", units.length))
        legend_above(grid[0])
        grid[-1].set_xlabel("number of coordinates")
        return save_figure(figure, path)


def plot_rounds(
    path: Path | str, rounds: Sequence[Mapping[str, Any]], *, units: UnitSystem = UNNAMED
) -> Path:
    """`plot_self_correction` for rounds as numbers, from `correction_numbers`."""
    keys = ("size", "estimated_error", "indicator", "allowed")
    names = dict.fromkeys(each["body"] for each in rounds)
    of_body = {name: [each for each in rounds if each["body"] == name] for name in names}
    return plot_self_correction(
        path,
        {name: RoundErrors(*([each[key] for each in own] for key in keys)) for name, own in of_body.items()},
        units=units,
    )


def _draw_rounds(axes: Axes, errors: RoundErrors) -> None:
    curves = {
        "estimated error": (errors.estimated, Stroke(marker="o")),
        "missing motion": (errors.missing_motion, Stroke(marker="s", dashes=(1.5, 1.5))),
        "allowed": (errors.allowed, REFERENCE),
    }
    if np.isfinite(np.asarray(errors.true)).any():
        curves["true error"] = (np.asarray(errors.true), Stroke(marker="x", dashes=(4.0, 2.0)))
    for rank, (label, (values, stroke)) in enumerate(curves.items()):
        numbers = np.asarray(values)
        # A logarithmic axis cannot show other values.
        drawn = np.where(np.isfinite(numbers) & (numbers > 0), numbers, np.nan)
        draw_curve(axes, errors.sizes, drawn, stroke, rank, label)
    axes.set_yscale("log")
    axes.set_xticks(np.asarray(errors.sizes))
