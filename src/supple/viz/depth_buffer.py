"""The visible triangle at each pixel: the depth buffer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import FloatArray, IntArray

# Pixels processed at a time, which limits the memory to some 50 MiB.
_BATCH = 2**20


@dataclass(frozen=True, eq=False)
class VisibleTriangles:
    """The nearest triangle at each covered pixel.

    pixel : (p,)       number of the pixel, row by row from the bottom
    triangle : (p,)    the visible triangle
    weights : (p, 3)   barycentric coordinates of the pixel in the triangle
    """

    pixel: IntArray
    triangle: IntArray
    weights: FloatArray


def visible_triangles(corners: FloatArray, nearness: FloatArray, shape: tuple[int, int]) -> VisibleTriangles:
    """Resolve which triangle is nearest to the viewer at each pixel centre.

    Parameters
    ----------
    corners : array (T, 3, 2)    in pixels, x to the right and y upwards
    nearness : array (T, 3)      of the corners, growing towards the viewer
    shape : (int, int)           rows and columns of the picture
    """
    rows, columns = shape
    spans = _spans(corners, shape)
    length = spans.past - spans.first
    depth_slope, depth_at_zero = _depth_along_row(corners, nearness, spans)
    nearest = np.full(rows * columns, -np.inf)
    seen = np.full(rows * columns, -1, dtype=np.int64)
    for begin, end in _batches(length):
        part = slice(begin, end)
        count = length[part]
        span = np.repeat(np.arange(begin, end), count)
        column = np.arange(len(span)) - np.repeat(np.cumsum(count) - count - spans.first[part], count)
        pixel = spans.row[span] * columns + column
        depth = depth_at_zero[span] + depth_slope[span] * (column + 0.5)
        np.maximum.at(nearest, pixel, depth)
        front = depth == nearest[pixel]
        seen[pixel[front]] = spans.triangle[span[front]]
    pixel = np.flatnonzero(seen >= 0)
    t = seen[pixel]
    row, column = np.divmod(pixel, columns)
    return VisibleTriangles(pixel, t, _barycentric(corners, t, column + 0.5, row + 0.5))


@dataclass(frozen=True, eq=False)
class _Spans:
    """Runs of pixels of one row whose centres lie in a triangle: from `first` to `past` - 1; arrays (s,)."""

    triangle: IntArray
    row: IntArray
    first: IntArray
    past: IntArray


def _spans(corners: FloatArray, shape: tuple[int, int]) -> _Spans:
    rows, columns = shape
    x, y = corners[..., 0], corners[..., 1]
    # A triangle seen edge-on covers no pixel centre.
    bottom, top = _centres_between(y.min(axis=1), y.max(axis=1), rows)
    n_rows = np.where(_twice_area(corners) != 0.0, top - bottom, 0)
    t = np.repeat(np.arange(len(corners)), n_rows)
    row = np.arange(len(t)) - np.repeat(np.cumsum(n_rows) - n_rows - bottom, n_rows)
    level = (row + 0.5)[:, None]
    x_from, y_from = x[t], y[t]
    x_to, y_to = x_from[:, [1, 2, 0]], y_from[:, [1, 2, 0]]
    crosses = (y_from <= level) != (y_to <= level)
    rise = np.where(crosses, y_to - y_from, 1.0)
    at = x_from + (x_to - x_from) * (level - y_from) / rise
    left = np.where(crosses, at, np.inf).min(axis=1)
    right = np.where(crosses, at, -np.inf).max(axis=1)
    crossed = crosses.any(axis=1)
    first, past = _centres_between(np.where(crossed, left, 0.0), np.where(crossed, right, 0.0), columns)
    kept = past > first
    return _Spans(t[kept], row[kept], first[kept], past[kept])


def _centres_between(low: FloatArray, high: FloatArray, n_pixels: int) -> tuple[IntArray, IntArray]:
    """First pixel whose centre lies in [low, high], and one past the last."""
    first = np.clip(np.ceil(low - 0.5), 0, n_pixels).astype(np.int64)
    past = np.clip(np.floor(high - 0.5) + 1.0, 0, n_pixels).astype(np.int64)
    return first, np.maximum(first, past)


def _depth_along_row(
    corners: FloatArray, nearness: FloatArray, spans: _Spans
) -> tuple[FloatArray, FloatArray]:
    """Slope and value at x = 0 of the nearness along each span; it is linear in x over a triangle."""
    t, y = spans.triangle, spans.row.astype(float) + 0.5
    at_zero, at_one = (np.einsum("si,si->s", _barycentric(corners, t, x, y), nearness[t]) for x in (0.0, 1.0))
    return at_one - at_zero, at_zero


def _batches(length: IntArray) -> list[tuple[int, int]]:
    """Runs of spans with about _BATCH pixels each."""
    cuts = (np.flatnonzero(np.diff(np.cumsum(length) // _BATCH)) + 1).tolist()
    return list(zip([0, *cuts], [*cuts, len(length)], strict=True))


def _twice_area(corners: FloatArray) -> FloatArray:
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _barycentric(corners: FloatArray, t: IntArray, x: FloatArray | float, y: FloatArray) -> FloatArray:
    ax, ay = corners[t, :, 0].T - x, corners[t, :, 1].T - y
    twice = np.stack(
        [ax[1] * ay[2] - ax[2] * ay[1], ax[2] * ay[0] - ax[0] * ay[2], ax[0] * ay[1] - ax[1] * ay[0]]
    )
    return (twice / _twice_area(corners)[t]).T
