"""Campbell diagram: frequencies over speed, and the lines of its multiples."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.style import TEXT_WIDTH, new_figure, save_figure, textbook_style

__all__ = ["plot_campbell"]

Array = NDArray[np.float64]

N_ORDERS = 4
"""Multiples of the speed that are drawn."""


class FollowedModes(Protocol):
    """Modes over speed, as a Campbell diagram has them."""

    @property
    def rates(self) -> Array:
        """(ns,) rad per unit of time."""
        ...

    @property
    def frequencies(self) -> Array:
        """(ns, nm) rad per unit of time."""
        ...


@checked_arguments
def plot_campbell(path: Path | str, diagram: FollowedModes, *, units: UnitSystem = UNNAMED) -> Path:
    """Draw frequencies over speed, in the same unit, and the multiples of the speed that excite them.

    Raises ResultFileError where the file cannot be written.
    """
    unit, factor = units.frequency_shown
    factor /= 2 * np.pi
    rates = factor * np.asarray(diagram.rates)
    frequencies = factor * np.asarray(diagram.frequencies)
    with textbook_style():
        figure = new_figure(0.7 * TEXT_WIDTH)
        axes = figure.subplots()
        for order in range(1, N_ORDERS + 1):
            axes.plot(rates, order * rates, color="0.7", linewidth=0.7)
            # Amid the diagram: its right edge belongs to the names of the modes.
            middle = 0.55 * rates[0] + 0.45 * rates[-1]
            axes.annotate(f"{order}P", (middle, order * middle), color="0.4", fontsize=7, ha="center")
        for number, mode in enumerate(frequencies.T, start=1):
            axes.plot(rates, mode, marker="o", markersize=2.5)
            beside: dict[str, Any] = {
                "xytext": (4, 0),
                "textcoords": "offset points",
                "va": "center",
                "fontsize": 7,
            }
            axes.annotate(f"mode {number}", (rates[-1], mode[-1]), annotation_clip=False, **beside)
        axes.set_ylim(0, 1.1 * float(np.nanmax(frequencies, initial=0.0)) or 1.0)
        axes.set_xlabel(labelled("speed", unit))
        axes.set_ylabel(labelled("frequency in turning axes", unit))
        return save_figure(figure, path)
