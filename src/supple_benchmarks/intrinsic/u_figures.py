"""Figures of the U: stiffness, eigenvalues, errors and steps, flight; [Wang2015] Figs. 12-17."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from supple.results.camera import Camera
from supple.viz.mesh_plot import draw_cross
from supple.viz.style import (
    COLOUR_MAP,
    COLOURS,
    REFERENCE,
    SOLID,
    Stroke,
    draw_curve,
    new_figure,
    save_figure,
    textbook_style,
)
from supple_benchmarks.table import Report

__all__ = ["draw_u"]

_POINTS = Stroke(marker="o")
_THIN = Stroke(width=0.9, marker=".")
_DASHED = Stroke(colour=REFERENCE.colour, dashes=REFERENCE.dashes, width=0.8)
_CAMERA = Camera.looking(along=(-0.5, 1.0, -0.45), up=(0.0, 0.0, 1.0))


def draw_u(report: Report, folder: Path) -> list[Path]:
    """Draw all four figures; return their paths."""
    with textbook_style():
        return [
            _draw_pattern(report["stiffness"], folder / "figure_12_u_stiffness.png"),
            _draw_eigenvalues(report["eigenvalues"], folder / "figure_13_u_eigenvalues.png"),
            _draw_errors(report, folder / "figure_14_15_u_errors.png"),
            _draw_flight(report["flight"], folder / "figure_16_17_u_flight.png"),
        ]


def _draw_pattern(patterns: Report, path: Path) -> Path:
    """Largest stiffness entry of each pair of stations: left beam elements, right the condensed solid."""
    figure = new_figure(3.1)
    grid = figure.subplots(1, 2, sharey=True)
    image = None
    for axes, key, title in zip(
        grid, ("beam_elements", "stations"), ("beam elements", "condensed solid"), strict=True
    ):
        image = axes.imshow(
            np.array(patterns[key], dtype=float), cmap=COLOUR_MAP, vmin=-10, vmax=0, interpolation="nearest"
        )
        axes.set_title(title)
        axes.set_xlabel("station")
        axes.grid(visible=False)
    grid[0].set_ylabel("station")
    assert image is not None
    figure.colorbar(image, ax=grid, label="log10 of stiffness / largest", shrink=0.85)
    return save_figure(figure, path)


def _draw_eigenvalues(differences: Report, path: Path) -> Path:
    """Relative differences of eigenvalues.

    Left: each line of stations compared with the solid. Right: the line with the most stations compared with
    beam elements, and beam elements compared with the solid.
    """
    figure = new_figure(3.2)
    left, right = figure.subplots(1, 2, sharey=True)
    for rank, (n, values) in enumerate(differences["stations"].items()):
        _draw_differences(left, values, rank, f"{n} stations")
    finest = list(differences["stations"])[-1]
    _draw_differences(right, differences["beside_beam_elements"], 0, f"{finest} stations compared with beams")
    _draw_differences(right, differences["beam_elements"], 1, "beams compared with the solid")
    left.set_title("compared with the solid")
    right.set_title("with beam elements")
    left.set_ylabel("difference of the eigenvalue")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xlabel("elastic eigenvalue")
        axes.legend(loc="lower right", fontsize=7.0)
    return save_figure(figure, path)


def _draw_differences(axes: Axes, values: list[float], rank: int, label: str) -> None:
    draw_curve(axes, np.arange(1, len(values) + 1), np.abs(values), _THIN, rank, label)


def _draw_errors(report: Report, path: Path) -> Path:
    """Error of the centre of mass by segments; errors by retained modes; longest stable step."""
    figure = new_figure(2.7)
    first, second, third = figure.subplots(1, 3)
    errors = report["com_error"]
    segments = np.array([int(n) - 1 for n in errors])
    values = np.array(list(errors.values()))
    draw_curve(first, segments, values, _POINTS, 0, "stations")
    draw_curve(first, segments, values[0] * (segments[0] / segments) ** 2, REFERENCE, 0, "second order")
    first.set_xlabel("segments")
    first.set_title("centre of mass, m")
    first.set_xscale("log")
    first.set_xticks(segments, [str(n) for n in segments])
    first.xaxis.set_minor_locator(NullLocator())
    rows = report["residualised"]
    kept = [row["kept"] for row in rows]
    for rank, (key, label) in enumerate(
        {"truncated_error": "truncated", "residualised_error": "residual"}.items()
    ):
        draw_curve(second, kept, [row[key] for row in rows], _POINTS, rank, label)
    second.set_xlabel("modes kept")
    second.set_title("stations' places, m")
    steps = report["stable_steps"]
    whole = steps[-1]["dt_max"]
    kept = [row["kept"] for row in steps]
    draw_curve(third, kept, [row["dt_max"] / whole for row in steps], _POINTS, 0, "")
    third.set_xlabel("modes kept")
    third.set_title("longest step, relative")
    for axes in (first, second, third):
        axes.set_yscale("log")
    first.legend()
    second.legend()
    return save_figure(figure, path)


def _draw_flight(flight: Report, path: Path) -> Path:
    """Snapshots to scale, and the displacement of the loaded tip over time; dashed: beam elements."""
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=(1.35, 1.0))
    own, beams = flight["stations"], flight["beam_elements"]
    for rank, (time, places) in enumerate(zip(own["snapshot_t"], own["snapshots"], strict=True)):
        plane = _CAMERA.project(np.array(places))[0]
        draw_curve(left, plane[:, 0], plane[:, 1], SOLID, rank, f"{time:.3g} s")
        left.plot(*plane[0], "o", color=COLOURS[rank % len(COLOURS)], markersize=4.0)
    for places in beams["snapshots"]:
        plane = _CAMERA.project(np.array(places))[0]
        draw_curve(left, plane[:, 0], plane[:, 1], _DASHED, 0, "")
    left.set_aspect("equal")
    low, high = left.get_ylim()
    left.set_ylim(low - 0.3 * (high - low), high)  # room for the cross of axes
    left.set_axis_off()
    left.legend(loc="upper left", fontsize=7.0)
    draw_cross(left, _CAMERA)
    start = np.array(own["tip"][0])
    for rank, name in enumerate("xyz"):
        draw_curve(right, own["t"], np.array(own["tip"])[:, rank] - start[rank], SOLID, rank, name)
    for rank in range(3):
        moved = np.array(beams["tip"])[:, rank] - start[rank]
        draw_curve(right, beams["t"], moved, _DASHED, 0, "" if rank else "beam elements")
    right.set_xlabel("time, s")
    right.set_ylabel("displacement of the tip, m")
    right.legend()
    return save_figure(figure, path)
