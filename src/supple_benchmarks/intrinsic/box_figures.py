"""Figures of the box beam: modes along its length, and a large vibration; [Wang2015] Figs. 3-5, 7 and 8."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from supple.viz.style import (
    REFERENCE,
    SOLID,
    Stroke,
    draw_curve,
    legend_above,
    new_figure,
    save_figure,
    textbook_style,
)
from supple_benchmarks.intrinsic.slender_box import LENGTH, slender_mode
from supple_benchmarks.table import Report

__all__ = ["draw_box"]

_QUANTITIES = ("velocity", "moment", "curvature")
_COMPONENTS = {"flapwise": ("v_z", "m_y", "\\kappa_y"), "torsion": ("w_x", "m_x", "\\kappa_x")}
_DASHED = Stroke(colour=REFERENCE.colour, dashes=REFERENCE.dashes, width=0.8)


def draw_box(report: Report, folder: Path) -> list[Path]:
    """Draw both figures; return their paths."""
    with textbook_style():
        return [
            _draw_modes(report["modes"], folder / "figure_3_to_5_box_modes.png"),
            _draw_vibration(report, folder / "figure_8_box_vibration.png"),
        ]


def _draw_modes(study: Report, path: Path) -> Path:
    """One row of panels per kind of mode: velocity, moment, curvature; dashed: modes of the slender beam."""
    figure = new_figure(4.3)
    grid = figure.subplots(2, 3, sharex=True)
    stations = np.array(study["s"])
    fine = np.linspace(0.0, LENGTH, 201)
    for row, (kind, components) in zip(grid, _COMPONENTS.items(), strict=True):
        own = [mode for mode in study["modes"] if mode["kind"] == kind]
        for axes, what, component, rank in zip(row, _QUANTITIES, components, range(3), strict=True):
            for mode in own:
                beam = slender_mode(kind, mode["rank"], fine)
                values = np.array(mode[what])
                s = stations if what == "velocity" else 0.5 * (stations[1:] + stations[:-1])
                draw_curve(axes, s, values, SOLID, mode["rank"], f"mode {mode['rank'] + 1}")
                sign = np.sign(beam[0][-1])
                label = "" if mode["rank"] else "slender beam"
                draw_curve(axes, fine / LENGTH, sign * beam[rank], _DASHED, 0, label)
            axes.set_title(f"{what} ${component}$")
        row[0].set_ylabel(kind)
    for axes in grid[1]:
        axes.set_xlabel("s / L")
    handles, labels = grid[0][0].get_legend_handles_labels()
    named = dict(sorted(zip(labels, handles, strict=True)))
    figure.legend(named.values(), named.keys(), loc="outside upper center", ncols=len(named))
    return save_figure(figure, path)


def _draw_vibration(report: Report, path: Path) -> Path:
    """Displacement of the tip in the upper panel, the largest modal amplitudes in the lower one."""
    figure = new_figure(4.6)
    upper, lower = figure.subplots(2, 1, sharex=True)
    times, tip = np.array(report["tip"]["t"]), np.array(report["tip"]["u"])
    for rank, name in enumerate("xyz"):
        draw_curve(upper, times, tip[:, rank] / LENGTH, SOLID, rank, f"along {name}")
    upper.set_ylabel("tip / length")
    legend_above(upper)
    for rank, one in enumerate(report["amplitudes"]):
        draw_curve(lower, times, np.array(one["q2"]), SOLID, rank, f"{one['mode']}, {one['kind']}")
    lower.set_ylabel("amplitude $q_2$")
    lower.set_xlabel("time")
    legend_above(lower)
    return save_figure(figure, path)
