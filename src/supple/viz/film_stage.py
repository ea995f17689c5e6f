"""The stage of an animation: static parts are drawn once, moving parts frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

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

from supple.arrays import FloatArray
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.units import UnitSystem
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.mesh_plot import draw_cross, draw_length_bar, draw_outline
from supple.viz.shaded_surface import PixelWindow, carry, render
from supple.viz.style import COLOUR_MAP, COLOURS, SURFACE_COLOUR

Array8 = NDArray[np.uint8]

_PIXELS_PER_INCH = 100
_STRIP = 72
"""Pixels below the page: the axis cross, the colour bar with its numbers and its label, the length bar."""
_LINE = 16
"""Pixels of a line of text, above the page."""


@dataclass(frozen=True, eq=False)
class Moving:
    """Moving parts in front of the camera, at the times of the frames.

    positions : (t, N, 3), of the skin;  values : (t, N), in the plain colour of surfaces where NaN
    paths : (s, k, 3) points of k paths;  reached : (t,) number of the s points drawn in each frame
    clock : function of the number of a frame; returns the text of its time
    """

    positions: FloatArray
    skin: Skin | None
    glyphs: Glyphs | None
    values: FloatArray | None
    paths: FloatArray
    reached: NDArray[np.int64]
    clock: Callable[[int], str]


class Stage:
    """A page on which frames are drawn one after another."""

    def __init__(
        self,
        page: PixelWindow,
        camera: Camera,
        moving: Moving,
        *,
        label: str,
        caption: str,
        undeformed: FloatArray | None,
        units: UnitSystem,
    ) -> None:
        self._page, self._camera, self._moving = page, camera, moving
        self._scale = ScalarMappable(cmap=colormaps[COLOUR_MAP].with_extremes(bad=SURFACE_COLOUR))
        if moving.values is not None:
            self._scale.set_norm(Normalize(np.nanmin(moving.values), np.nanmax(moving.values)))
        lines = max(len(text.splitlines()) for text in (caption, moving.clock(0)))
        self._sheet = _sheet(page, _LINE * lines + _LINE // 2)
        self._canvas = FigureCanvasAgg(self._sheet.figure)
        self._image = _Pixels()
        axes = self._sheet.page
        axes.add_artist(self._image)
        self._glyphs = None if moving.glyphs is None else DrawnGlyphs(axes, moving.glyphs, camera)
        if undeformed is not None and moving.skin is not None:
            draw_outline(axes, undeformed, moving.skin, camera)
        self._sheet.below(page, camera, self._scale, label, units)
        self._sheet.head.text(0.02, 0.9, caption, ha="left", va="top")
        self._clock = self._sheet.head.text(0.98, 0.9, "", ha="right", va="top")
        self._gone = camera.project(moving.paths)[0]
        self._paths = [
            axes.plot([], [], color=COLOURS[1], linewidth=0.9, zorder=1.5)[0]
            for _ in range(self._gone.shape[1])
        ]
        # Static parts are drawn once.
        self._moving_axes = self._sheet.page, self._sheet.head
        for each in self._moving_axes:
            each.set_visible(False)
        self._canvas.draw()
        for each in self._moving_axes:
            each.set_visible(True)
        self._still = self._canvas.copy_from_bbox(self._sheet.figure.bbox)

    def frame(self, number: int) -> Array8:
        """The pixels (rows, columns, 3) of a frame."""
        moving = self._moving
        if moving.skin is not None:
            values = None if moving.values is None else moving.values[number]
            nodes, skin = moving.positions[number], moving.skin
            picture = render(nodes, skin, self._camera, self._page, values, self._scale)
            self._image.rows = (255.0 * picture + 0.5).astype(np.uint8)
        if self._glyphs is not None:
            self._glyphs.show(number)
        self._clock.set_text(moving.clock(number))
        for k, line in enumerate(self._paths):
            line.set_data(*self._gone[: moving.reached[number], k].T)
        self._canvas.restore_region(self._still)
        for each in self._moving_axes:
            each.draw(self._canvas.get_renderer())
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


class _Pixels(Artist):
    """An image drawn pixel for pixel; matplotlib's own images would be resampled for every frame."""

    zorder = 2.0

    def __init__(self) -> None:
        super().__init__()
        self.rows: Array8 | None = None
        """(rows, columns, 4), from the bottom row"""

    def draw(self, renderer: RendererBase) -> None:
        """Draw the image over the background."""
        if self.rows is None:
            return
        context = renderer.new_gc()
        renderer.draw_image(context, 0, _STRIP, self.rows)
        context.restore()


class _Sheet(NamedTuple):
    """A figure with axes of the size of the page in pixels, a head above and a strip below."""

    figure: Figure
    page: Axes
    head: Axes
    strip: Axes

    def below(
        self, page: PixelWindow, camera: Camera, scale: ScalarMappable, label: str, units: UnitSystem
    ) -> None:
        """Draw the axis cross, the length bar, and the colour bar if it has a label."""
        high = np.array([page.high[0], page.low[1]])
        strip = PixelWindow(page.low - np.array([0.0, _STRIP * page.pixel]), high, page.n_columns)
        carry(self.strip, strip)
        draw_cross(self.strip, camera)
        draw_length_bar(self.strip, strip, units)
        if label:
            rim = self.strip.inset_axes((0.25, 0.72, 0.5, 0.16))
            self.figure.colorbar(scale, cax=rim, orientation="horizontal", label=label)


def _sheet(page: PixelWindow, head: int) -> _Sheet:
    """The empty figure of a page; head : height of its head in pixels."""
    n_rows = page.n_rows + head + _STRIP
    size = page.n_columns / _PIXELS_PER_INCH, n_rows / _PIXELS_PER_INCH
    figure = Figure(figsize=size, dpi=_PIXELS_PER_INCH)
    shown = figure.add_axes((0.0, _STRIP / n_rows, 1.0, page.n_rows / n_rows))
    carry(shown, page)
    top = figure.add_axes((0.0, 1.0 - head / n_rows, 1.0, head / n_rows))
    top.set_axis_off()
    return _Sheet(figure, shown, top, figure.add_axes((0.0, 0.0, 1.0, _STRIP / n_rows)))
