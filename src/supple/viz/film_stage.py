"""The stage of an animation: what stands still is drawn once, what moves frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UnitSystem
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.mesh_plot import draw_cross, draw_length_bar, draw_outline
from supple.viz.shaded_surface import Page, carry, render
from supple.viz.style import COLOUR_MAP, COLOURS, SURFACE_COLOUR

Array = NDArray[np.float64]
Array8 = NDArray[np.uint8]

_PIXELS_PER_INCH = 100
_BAR_PIXELS = 72
"""Height of the strip with the colour bar, its numbers and its label."""


@dataclass(frozen=True, eq=False)
class Moving:
    """What moves in front of the camera, at the times of the frames.

    positions : (t, N, 3), of the skin;  values : (t, N), NaN is plain
    paths : (s, k, 3) points whose paths are drawn;  reached : (t,) how many of the s points
    clock : of the number of a frame, what is written
    """

    positions: Array
    skin: Skin | None
    glyphs: Glyphs | None
    values: Array | None
    paths: Array
    reached: NDArray[np.int64]
    clock: Callable[[int], str]


class Stage:
    """A page that shows one frame after another."""

    def __init__(
        self,
        page: Page,
        camera: Camera,
        moving: Moving,
        *,
        label: str,
        caption: str,
        undeformed: Array | None,
        units: UnitSystem,
    ) -> None:
        self._page, self._camera, self._moving = page, camera, moving
        self._scale = ScalarMappable(cmap=colormaps[COLOUR_MAP].with_extremes(bad=SURFACE_COLOUR))
        if moving.values is not None:
            self._scale.set_norm(Normalize(np.nanmin(moving.values), np.nanmax(moving.values)))
        self._figure, self._axes = _sheet(page, self._scale, label)
        self._canvas = FigureCanvasAgg(self._figure)
        carry(self._axes, page)
        self._image = _Pixels(self._figure.bbox.height - page.n_rows)
        self._axes.add_artist(self._image)
        self._glyphs = None if moving.glyphs is None else DrawnGlyphs(self._axes, moving.glyphs, camera)
        if undeformed is not None and moving.skin is not None:
            draw_outline(self._axes, undeformed, moving.skin, camera)
        draw_cross(self._axes, camera)
        draw_length_bar(self._axes, page, units)
        corner: dict[str, Any] = {"transform": self._axes.transAxes, "va": "top"}
        self._axes.text(0.02, 0.97, caption, ha="left", **corner)
        self._clock = self._axes.text(0.98, 0.97, "", ha="right", **corner)
        self._gone = camera.project(moving.paths)[0]
        self._paths = [
            self._axes.plot([], [], color=COLOURS[1], linewidth=0.9, zorder=1.5)[0]
            for _ in range(self._gone.shape[1])
        ]
        # What does not move, the bar and its numbers, is drawn once.
        self._axes.set_visible(False)
        self._canvas.draw()
        self._axes.set_visible(True)
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)

    def frame(self, number: int) -> Array8:
        """The pixels (rows, columns, 3) of a frame."""
        moving = self._moving
        if moving.skin is not None:
            values = None if moving.values is None else moving.values[number]
            picture = render(
                moving.positions[number],
                moving.skin,
                self._camera,
                self._page,
                values=values,
                colouring=lambda value: self._scale.to_rgba(value)[:, :3],
            )
            self._image.rows = (255.0 * picture + 0.5).astype(np.uint8)
        if self._glyphs is not None:
            self._glyphs.show(number)
        self._clock.set_text(moving.clock(number))
        for k, line in enumerate(self._paths):
            line.set_data(*self._gone[: moving.reached[number], k].T)
        self._canvas.restore_region(self._still)
        self._axes.draw(self._canvas.get_renderer())
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


class _Pixels(Artist):
    """A picture with the pixels of the animation: matplotlib's own images are resampled for every frame."""

    zorder = 2.0

    def __init__(self, bottom: float) -> None:
        super().__init__()
        self._bottom = round(bottom)
        self.rows: Array8 | None = None
        """(rows, columns, 4), from the bottom row"""

    def draw(self, renderer: RendererBase) -> None:
        """Lay it over what lies behind."""
        if self.rows is None:
            return
        context = renderer.new_gc()
        renderer.draw_image(context, 0, self._bottom, self.rows)
        context.restore()


def _sheet(page: Page, scale: ScalarMappable, label: str) -> tuple[Figure, Axes]:
    """Axes as large as the page, pixel for pixel, over a bar of the colours where they have a label."""
    bar = _BAR_PIXELS if label else 0
    n_rows = page.n_rows + bar
    figure = Figure(
        figsize=(page.n_columns / _PIXELS_PER_INCH, n_rows / _PIXELS_PER_INCH), dpi=_PIXELS_PER_INCH
    )
    axes = figure.add_axes((0.0, bar / n_rows, 1.0, page.n_rows / n_rows))
    if label:
        rim = figure.add_axes((0.25, 0.72 * bar / n_rows, 0.5, 0.16 * bar / n_rows))
        figure.colorbar(scale, cax=rim, orientation="horizontal", label=label)
    return figure, axes
