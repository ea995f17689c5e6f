"""A machine at one instant: its elastic bodies by their meshes, everything else by glyphs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UNNAMED, UnitSystem
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.mesh_plot import N_COLUMNS, draw_cross, draw_length_bar
from supple.viz.shaded_surface import page_around, render, show
from supple.viz.style import TEXT_WIDTH, new_figure, save_figure, textbook_style

__all__ = ["plot_machine"]

Array = NDArray[np.float64]


def plot_machine(
    path: Path | str,
    nodes: Array,
    skin: Skin | None,
    glyphs: Glyphs,
    *,
    camera: Camera | None = None,
    title: str = "",
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw bodies and glyphs in space, lengths true to scale, with an axis cross, a length bar and a legend.

    Parameters
    ----------
    nodes : array (N, 3)        of the skin, at one instant; (0, 3) without one
    glyphs : Glyphs             of that instant
    camera : Camera             a three-quarter view by default
    units : UnitSystem          what the length bar is in

    Raises
    ------
    ModelError          nothing to draw
    ResultFileError     the file cannot be written
    """
    if skin is None and glyphs.is_empty:
        raise ModelError(f"cannot draw {path}: give a skin, or glyphs")
    everything = np.concatenate([nodes, glyphs.points[0]])
    camera = camera or Camera.three_quarter(everything)
    page = page_around(camera.project(everything)[0], N_COLUMNS, margin=0.08)
    with textbook_style():
        figure = new_figure(TEXT_WIDTH * page.n_rows / page.n_columns + 0.5 + 0.3 * bool(title))
        axes = figure.subplots()
        empty = np.zeros((page.n_rows, page.n_columns, 4))
        show(axes, empty if skin is None else render(nodes, skin, camera, page), page)
        drawn = DrawnGlyphs(axes, glyphs, camera)
        drawn.legend(axes)
        draw_cross(axes, camera)
        draw_length_bar(axes, page, units)
        axes.set_title(title)
        return save_figure(figure, path)
