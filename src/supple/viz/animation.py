"""A body in motion, as an animation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
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
from PIL import Image

from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.storage.atomic_write import replacing
from supple.units import UNNAMED, UnitSystem, measured
from supple.viz.camera import Camera
from supple.viz.glyphs import DrawnGlyphs, Glyphs
from supple.viz.mesh_plot import check_nodes, draw_cross, draw_length_bar
from supple.viz.picture import Picture
from supple.viz.shaded_surface import Page, carry, page_around, render
from supple.viz.style import COLOUR_MAP, COLOURS, SURFACE_COLOUR, textbook_style

__all__ = ["Traces", "animate"]

Array = NDArray[np.float64]
Array8 = NDArray[np.uint8]

_PIXELS_PER_INCH = 100
# Height of the strip with the colour bar, its numbers and its label.
_BAR_PIXELS = 72
# Place of white in an animation's palette.
_WHITE = 255


class Traces(NamedTuple):
    """Paths of points, each drawn as far as it has been gone.

    times : (s,), ascending     they may be more than the frames, so that paths are round
    points : (s, k, 3)
    """

    times: Array
    points: Array


def animate(
    path: Path | str,
    times: Array,
    positions: Array,
    skin: Skin | None,
    *,
    glyphs: Glyphs | None = None,
    values: Array | None = None,
    values_label: str = "",
    traces: Traces | None = None,
    camera: Camera | None = None,
    frames_per_second: float = 20.0,
    n_columns: int = 640,
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Animate a body in space as a GIF that repeats, one frame per given time.

    Parameters
    ----------
    times : array (t,)              shown in the picture
    positions : array (t, N, 3)     of the nodes, as `node_positions` recovers them
    skin : Skin                     what is seen of the mesh; None with positions (t, 0, 3)
    glyphs : Glyphs                 of what has no mesh, at the same times
    values : array (t, N)           nodal scalar to colour by, in one scale throughout; NaN is plain
    values_label : str              what they are, with their unit, under a colour bar; no bar without
    traces : Traces                 of points whose paths are drawn
    camera : Camera                 a three-quarter view of the whole motion by default
    frames_per_second : float       up to 50, which is as fast as viewers play
    n_columns : int                 pixels across
    units : UnitSystem              what the length bar and the clock are in
    progress : callable             called with the share of frames done, ending at 1

    Raises
    ------
    ModelError          no frames, arrays of other shapes or not finite, a rate out of range
    ResultFileError     the file cannot be written
    """
    _check(path, times, positions, skin, values, frames_per_second)
    _check_glyphs(glyphs, skin, len(times))
    traces = traces or Traces(np.zeros(0), np.zeros((0, 0, 3)))
    _check_traces(traces)
    if values_label and values is None:
        raise ModelError(f"cannot draw a colour bar of '{values_label}': give the values, too")
    seen = positions if glyphs is None else np.concatenate([positions, glyphs.points], axis=1)
    camera = camera or Camera.three_quarter(seen.reshape(-1, 3))
    margin = 0.04 if glyphs is None else 0.08  # marks reach beyond their places
    gone = camera.project(traces.points)[0]
    corners = np.concatenate([camera.project(seen)[0].reshape(-1, 2), gone.reshape(-1, 2)])
    page = page_around(corners, n_columns, margin=margin, least_aspect=0.25)
    scale = ScalarMappable(cmap=colormaps[COLOUR_MAP].with_extremes(bad=SURFACE_COLOUR))
    if values is not None:
        scale.set_norm(Normalize(np.nanmin(values), np.nanmax(values)))

    def colouring(value: Array) -> Array:
        return scale.to_rgba(value)[:, :3]

    with textbook_style():
        figure, axes = _stage(page, scale, values_label)
        canvas = FigureCanvasAgg(figure)
        carry(axes, page)
        image = _Pixels(figure.bbox.height - page.n_rows)
        axes.add_artist(image)
        drawn = None if glyphs is None else DrawnGlyphs(axes, glyphs, camera)
        draw_cross(axes, camera)
        draw_length_bar(axes, page, units)
        clock = axes.text(0.98, 0.97, "", transform=axes.transAxes, ha="right", va="top")
        paths = [
            axes.plot([], [], color=COLOURS[1], linewidth=0.9, zorder=1.5)[0] for _ in range(gone.shape[1])
        ]
        reached = np.searchsorted(traces.times, times, side="right")
        frames, digits = [], _digits(times)
        # What does not move, the bar and its numbers, is drawn once.
        axes.set_visible(False)
        canvas.draw()
        axes.set_visible(True)
        still = canvas.copy_from_bbox(figure.bbox)
        for i, time in enumerate(times):
            frame_values = None if values is None else values[i]
            if skin is not None:
                picture = render(positions[i], skin, camera, page, values=frame_values, colouring=colouring)
                image.rows = (255.0 * picture + 0.5).astype(np.uint8)
            if drawn is not None:
                drawn.show(i)
            clock.set_text(measured(f"t = {time:.{digits}f}", units.time))
            for k, line in enumerate(paths):
                line.set_data(*gone[: reached[i], k].T)
            canvas.restore_region(still)
            axes.draw(canvas.get_renderer())
            frames.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
            if progress is not None:
                progress((i + 1) / len(times))
    _save_gif(Path(path), frames, frames_per_second)
    return Picture(path)


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


def _digits(times: Array) -> int:
    """Decimals by which one frame's time differs from the next one's, two at least."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    return max(2, int(np.ceil(-np.log10(step)))) if step > 0.0 else 2


def _stage(page: Page, scale: ScalarMappable, label: str) -> tuple[Figure, Axes]:
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


def _save_gif(path: Path, frames: list[Array8], frames_per_second: float) -> None:
    palette = _common_palette(frames)
    indexed = [_indexed(frame, palette) for frame in frames]
    with replacing(path) as temporary:
        indexed[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=indexed[1:],
            duration=round(1000.0 / frames_per_second),
            loop=0,
            # A third smaller otherwise, for half of the time that all of the animation takes.
            optimize=False,
        )


def _common_palette(frames: list[Array8]) -> Image.Image:
    """255 colours from frames all over the animation, so that they do not flicker, and white as the last."""
    sample = np.concatenate([frames[i] for i in np.unique(np.linspace(0, len(frames) - 1, 9).astype(int))])
    palette = Image.fromarray(sample).quantize(_WHITE, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    colours = np.full((256, 3), 255)
    found = np.array(palette.getpalette()).reshape(-1, 3)[:_WHITE]
    colours[: len(found)] = found
    palette.putpalette(colours.reshape(-1).tolist())
    return palette


def _indexed(frame: Array8, palette: Image.Image) -> Image.Image:
    """The frame in colours of the palette; Pillow's approximate search would tint the white page."""
    places = np.array(Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE))
    places[(frame[..., 0] & frame[..., 1] & frame[..., 2]) == 255] = _WHITE
    indexed = Image.fromarray(places)
    indexed.putpalette(palette.getpalette() or [])
    return indexed


def _check_traces(traces: Traces) -> None:
    times, points = traces
    if points.ndim != 3 or points.shape[::2] != (len(times), 3) or not np.isfinite(points).all():
        raise ModelError(
            f"cannot trace points of shape {points.shape} at {len(times)} times: "
            "give finite ones, (s, k, 3) and (s,)"
        )
    if np.any(np.diff(times) < 0):
        raise ModelError("cannot trace points at times that are not in order: sort them")


def _check_glyphs(glyphs: Glyphs | None, skin: Skin | None, n_times: int) -> None:
    if skin is None and (glyphs is None or glyphs.is_empty):
        raise ModelError("cannot animate nothing: give a skin, or glyphs")
    if glyphs is not None and len(glyphs.lines) != n_times:
        raise ModelError(f"cannot animate glyphs at {len(glyphs.lines)} times beside {n_times} frames")


def _check(
    path: Path | str,
    times: Array,
    positions: Array,
    skin: Skin | None,
    values: Array | None,
    frames_per_second: float,
) -> None:
    if Path(path).suffix.lower() != ".gif":
        raise ModelError(f"cannot animate {path}: animations are GIF files; end the path in .gif")
    if positions.ndim != 3 or len(positions) != len(times) or not len(times):
        raise ModelError(
            f"cannot animate positions of shape {np.shape(positions)} at {len(times)} times: "
            "give (t, N, 3) and (t,) with at least one frame"
        )
    if skin is not None:
        for frame in positions:
            check_nodes(frame, skin)
    if values is not None and (
        values.shape != positions.shape[:2] or np.isinf(values).any() or np.isnan(values).all()
    ):
        raise ModelError(
            f"cannot colour by values of shape {values.shape}: "
            f"give finite ones of shape {positions.shape[:2]}, NaN where a body has none"
        )
    if not 0.0 < frames_per_second <= 50.0:
        raise ModelError(
            f"cannot animate at {frames_per_second} frames per second: give more than 0, at most 50"
        )
