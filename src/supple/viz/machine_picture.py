"""A machine at one instant: its elastic bodies by their meshes, everything else by glyphs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UNNAMED, UnitSystem
from supple.viz.glyphs import Glyphs
from supple.viz.mesh_plot import NodalField, draw_surface
from supple.viz.style import save_figure, textbook_style

__all__ = ["plot_machine"]

Array = NDArray[np.float64]


def plot_machine(
    path: Path | str,
    nodes: Array,
    skin: Skin | None,
    glyphs: Glyphs,
    *,
    colour_by: NodalField | None = None,
    undeformed: Array | None = None,
    camera: Camera | None = None,
    title: str = "",
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw bodies and glyphs in space, lengths true to scale, with an axis cross, a length bar and a legend.

    Parameters
    ----------
    nodes : array (N, 3)            of the skin, at one instant; (0, 3) without one
    glyphs : Glyphs                 of that instant
    colour_by : NodalField          colours and colour bar; one plain colour without
    undeformed : array (N, 3)       its outline is drawn pale, behind
    camera : Camera                 a three-quarter view by default
    units : UnitSystem              what the length bar is in

    Raises
    ------
    ModelError          nothing to draw
    ResultFileError     the file cannot be written
    """
    if skin is None and glyphs.is_empty:
        raise ModelError(f"cannot draw {path}: give a skin, or glyphs")
    with textbook_style():
        figure, _, _ = draw_surface(
            nodes,
            skin,
            colour_by=colour_by,
            undeformed=undeformed,
            glyphs=glyphs,
            camera=camera,
            title=title,
            units=units,
        )
        return save_figure(figure, path)
