"""Figures of the intrinsic benchmark: comparison of four methods, box beam and U of [Wang2015]."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from supple.viz.style import Stroke, draw_curve, new_figure, save_figure, textbook_style
from supple_benchmarks.intrinsic.box_figures import draw_box
from supple_benchmarks.intrinsic.u_figures import draw_u
from supple_benchmarks.table import Report, Row

__all__ = ["draw_figures"]

_POINTS = Stroke(marker="o")


def draw_figures(report: Report, folder: Path) -> list[Path]:
    """Draw all figures; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    return [
        _which_method_when(report, folder),
        *draw_box(report["box_beam"], folder),
        *draw_u(report["u_beam"], folder),
    ]


def _which_method_when(report: Report, folder: Path) -> Path:
    """Error and processor time of the strip by four methods, against the rotation of its tip."""
    rows = [row for row in report["agreement"] if row["body"] == "strip"]
    with textbook_style():
        figure = new_figure(2.6)
        left, right = figure.subplots(1, 2)
        _draw(left, rows, "error")
        left.set_ylabel("error of the tip / its deflection")
        _draw(right, rows, "seconds")
        right.set_ylabel("processor time, s")
        right.legend()
        return save_figure(figure, folder / "which_method_when.png")


def _draw(axes: Axes, rows: list[Row], what: str) -> None:
    for rank, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        own = [row for row in rows if row["method"] == method]
        x = np.array([row["tip_rotation"] for row in own])
        y = np.array([np.nan if row["error"] is None else row[what] for row in own], dtype=float)
        draw_curve(axes, x, y, _POINTS, rank, method)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("rotation of the tip, rad")
