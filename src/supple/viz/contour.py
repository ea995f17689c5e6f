"""Contours of a field on a body: colour bands, a colour bar, and a mark at the largest value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import MaxNLocator

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UNNAMED, UnitSystem, labelled
from supple.viz.glyphs import Glyphs
from supple.viz.mesh_plot import N_COLUMNS, NodalField, check_positions, checked_values, draw_surface
from supple.viz.shaded_surface import PixelWindow, is_seen
from supple.viz.style import COLOUR_MAP, INK, save_figure, textbook_style

__all__ = ["plot_contour", "stress_field"]


def stress_field(stress: FloatArray, units: UnitSystem = UNNAMED) -> NodalField:
    """Field of von Mises stresses (N,), converted to MPa or psi; not converted if the units have no names."""
    unit, factor = units.stress_shown
    return NodalField(labelled("von Mises stress", unit), factor * np.asarray(stress))


def plot_contour(
    path: Path | str,
    nodes: FloatArray,
    skin: Skin,
    field: NodalField,
    *,
    n_bands: int = 10,
    node_ids: IntArray | None = None,
    undeformed: FloatArray | None = None,
    glyphs: Glyphs | None = None,
    camera: Camera | None = None,
    title: str = "",
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw a field in colour bands on a body, deformed or not, with a mark at its largest value.

    The limits of the bands are round numbers. Colour bar and mark refer to nodes of the skin only, not to
    interior nodes. The label of a mark on the far side of the body contains "on the far side".

    Parameters
    ----------
    nodes : array (N, 3)            positions to draw
    field : NodalField              such as `stress_field(modes.von_mises(gamma))`
    n_bands : int                   largest number of bands, at least 2
    node_ids : int array (N,)       labels of the nodes, such as `mesh.node_ids`; default: the node numbers
    skin, undeformed, glyphs, camera, title, units : as for `plot_mesh`

    Raises
    ------
    ModelError          as for `plot_mesh`; fewer than two bands
    ResultFileError     the file cannot be written
    """
    if n_bands < 2:
        raise ModelError(f"contour of '{field.label}': {n_bands} bands; give at least 2")
    check_positions(nodes, skin)
    seen = np.unique(skin.triangles)
    seen = seen[np.isfinite(checked_values(field, len(nodes))[seen])]
    if not len(seen):
        raise ModelError(f"contour of '{field.label}': no node of the skin has a value")
    values = field.values[seen]
    with textbook_style():
        figure, axes, camera = draw_surface(
            nodes,
            skin,
            colour_by=field,
            undeformed=undeformed,
            glyphs=glyphs,
            camera=camera,
            title=title,
            units=units,
            scale=_bands(float(values.min()), float(values.max()), n_bands),
        )
        node = int(seen[values.argmax()])
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        page = PixelWindow(np.array([left, bottom]), np.array([right, top]), N_COLUMNS)
        name = node if node_ids is None else int(node_ids[node])
        hidden = not is_seen(nodes, skin, camera, page, node)
        words = f"largest {field.values[node]:.4g}, node {name}{' on the far side' if hidden else ''}"
        _mark(axes, page, camera.project(nodes[node])[0], words, dashed=hidden)
        return save_figure(figure, path)


def _bands(low: float, high: float, n_bands: int) -> ScalarMappable:
    # A uniform field still needs a band of finite width.
    width = high - low if high > low else max(abs(high), 1.0)
    edges = MaxNLocator(n_bands, steps=[1, 2, 2.5, 5, 10], min_n_ticks=2).tick_values(low, low + width)
    return ScalarMappable(BoundaryNorm(edges, colormaps[COLOUR_MAP].N), COLOUR_MAP)


def _mark(axes: Axes, page: PixelWindow, place: FloatArray, words: str, *, dashed: bool) -> None:
    """Draw a ring around a place (2,); beside it, towards the middle of the picture, a text."""
    line = "dashed" if dashed else "solid"
    axes.scatter(*place, s=49.0, facecolors="none", edgecolors=INK, linestyles=line, zorder=4.0)
    rightwards, upwards = place < 0.5 * (page.low + page.high)
    axes.annotate(
        words,
        (place[0], place[1]),
        xytext=(9.0 if rightwards else -9.0, 12.0 if upwards else -12.0),
        textcoords="offset points",
        ha="left" if rightwards else "right",
        va="bottom" if upwards else "top",
        fontsize=7.5,
        bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.5},
        zorder=4.0,
    )
