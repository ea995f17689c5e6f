"""Pictures of mode shapes, or of other displacement fields, with titles, in a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UNNAMED, UnitSystem, plain_number, with_unit
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.mesh_plot import BAR_GAP, check_positions, draw_cross, draw_outline
from supple.viz.shaded_surface import page_around, render, show
from supple.viz.style import COLOUR_MAP, TEXT_WIDTH, new_figure, save_figure, textbook_style

__all__ = ["mode_titles", "plot_mode_shapes"]


_PIXELS_PER_INCH = 200


def mode_titles(frequencies: FloatArray, units: UnitSystem = UNNAMED) -> list[str]:
    """Titles such as "mode 1:  0.675 Hz", for frequencies (m,) in cycles per unit of time."""
    unit, factor = units.frequency_shown
    return [
        with_unit(f"mode {i}:  {plain_number(factor * frequency)}", unit)
        for i, frequency in enumerate(frequencies, start=1)
    ]


def plot_mode_shapes(
    path: Path | str,
    nodes: FloatArray,
    skin: Skin,
    modes: FloatArray,
    titles: Sequence[str],
    *,
    title: str = "",
    n_columns: int = 2,
    amplitude: float = 0.1,
    glyphs: Callable[[FloatArray], Glyphs | None] = lambda _: None,
    camera: Camera | None = None,
) -> Path:
    """Draw modes in rows of n_columns, coloured by their displacements, over the outline of the body at rest.

    The largest displacement as drawn is written above the pictures.

    Parameters
    ----------
    nodes : array (N, 3)            at rest
    modes : array (m, N, 3)         displacements of any scale
    titles : str, one per mode      such as those of `mode_titles`
    title : str                     common title, such as the support of the body
    amplitude : float               largest displacement drawn, as a share of the body's diagonal
    glyphs : callable               glyphs for positions (m, N, 3), drawn with each mode
    camera : Camera                 a three-quarter view by default

    Raises
    ------
    ModelError          arrays of wrong shapes, a mode without displacement or not finite, n_columns below one
    ResultFileError     the file cannot be written
    """
    check_positions(nodes, skin)
    length = _checked_lengths(nodes, modes, titles, n_columns)
    largest = length.max(axis=1)
    camera = camera or Camera.three_quarter(nodes)
    reach = amplitude * np.linalg.norm(np.ptp(nodes, axis=0))
    shapes = nodes + modes * (reach / largest)[:, None, None]

    beside = glyphs(shapes)
    n_columns = min(n_columns, len(modes))
    n_rows = -(-len(modes) // n_columns)
    cell = TEXT_WIDTH / n_columns
    margin = 0.04 if beside is None else 0.08  # marks extend beyond their points
    everything = camera.project(np.concatenate([nodes[None], shapes]))[0]
    page = page_around(everything, round(cell * _PIXELS_PER_INCH), margin=margin, least_aspect=0.2)
    colours = ScalarMappable(Normalize(0.0, 1.0), COLOUR_MAP)
    with textbook_style():
        height = n_rows * (cell * page.n_rows / page.n_columns + 0.22)
        figure = new_figure(height + 0.9)
        grid = figure.subplots(n_rows, n_columns, squeeze=False).ravel()
        for i, (axes, shape, name) in enumerate(zip(grid, shapes, titles, strict=False)):
            draw_outline(axes, nodes, skin, camera)
            show(axes, render(shape, skin, camera, page, length[i] / largest[i], colours), page)
            if beside is not None:
                DrawnGlyphs(axes, beside, camera).show(i)
            axes.set_title(name, fontsize=8.5, pad=2.0)
        for axes in grid[len(modes) :]:
            axes.set_axis_off()
        corner = figure.add_axes((0.0, 0.0, 1.0, 1.0), zorder=-1.0)
        corner.set_axis_off()
        draw_cross(corner, camera)
        figure.colorbar(
            colours,
            ax=list(grid),
            location="bottom",
            label="displacement, share of the largest",
            shrink=0.4,
            aspect=30,
            pad=BAR_GAP / height,
        )
        drawn = f"largest displacement drawn as {100 * amplitude:.3g} % of the size"
        figure.suptitle(f"{title}; {drawn}" if title else drawn, fontsize=9.0)
        return save_figure(figure, path)


def _checked_lengths(
    nodes: FloatArray, modes: FloatArray, titles: Sequence[str], n_columns: int
) -> FloatArray:
    """The displacement magnitudes (m, N) of modes; ModelError for modes that cannot be drawn."""
    if modes.ndim != 3 or not len(modes) or modes.shape[1:] != nodes.shape or len(titles) != len(modes):
        raise ModelError(
            f"cannot draw modes of shape {modes.shape} with {len(titles)} titles over nodes "
            f"of shape {nodes.shape}; give (m, N, 3) and one title each"
        )
    if n_columns < 1:
        raise ModelError(f"mode shapes: n_columns is {n_columns}; give at least one")
    length = np.linalg.norm(modes, axis=2)
    largest = length.max(axis=1)
    drawable = np.isfinite(largest) & (largest > 0.0)
    if not drawable.all():
        raise ModelError(f"mode {int(np.argmin(drawable)) + 1} has no finite displacement to draw")
    return length
