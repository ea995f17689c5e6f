"""Which triangle one sees at each pixel: the depth buffer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]
Array = NDArray[np.float64]

# Candidate pixels worked on at a time, which bounds the memory to some 100 MiB.
_BATCH = 2**20


@dataclass(frozen=True, eq=False)
class VisibleTriangles:
    """The nearest triangle at each covered pixel.

    pixel : (p,)       number of the pixel, row by row from the bottom
    triangle : (p,)    the triangle seen there
    weights : (p, 3)   barycentric coordinates of the pixel in it
    """

    pixel: IntArray
    triangle: IntArray
    weights: Array


def visible_triangles(corners: Array, nearness: Array, shape: tuple[int, int]) -> VisibleTriangles:
    """Resolve which triangle is nearest to the viewer at each pixel centre.

    Parameters
    ----------
    corners : array (T, 3, 2)    in pixels, x to the right and y upwards
    nearness : array (T, 3)      of the corners, growing towards the viewer
    shape : (int, int)           rows and columns of the picture
    """
    rows, columns = shape
    x, y = corners[..., 0], corners[..., 1]
    left, right = _pixel_range(x, columns)
    bottom, top = _pixel_range(y, rows)
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    # A triangle seen edge-on covers no pixel centre.
    n_candidates = np.where(area != 0.0, (right - left) * (top - bottom), 0)
    nearest = np.full(rows * columns, -np.inf)
    seen = np.full(rows * columns, -1, dtype=np.int64)
    for first, last in _batches(n_candidates):
        count = n_candidates[first:last]
        t = np.repeat(np.arange(first, last), count)
        place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        row, column = np.divmod(place, (right - left)[t])
        row, column = row + bottom[t], column + left[t]
        weights = _barycentric(corners, area, t, column + 0.5, row + 0.5)
        inside = weights.min(axis=1) >= 0.0
        t, weights = t[inside], weights[inside]
        pixel = row[inside] * columns + column[inside]
        depth = np.einsum("pi,pi->p", weights, nearness[t])
        # In rising order of nearness, the last to be assigned to a pixel is the nearest.
        order = np.argsort(depth)
        order = order[depth[order] > nearest[pixel[order]]]
        nearest[pixel[order]] = depth[order]
        seen[pixel[order]] = t[order]
    pixel = np.flatnonzero(seen >= 0)
    t = seen[pixel]
    row, column = np.divmod(pixel, columns)
    return VisibleTriangles(pixel, t, _barycentric(corners, area, t, column + 0.5, row + 0.5))


def _pixel_range(coordinate: Array, n_pixels: int) -> tuple[IntArray, IntArray]:
    """First pixel whose centre may lie inside, and one past the last."""
    first = np.ceil(coordinate.min(axis=1) - 0.5).astype(np.int64)
    past = np.floor(coordinate.max(axis=1) - 0.5).astype(np.int64) + 1
    first, past = np.clip(first, 0, n_pixels), np.clip(past, 0, n_pixels)
    return first, np.maximum(first, past)


def _batches(n_candidates: IntArray) -> list[tuple[int, int]]:
    """Runs of triangles with about _BATCH candidate pixels each."""
    batch = np.cumsum(n_candidates) // _BATCH
    cuts = np.flatnonzero(np.diff(batch)) + 1
    return list(zip([0, *cuts.tolist()], [*cuts.tolist(), len(n_candidates)], strict=True))


def _barycentric(corners: Array, area: Array, t: IntArray, x: Array, y: Array) -> Array:
    ax, ay = corners[t, :, 0].T - x, corners[t, :, 1].T - y
    twice = np.stack([ax[1] * ay[2] - ax[2] * ay[1], ax[2] * ay[0] - ax[0] * ay[2], ax[0] * ay[1] - ax[1] * ay[0]])
    return (twice / area[t]).T
