"""Plot of a Campbell diagram: frequencies over speed, and lines of the multiples of the speed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.linearization import CampbellDiagram
from supple.linearization.linear_machine import STANDING
from supple.units import UNNAMED, UnitSystem, labelled, plain_number
from supple.viz.style import COLOURS, TEXT_WIDTH, new_figure, save_figure, textbook_style

__all__ = ["plot_campbell"]


N_ORDERS = 4
"""Number of multiples of the speed to draw."""
_LINE = 0.032
"""Height of the name of a mode, as a share of the height of the diagram."""


@checked_arguments
def plot_campbell(path: Path | str, diagram: CampbellDiagram, *, units: UnitSystem = UNNAMED) -> Path:
    """Draw named frequencies over speed, the multiples of the speed that excite them, and critical speeds.

    In turning axes a second diagram, above, has the whirls as they are seen in space.

    Raises ResultFileError where the file cannot be written.
    """
    unit, factor = units.frequency_shown
    factor /= 2 * np.pi
    shown, by_rate = units.rotation_shown
    rates = np.asarray(diagram.rates)
    panels = [(np.asarray(diagram.frequencies), f"frequency in axes {diagram.axes}")]
    if diagram.axes != STANDING and np.any(diagram.sense):
        whirls = np.where(np.any(diagram.sense, axis=0), diagram.in_space, np.nan)
        panels.insert(0, (whirls, "whirl frequency in space"))
    with textbook_style():
        figure = new_figure(0.7 * len(panels) * TEXT_WIDTH)
        for axes, (frequencies, label) in zip(
            figure.subplots(len(panels), squeeze=False).flat, panels, strict=True
        ):
            shown_frequencies = factor * frequencies
            top = 1.1 * float(np.nanmax(shown_frequencies, initial=0.0)) or 1.0
            axes.set_ylim(0, top)
            _draw_orders(axes, by_rate * rates, factor * abs(rates), top)
            _draw_modes(axes, by_rate * rates, shown_frequencies, diagram.names, top)
            for critical in diagram.critical_speeds:
                speed = by_rate * critical.rate
                axes.axvline(speed, color="0.5", linewidth=0.7, linestyle=":")
                words = f"critical, {plain_number(speed, 4)} {shown}"
                axes.annotate(words, (speed, 0.98 * top), rotation=90, va="top", ha="right", fontsize=6)
            axes.set_xlabel(labelled("speed", shown))
            axes.set_ylabel(labelled(label, unit))
        return save_figure(figure, path)


def _draw_orders(axes: Axes, speeds: FloatArray, orders: FloatArray, top: float) -> None:
    """Multiples of the speed, with their names, on the branch of the fastest rotation."""
    slow, fast = np.argmin(orders), np.argmax(orders)
    ascending = np.argsort(speeds)
    for order in range(1, N_ORDERS + 1):
        axes.plot(speeds, order * orders, color="0.7", linewidth=0.7)
        # Names side by side in the middle of the diagram; the right edge has the names of the modes.
        place = min(0.15 * (order + 1), 0.9 * top / max(order * orders[fast], 1e-300))
        x = (1 - place) * speeds[slow] + place * speeds[fast]
        y = np.interp(x, speeds[ascending], order * orders[ascending])
        on_line = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
        axes.annotate(
            f"{order}P", (x, y), color="0.4", fontsize=7, ha="center", va="center", bbox=on_line, zorder=2.2
        )


def _draw_modes(
    axes: Axes, speeds: FloatArray, frequencies: FloatArray, names: Sequence[str], top: float
) -> None:
    """Curves of the frequencies (ns, nm), with the name of each mode at the end of its curve."""
    followed = [
        (name, mode, int(known[-1]), COLOURS[number % len(COLOURS)])
        for number, (name, mode) in enumerate(zip(names, frequencies.T, strict=True))
        if len(known := np.flatnonzero(np.isfinite(mode)))
    ]
    heights = _apart(np.array([mode[end] for _, mode, end, _ in followed]), top)
    for (name, mode, end, colour), height in zip(followed, heights.tolist(), strict=True):
        axes.plot(speeds, mode, marker="o", markersize=2.5, color=colour, zorder=2.5)  # over names of orders
        axes.annotate(
            name,
            (speeds[end], height),
            annotation_clip=False,
            color=colour,
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
        )


def _apart(heights: FloatArray, top: float) -> FloatArray:
    """Heights (n,) at which names do not overlap: shifted up where necessary, then down below the top."""
    order = np.argsort(heights, kind="stable")
    least = np.arange(len(heights)) * _LINE * top
    placed = np.maximum.accumulate(heights[order] - least) + least
    highest = top - least[::-1]
    found = np.empty_like(heights)
    found[order] = np.minimum(placed, highest)
    return found
