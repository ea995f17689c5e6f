"""Pictures of a body: its surface, plain or coloured by a field, undeformed or deformed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D, Affine2DBase, ScaledTranslation, Transform

from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.mesh.feature_edges import feature_edges, silhouette_edges
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UNNAMED, UnitSystem, labelled, with_unit
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.shaded_surface import PixelWindow, page_around, render, show
from supple.viz.style import (
    COLOUR_MAP,
    INK,
    PALE_INK,
    SURFACE_COLOUR,
    TEXT_WIDTH,
    new_figure,
    save_figure,
    textbook_style,
)

__all__ = ["NodalField", "displacement_magnitude", "plot_mesh"]


N_COLUMNS = 1260
BAR_GAP = 0.15
"""Distance between a picture and its colour bar, in inches."""
_CORNER = 0.1
"""Side of the square of the axis cross, as a fraction of the width of a picture."""
_ARROW = {
    "arrowstyle": "-|>",
    "mutation_scale": 6.0,
    "linewidth": 0.9,
    "color": INK,
    "shrinkA": 0.0,
    "shrinkB": 0.0,
}


@dataclass(frozen=True, eq=False)
class NodalField:
    """Nodal values that colour a body.

    label : name of the values, with unit
    values : (N,), NaN at nodes without a value
    """

    label: str
    values: FloatArray


def displacement_magnitude(displacements: FloatArray, units: UnitSystem = UNNAMED) -> NodalField:
    """Field of the magnitudes of nodal displacements (N, 3)."""
    return NodalField(labelled("displacement", units.length), np.linalg.norm(displacements, axis=1))


def plot_mesh(
    path: Path | str,
    nodes: FloatArray,
    skin: Skin | None,
    *,
    colour_by: NodalField | None = None,
    undeformed: FloatArray | None = None,
    glyphs: Glyphs | None = None,
    camera: Camera | None = None,
    title: str = "",
    units: UnitSystem = UNNAMED,
) -> Path:
    """Draw the shaded surface of a body, true to scale, with an axis cross and a length bar.

    Parameters
    ----------
    nodes : array (N, 3)            positions to draw, deformed or not
    skin : Skin                     visible surface of the mesh; None, with nodes (0, 3): glyphs alone
    colour_by : NodalField          values for colours and a colour bar; None: one plain colour
    undeformed : array (N, 3)       positions of the nodes for a pale outline behind the body
    glyphs : Glyphs                 symbols of rigid bodies, joints, springs, ties and masses, at one time
    camera : Camera                 by default a three-quarter view
    units : UnitSystem              units for the label of the length bar

    Raises
    ------
    ModelError          neither skin nor glyphs, an array of wrong shape, a position or value that is not
                        finite, a node of the skin without a position
    ResultFileError     the file cannot be written
    """
    if skin is None and (glyphs is None or glyphs.is_empty):
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


def draw_surface(
    nodes: FloatArray,
    skin: Skin | None,
    *,
    colour_by: NodalField | None,
    undeformed: FloatArray | None,
    glyphs: Glyphs | None,
    camera: Camera | None,
    title: str,
    units: UnitSystem,
    scale: ScalarMappable | None = None,
) -> tuple[Figure, Axes, Camera]:
    """Draw the picture of `plot_mesh` without saving it; for use inside `textbook_style`.

    scale : ScalarMappable      mapping of values to colours; by default over the whole range of the field
    """
    for each in (nodes, undeformed):
        if skin is not None and each is not None:
            check_positions(each, skin)
    rest = nodes if undeformed is None else undeformed
    seen = [nodes, rest] if glyphs is None else [nodes, rest, glyphs.points[0]]
    camera = camera or Camera.three_quarter(np.concatenate(seen[1:]))
    margin = 0.04 if glyphs is None else 0.08  # symbols extend beyond their points
    plane = camera.project(np.concatenate(seen))[0]
    page = _with_free_corners(page_around(plane, N_COLUMNS, margin=margin), plane)
    height = TEXT_WIDTH * page.n_rows / page.n_columns
    legend = 0.3 * (0 if glyphs is None else glyphs.legend_rows)
    figure = new_figure(height + 0.7 * (colour_by is not None) + 0.3 * bool(title) + legend)
    axes = figure.subplots()
    values, colours = None, scale or ScalarMappable(cmap=COLOUR_MAP)
    colours.set_cmap(colours.get_cmap().with_extremes(bad=SURFACE_COLOUR))
    if colour_by is not None:
        values = checked_values(colour_by, len(nodes))
        if scale is None:
            colours.set_norm(Normalize(np.nanmin(values), np.nanmax(values)))
        pad = BAR_GAP / height
        figure.colorbar(
            colours, ax=axes, location="bottom", label=colour_by.label, shrink=0.5, aspect=30, pad=pad
        )
    picture = np.zeros((page.n_rows, page.n_columns, 4))
    if skin is not None:
        picture = render(nodes, skin, camera, page, values, colours)
        if undeformed is not None:
            draw_outline(axes, undeformed, skin, camera)
    show(axes, picture, page)
    if glyphs is not None:
        DrawnGlyphs(axes, glyphs, camera).legend(figure)
    draw_cross(axes, camera)
    draw_length_bar(axes, page, units)
    axes.set_title(title)
    return figure, axes, camera


def _with_free_corners(page: PixelWindow, plane: FloatArray) -> PixelWindow:
    """The page, extended at the bottom if points (n, 2) lie where axis cross or length bar are drawn."""
    width = page.high[0] - page.low[0]
    right, up = ((plane - page.low) / width).T
    if not np.any((up < _CORNER) & ((right < _CORNER) | (right > 1.0 - 2.0 * _CORNER))):
        return page
    return PixelWindow(page.low - np.array([0.0, _CORNER * width]), page.high, page.n_columns)


def check_positions(nodes: FloatArray, skin: Skin) -> None:
    """Raise ModelError if positions are not (N, 3) and finite, or if a node of the skin has none."""
    if nodes.ndim != 2 or nodes.shape[1] != 3:
        raise ModelError(f"cannot draw positions of shape {nodes.shape}: give (N, 3)")
    if skin.triangles.min() < 0 or skin.triangles.max() >= len(nodes):
        raise ModelError(
            f"cannot draw a skin of nodes {skin.triangles.min()} to {skin.triangles.max()}: "
            f"there are {len(nodes)} positions"
        )
    finite = np.isfinite(nodes).all(axis=1)
    if not finite.all():
        raise ModelError(f"cannot draw: node {int(np.argmin(finite))} is not at a finite position")


def draw_outline(axes: Axes, nodes: FloatArray, skin: Skin, camera: Camera) -> None:
    """Draw rims, folds and silhouette of a surface as pale lines."""
    plane, _ = camera.project(nodes)
    towards = camera.axes[2]
    edges = np.concatenate(
        [feature_edges(nodes, skin.triangles), silhouette_edges(nodes, skin.triangles, towards)]
    )
    axes.add_collection(
        LineCollection(list(plane[edges]), colors=PALE_INK, linewidths=0.5, zorder=1.0), autolim=False
    )


def draw_cross(axes: Axes, camera: Camera) -> None:
    """Draw the directions of x, y and z as a small cross in the lower left corner."""
    cross = axes.inset_axes((0.0, 0.0, 1.0, 1.0), transform=_corner(axes, 44.0), zorder=3.0)
    cross.set_aspect("equal")
    cross.set_xlim(-1.6, 1.6)
    cross.set_ylim(-1.6, 1.6)
    cross.set_axis_off()
    tips, _ = camera.project(np.eye(3))
    for tip, name in zip(tips, "xyz", strict=True):
        # An axis towards the viewer is left out: its name would cover the other names.
        if np.hypot(*tip) > 0.15:
            cross.annotate("", tip, (0.0, 0.0), arrowprops=_ARROW)
            cross.text(1.35 * tip[0], 1.35 * tip[1], name, ha="center", va="center", fontsize=7.5)


def draw_length_bar(axes: Axes, page: PixelWindow, units: UnitSystem) -> None:
    """Draw a bar of round length, at most a sixth of the width of the page, in the lower right corner."""
    width, height = page.high - page.low
    length = _round_length(width / 6.0)
    right, bottom = page.high[0] - 0.02 * width, page.low[1] + 0.03 * height
    axes.plot([right - length, right], [bottom, bottom], color=INK, linewidth=1.5, zorder=3.0)
    axes.annotate(
        with_unit(f"{length:g}", units.length),
        (right - 0.5 * length, bottom),
        xytext=(0.0, 2.5),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=7.5,
        zorder=3.0,
    )


def _corner(axes: Axes, size: float) -> Transform:
    """Transform of the unit square to a square in the lower left corner of the axes; size: side in points."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    lower_left = ScaledTranslation(0.0, 0.0, cast(Affine2DBase, axes.transAxes))
    return Affine2D().scale(size / 72.0) + figure.dpi_scale_trans + lower_left


def _round_length(length: float) -> float:
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9)))


def checked_values(field: NodalField, n_nodes: int) -> FloatArray:
    """The values of a field; ModelError unless there is one per node, finite or NaN."""
    values = np.asarray(field.values, dtype=float)
    if values.shape != (n_nodes,) or np.isinf(values).any() or np.isnan(values).all():
        raise ModelError(
            f"field '{field.label}' of shape {values.shape}: give a finite value at each of {n_nodes} nodes, "
            "or NaN at nodes without a value"
        )
    return values
