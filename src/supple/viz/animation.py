"""Animation of a body in motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.results.film import speed_words
from supple.units import UNNAMED, UnitSystem, with_unit
from supple.viz.film_file import check_film, played_rate, write_film
from supple.viz.film_stage import Array8, Moving, Stage
from supple.viz.glyphs import Glyphs
from supple.viz.mesh_plot import check_positions
from supple.viz.shaded_surface import PixelWindow, page_around
from supple.viz.style import Picture, textbook_style

__all__ = ["Traces", "animate"]


class Traces(NamedTuple):
    """Paths of k points; a frame shows each path up to the time of the frame.

    times : (s,), ascending     for smooth paths, more than the times of the frames
    points : (s, k, 3)          positions in space
    """

    times: FloatArray
    points: FloatArray


_NO_TRACES = Traces(np.zeros(0), np.zeros((0, 0, 3)))


def animate(
    path: Path | str,
    times: FloatArray,
    positions: FloatArray,
    skin: Skin | None,
    *,
    glyphs: Glyphs | None = None,
    values: FloatArray | None = None,
    values_label: str = "",
    traces: Traces | None = None,
    camera: Camera | None = None,
    undeformed: FloatArray | None = None,
    caption: str = "",
    shown: IntArray | None = None,
    frames_per_second: float = 20.0,
    n_columns: int = 640,
    units: UnitSystem = UNNAMED,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Animate a body in space, with a frame for each given time, as a repeating GIF or an MP4.

    Each frame shows its time, and the speed of the animation relative to real time.

    Parameters
    ----------
    path : ends in .gif or .mp4; an MP4 needs ffmpeg (`pip install 'supple[film]'`)
    times : array (t,)
    positions : array (t, N, 3)     positions of the nodes, such as from `node_positions`
    skin : Skin                     visible surface of the mesh; None, with positions (t, 0, 3): glyphs alone
    glyphs : Glyphs                 symbols of rigid bodies, joints, springs, ties and masses, at these times
    values : array (t, N)           nodal values that colour the body, with one scale for all frames; nodes
                                    with NaN have the plain colour of surfaces
    values_label : str              name of the values with unit, under the colour bar; without it, no bar
    traces : Traces                 paths of points
    camera : Camera                 by default a three-quarter view of the whole motion
    undeformed : array (N, 3)       positions of the nodes for a pale outline behind the body
    caption : str                   text in the upper left corner
    shown : int array (f,)          index of the time of each frame; by default every time has one frame
    frames_per_second : float       up to 50; in a GIF the nearest 100 / k with a whole number k
    n_columns : int                 width of the picture in pixels
    units : UnitSystem              units of the length bar and of the time
    progress : callable             called with the fraction of the frames that are finished, up to 1

    Raises
    ------
    ModelError              no frames, an array of wrong shape or not finite, a frame rate out of range
    MissingPackageError     an MP4, if imageio-ffmpeg is not installed
    ResultFileError         the file cannot be written
    """
    check_film(path, frames_per_second)
    traces = traces or _NO_TRACES
    _check(times, positions, skin, values, glyphs, traces)
    if values_label and values is None:
        raise ModelError(f"cannot draw a colour bar of '{values_label}': give the values")
    rate = played_rate(path, frames_per_second)
    shown = np.arange(len(times)) if shown is None else shown
    seen = [positions] if glyphs is None else [positions, glyphs.points]
    camera = camera or Camera.three_quarter(np.concatenate(seen, axis=1).reshape(-1, 3))
    reached = np.searchsorted(traces.times, times, side="right")
    clock = partial(_clock_words, times, speed_words(times[shown], rate, units), units)
    moving = Moving(positions, skin, glyphs, values, traces.points, reached, clock)
    rest = [] if undeformed is None else [undeformed]
    page = _page(camera, [*seen, traces.points, *rest], n_columns, is_marked=glyphs is not None)
    with textbook_style():
        stage = Stage(
            page, camera, moving, label=values_label, caption=caption, undeformed=undeformed, units=units
        )
        write_film(Path(path), _drawn_once(stage, shown, progress), len(shown), rate)
    return Picture(path)


def _page(camera: Camera, points: list[FloatArray], n_columns: int, *, is_marked: bool) -> PixelWindow:
    """The page that contains all points; with symbols, which extend beyond their points, a wider margin."""
    corners = np.concatenate([camera.project(each)[0].reshape(-1, 2) for each in points])
    return page_around(corners, n_columns, margin=0.08 if is_marked else 0.04, least_aspect=0.25)


def _drawn_once(
    stage: Stage, shown: IntArray, progress: Callable[[float], None] | None
) -> Callable[[int], Array8]:
    """A function that draws the frame with a number; if successive frames show one time, it is drawn once."""
    drawn, done = lru_cache(maxsize=1)(stage.frame), set()

    def frame(number: int) -> Array8:
        pixels = drawn(int(shown[number]))
        if progress is not None and number not in done:
            done.add(number)
            progress(len(done) / len(shown))
        return pixels

    return frame


def _clock_words(times: FloatArray, speed: str, units: UnitSystem, number: int) -> str:
    """The time of a frame and, below, the speed of the animation."""
    return with_unit(f"t = {times[number]:.{_digits(times)}f}", units.time) + (f"\n{speed}" if speed else "")


def _digits(times: FloatArray) -> int:
    """Decimals that distinguish the times of successive frames, at least two."""
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    return max(2, int(np.ceil(-np.log10(step)))) if step > 0.0 else 2


def _check(
    times: FloatArray,
    positions: FloatArray,
    skin: Skin | None,
    values: FloatArray | None,
    glyphs: Glyphs | None,
    traces: Traces,
) -> None:
    if positions.ndim != 3 or len(positions) != len(times) or not len(times):
        raise ModelError(
            f"cannot animate positions of shape {np.shape(positions)} at {len(times)} times: "
            "give (t, N, 3) and (t,) with at least one frame"
        )
    if skin is not None:
        for frame in positions:
            check_positions(frame, skin)
    elif glyphs is None or glyphs.is_empty:
        raise ModelError("nothing to animate: give a skin, or glyphs")
    if values is not None and (
        values.shape != positions.shape[:2] or np.isinf(values).any() or np.isnan(values).all()
    ):
        raise ModelError(
            f"cannot colour by values of shape {values.shape}: "
            f"give finite values of shape {positions.shape[:2]}, or NaN at nodes without a value"
        )
    if glyphs is not None and len(glyphs.lines) != len(times):
        raise ModelError(f"cannot animate: glyphs at {len(glyphs.lines)} times, positions at {len(times)}")
    passed, points = traces
    if points.ndim != 3 or points.shape[::2] != (len(passed), 3) or not np.isfinite(points).all():
        raise ModelError(
            f"cannot trace points of shape {points.shape} at {len(passed)} times: "
            "give finite points (s, k, 3) and times (s,)"
        )
    if np.any(np.diff(passed) < 0):
        raise ModelError("cannot trace points at times that do not ascend: sort them")
