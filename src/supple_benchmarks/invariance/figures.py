"""Figure of the invariance benchmark: error against the rotation of the tip, for one and several bodies."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes

from supple.viz.style import Stroke, draw_curve, new_figure, save_figure, textbook_style
from supple_benchmarks.table import Report, Row

__all__ = ["draw_figures"]

_POINTS = Stroke(marker="o")


def draw_figures(report: Report, folder: Path) -> list[Path]:
    """Draw the error of the split strips against the rotation of the tip; return the path in a list."""
    folder.mkdir(parents=True, exist_ok=True)
    with textbook_style():
        figure = new_figure(2.6)
        left, right = figure.subplots(1, 2, sharey=True)
        for axes, frame in ((left, "nodal-fixed"), (right, "mean-axis")):
            _draw_frame(axes, frame, [row for row in report["split"] if row["frame"] == frame])
        left.set_ylabel("error of the tip / its deflection")
        right.legend(title="bodies")
        return [save_figure(figure, folder / "bending_error.png")]


def _draw_frame(axes: Axes, frame: str, rows: list[Row]) -> None:
    for rank, k in enumerate(sorted({row["k"] for row in rows})):
        own = [row for row in rows if row["k"] == k]
        x, y = [row["tip_rotation"] for row in own], [row["error"] for row in own]
        draw_curve(axes, x, y, _POINTS, rank, str(k))
    axes.set_yscale("log")
    axes.set_title(f"{frame} frames", loc="left")
    axes.set_xlabel("rotation of the tip, rad")
