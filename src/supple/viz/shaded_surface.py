"""A surface of triangles as a shaded picture with mesh lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from supple.arrays import FloatArray, IntArray
from supple.mesh.skin import Skin
from supple.results.camera import Camera
from supple.viz.depth_buffer import visible_triangles
from supple.viz.style import SURFACE_COLOUR

# Unit vector to the light, over the viewer's left shoulder. Components: right, up, towards the viewer.
_LIGHT = np.array([-0.45, 0.65, 0.62]) / np.linalg.norm([-0.45, 0.65, 0.62])
_AMBIENT = 0.58
# Each pixel of the picture is the average of a square of this many pixels a side.
_SUPERSAMPLING = 2
# Mesh lines are drawn if the median height of the triangles is at least this many pixels. On smaller
# triangles the lines would merge to grey.
_FINEST_LINED_TRIANGLE = 3.5


@dataclass(frozen=True, eq=False)
class PixelWindow:
    """A window on the camera's plane, divided into square pixels.

    low, high : (2,)    opposite corners, in the unit of length
    n_columns : int     pixels across
    """

    low: FloatArray
    high: FloatArray
    n_columns: int

    @property
    def pixel(self) -> float:
        """Side of a pixel in the unit of length."""
        return float(self.high[0] - self.low[0]) / self.n_columns

    @property
    def n_rows(self) -> int:
        """Number of pixels upwards."""
        return max(1, round(float(self.high[1] - self.low[1]) / self.pixel))


def page_around(
    points: FloatArray, n_columns: int, *, margin: float = 0.04, least_aspect: float = 0.12
) -> PixelWindow:
    """Window around all projected points (..., 2).

    margin : on each side, as a fraction of the larger extent
    least_aspect : least ratio of height to width
    """
    flat = points.reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    centre, half = 0.5 * (low + high), 0.5 * (high - low) + margin * (high - low).max()
    if not half.any():  # a single point, in the middle of a window of one unit
        half = np.array([0.5, 0.5])
    half[1] = max(half[1], least_aspect * half[0])
    half[0] = max(half[0], 0.6 * half[1])
    return PixelWindow(centre - half, centre + half, n_columns)


def render(
    nodes: FloatArray,
    skin: Skin,
    camera: Camera,
    page: PixelWindow,
    values: FloatArray | None = None,
    colours: ScalarMappable | None = None,
) -> FloatArray:
    """Picture (rows, columns, 4) of a surface: RGB and alpha from the bottom row; transparent elsewhere.

    Both sides are lit equally, because both sides of a shell can be visible. With nodal values (N,) and their
    colours, the colour of each pixel follows from the interpolated value.
    """
    k, triangles = _SUPERSAMPLING, skin.triangles
    fine = PixelWindow(page.low, page.high, k * page.n_columns)
    shape = (k * page.n_rows, fine.n_columns)
    plane, nearness = camera.project(nodes[triangles])
    corners = (plane - page.low) / fine.pixel
    seen = visible_triangles(corners, nearness, shape)

    base = np.broadcast_to(to_rgb(SURFACE_COLOUR), (len(seen.pixel), 3))
    if values is not None and colours is not None:
        interpolated = np.einsum("pi,pi->p", seen.weights, values[triangles[seen.triangle]])
        # Masked, because bands would give NaN the highest colour.
        base = colours.to_rgba(np.ma.masked_invalid(interpolated))[:, :3]
    brightness, gloss = _lighting(np.concatenate([plane, nearness[..., None]], axis=-1))
    colour = base * brightness[seen.triangle, None] + gloss[seen.triangle, None]
    colour *= 1.0 - 0.25 * _on_mesh_line(corners, skin.mesh_lines, seen.triangle, seen.weights)[:, None]

    row, column = np.divmod(seen.pixel, fine.n_columns)
    return _average(np.clip(colour, 0.0, 1.0), row // k, column // k, (page.n_rows, page.n_columns))


def is_seen(nodes: FloatArray, skin: Skin, camera: Camera, page: PixelWindow, node: int) -> bool:
    """Whether a node is visible, not hidden behind another part of the surface."""
    plane, nearness = camera.project(nodes[skin.triangles])
    corners = (plane - page.low) / page.pixel
    seen = visible_triangles(corners, nearness, (page.n_rows, page.n_columns))
    x, y = (camera.project(nodes[node])[0] - page.low) / page.pixel
    row, column = np.divmod(seen.pixel, page.n_columns)
    # All pixels within two pixels of the node are searched: at an outline, some of them are off the surface.
    near = np.hypot(column + 0.5 - x, row + 0.5 - y) < 2.0
    return bool((skin.triangles[seen.triangle[near]] == node).any())


def show(axes: Axes, picture: FloatArray, page: PixelWindow) -> None:
    """Draw a picture on axes, with the window's coordinates as limits, equal scales and no frame."""
    extent = (page.low[0], page.high[0], page.low[1], page.high[1])
    axes.imshow(picture, extent=extent, origin="lower", interpolation="antialiased", zorder=2.0)
    carry(axes, page)


def carry(axes: Axes, page: PixelWindow) -> None:
    """Set the limits of axes to a window, with equal scales and no frame."""
    axes.set_xlim(page.low[0], page.high[0])
    axes.set_ylim(page.low[1], page.high[1])
    axes.set_aspect("equal")
    axes.set_axis_off()


def _lighting(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Brightness of the colour and white gloss (T,) of triangles with corners (T, 3, 3) in camera axes."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal *= np.where(normal[:, 2:] < 0.0, -1.0, 1.0) / np.where(length > 0.0, length, 1.0)
    lit = np.clip(normal @ _LIGHT, 0.0, 1.0)
    return _AMBIENT + (1.0 - _AMBIENT) * lit, 0.2 * lit**12


def _on_mesh_line(
    corners: FloatArray, lined: NDArray[np.bool_], triangle: IntArray, weights: FloatArray
) -> FloatArray:
    """1 at pixels closer to a mesh line than half its width, 0 elsewhere; 0 everywhere on a fine mesh."""
    sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    twice_area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    heights = twice_area[:, None] / np.maximum(np.linalg.norm(sides, axis=2), 1e-300)
    if np.median(heights.min(axis=1)) < _FINEST_LINED_TRIANGLE * _SUPERSAMPLING:
        return np.zeros(len(triangle))
    distance = np.where(lined[triangle], weights * heights[triangle], np.inf).min(axis=1)
    return (distance < 0.4 * _SUPERSAMPLING).astype(float)


def _average(colours: FloatArray, row: IntArray, column: IntArray, shape: tuple[int, int]) -> FloatArray:
    """Picture (rows, columns, 4) of the mean colours of the fine pixels (p, 3) within each pixel.

    row, column : (p,)      of the pixel that contains each fine pixel

    The opacity of a pixel is its covered share.
    """
    pixel, n_pixels = row * shape[1] + column, shape[0] * shape[1]
    number = np.bincount(pixel, minlength=n_pixels)
    picture = np.zeros((n_pixels, 4))
    for channel, values in enumerate(colours.T):
        picture[:, channel] = np.bincount(pixel, values, n_pixels) / np.maximum(number, 1)
    picture[:, 3] = number / _SUPERSAMPLING**2
    return picture.reshape(*shape, 4)
