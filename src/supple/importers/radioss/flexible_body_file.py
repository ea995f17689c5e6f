"""Radioss' flexible-body file (.fxb): modes, mass and stiffness of a sub-domain on a four-point frame.

Blocks, in order; integers take 8 columns, other numbers 16, which leaves nine decimals of the mantissa:

    modes, static modes, nodes; flags: rotation modes, damping, blocked, data on disk   7I8
    node ids                                                                        10I8
    P0 row by row, highest frequency                                                5E16.9
    alpha, beta                         with damping
    12 frame modes                      unless blocked; six components of each node, on lines of five and one
    3 rotation modes                    with rotation modes; also frame modes
    local modes
    diagonal of the mass
    stiffness: rows of the static modes from the diagonal on, then the diagonal entries of the other modes
    frame mass, upper triangle by rows; nine coupling masses; nine coupling stiffnesses     unless blocked

Modal stress fields that follow are neither read nor written. Lines that begin with # are comments.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import in_sixteen_columns
from supple.importers.text_file import file_lines

__all__ = ["FlexibleBodyFile", "read_flexible_body_file", "write_flexible_body_file"]

_MOST = 10_000_000
"""Largest number of nodes or of modes in the first line; a larger number is an ImportFormatError."""
_LARGEST_ID = 99_999_999  # eight columns
_ROUNDING = 1e-9  # largest entry that is not written, relative to the largest


@dataclass(frozen=True, eq=False)
class FlexibleBodyFile:
    """Contents of the file: N nodes, k modes of which the first s are static, f frame modes (12, 15 or none).

    node_ids : (N,);   frame : (3, 3) P0;   highest_frequency : of the modes, Hz;   n_static : s
    frame_modes : (f, N, 6);   modes : (k, N, 6)
    mass : (k,) its diagonal;   stiffness : (k, k), diagonal except for rows and columns of static modes
    frame_mass : (f, f);   coupling_mass, coupling_stiffness : (9, k, f)
    damping : (alpha, beta) of Rayleigh damping, or None
    Raises ImportFormatError for arrays of other shapes, other numbers f, more than k static modes, ids that
    are negative or have over eight digits, or a stiffness that is not symmetric or couples modes that are not
    static.
    """

    node_ids: IntArray
    frame: FloatArray
    highest_frequency: float
    modes: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    n_static: int = 0
    frame_modes: FloatArray | None = None
    frame_mass: FloatArray | None = None
    coupling_mass: FloatArray | None = None
    coupling_stiffness: FloatArray | None = None
    damping: tuple[float, float] | None = field(default=None)

    def __post_init__(self) -> None:
        N, k = len(self.node_ids), len(self.modes)
        f = 0 if self.frame_modes is None else len(self.frame_modes)
        shapes = {"frame": (3, 3), "modes": (k, N, 6), "mass": (k,), "stiffness": (k, k)}
        if f:
            shapes |= {"frame_modes": (f, N, 6), "frame_mass": (f, f)}
            shapes |= {"coupling_mass": (9, k, f), "coupling_stiffness": (9, k, f)}
        for name, shape in shapes.items():
            if np.shape(getattr(self, name)) != shape:
                raise ImportFormatError(
                    f"a flexible-body file of {N} nodes, {k} modes and {f} frame modes needs {name} of shape "
                    f"{shape}, got {np.shape(getattr(self, name))}"
                )
        if f not in (0, 12, 15) or not 0 <= self.n_static <= k:
            raise ImportFormatError(
                "a flexible-body file has 12 or 15 frame modes, or none, and at most as many static modes as "
                f"modes; got {f} and {self.n_static} of {k}"
            )
        if N and not 0 <= np.min(self.node_ids) <= np.max(self.node_ids) <= _LARGEST_ID:
            raise ImportFormatError(
                f"a flexible-body file has node ids from 0 to {_LARGEST_ID}; got {np.min(self.node_ids)} to "
                f"{np.max(self.node_ids)}: renumber the nodes"
            )
        K, s = np.asarray(self.stiffness), self.n_static
        coupled = K[s:, s:] - np.diag(np.diag(K)[s:])
        limit = _ROUNDING * np.abs(K).max(initial=0.0)
        if (np.abs(coupled) > limit).any() or (np.abs(K - K.T) > limit).any():
            raise ImportFormatError(
                "a flexible-body file needs a symmetric stiffness, diagonal except for rows and columns of "
                "its static modes; give eigenmodes, or declare the coupled modes static"
            )


def write_flexible_body_file(path: Path | str, body: FlexibleBodyFile) -> Path:
    """Write a flexible-body file, with nine decimals (`in_sixteen_columns`); returns its path."""
    f = 0 if body.frame_modes is None else len(body.frame_modes)
    k, s = len(body.modes), body.n_static
    head = [k, s, len(body.node_ids), int(f == 15), int(body.damping is not None), int(f == 0), 0]
    lines = ["".join(f"{value:8d}" for value in head)]
    ids = body.node_ids
    lines += ["".join(f"{value:8d}" for value in ids[i : i + 10]) for i in range(0, len(ids), 10)]
    lines += _lines(np.append(body.frame.ravel(), body.highest_frequency))
    if body.damping is not None:
        lines += _lines(np.array(body.damping))
    for modes in (body.frame_modes, body.modes):
        for node in [] if modes is None else modes.reshape(-1, 6):
            lines += _lines(node)
    lines += _lines(body.mass)
    lines += _lines(np.concatenate([body.stiffness[i, i:] for i in range(s)] or [np.zeros(0)]))
    lines += _lines(np.diag(body.stiffness)[s:])
    if f:
        assert body.frame_mass is not None
        lines += _lines(body.frame_mass[np.triu_indices(f)])
        for coupling in (body.coupling_mass, body.coupling_stiffness):
            assert coupling is not None
            for own in coupling:
                lines += _lines(own.ravel())
    target = Path(path)
    target.write_text("\n".join(lines) + "\n", encoding="ascii")
    return target


def read_flexible_body_file(path: Path | str) -> FlexibleBodyFile:
    """Contents of a flexible-body file.

    Raises ImportFormatError if it is missing or ends too early, has an invalid first line, or entries that
    are no finite numbers.
    """
    text = file_lines(Path(path), "export it with its data in the file")
    rows = ((i, line) for i, line in enumerate(text, 1) if line.strip() and line[0] != "#")
    head = _whole(rows, 7, 7, path)
    k, s, N, irot, idamp, blocked, _ = (int(value) for value in head)
    if min(k, s, N) < 0 or max(k, N) > _MOST or s > k or not {irot, idamp, blocked} <= {0, 1}:
        raise ImportFormatError(f"{path}: its first line is not valid: {k} modes, {s} static, {N} nodes")
    f = 0 if blocked else 12 + 3 * irot
    ids = _whole(rows, N, 10, path)
    frame = _floats(rows, 10, path)
    damping = tuple(_floats(rows, 2, path)) if idamp else None

    def modes(count: int) -> FloatArray:
        return np.array([_floats(rows, 6, path) for _ in range(count * N)]).reshape(count, N, 6)

    frame_modes = modes(f) if f else None
    local = modes(k)
    mass = _floats(rows, k, path)
    packed = _floats(rows, s * (2 * k - s + 1) // 2, path)
    stiffness = np.diag(np.concatenate([np.zeros(s), _floats(rows, k - s, path)]))
    i, j = np.triu_indices(k)
    static = i < s
    stiffness[i[static], j[static]] = packed
    stiffness[j[static], i[static]] = packed
    coupling: dict[str, FloatArray | None] = {"coupling_mass": None, "coupling_stiffness": None}
    frame_mass = None
    if f:
        upper = np.zeros((f, f))
        upper[np.triu_indices(f)] = _floats(rows, f * (f + 1) // 2, path)
        frame_mass = upper + np.triu(upper, 1).T
        for name in coupling:
            coupling[name] = np.array([_floats(rows, k * f, path).reshape(k, f) for _ in range(9)])
    return FlexibleBodyFile(
        ids,
        frame[:9].reshape(3, 3),
        float(frame[9]),
        local,
        mass,
        stiffness,
        s,
        frame_modes,
        frame_mass,
        damping=damping,
        **coupling,
    )


Rows = Iterator[tuple[int, str]]


def _lines(values: FloatArray) -> list[str]:
    return ["".join(map(in_sixteen_columns, values[i : i + 5])) for i in range(0, len(values), 5)]


def _whole(rows: Rows, count: int, a_line: int, path: Path | str) -> IntArray:
    return np.array(_read(rows, count, a_line, 8, int, path), dtype=np.int64)


def _floats(rows: Rows, count: int, path: Path | str) -> FloatArray:
    return np.array(_read(rows, count, 5, 16, float, path), dtype=float)


def _read(
    rows: Rows, count: int, a_line: int, width: int, kind: type[int] | type[float], path: Path | str
) -> list[float]:
    n_lines = -(-count // a_line)
    taken = list(islice(rows, n_lines))
    if len(taken) < n_lines:
        raise ImportFormatError(f"{path} ends too early: {n_lines - len(taken)} more lines are missing")
    found = []
    for number, line in taken:
        wanted = min(a_line, count - len(found))
        for column in range(wanted):
            word = line[column * width : (column + 1) * width].strip()
            try:
                value = kind(word)
            except ValueError:
                raise ImportFormatError(
                    f"{path}, line {number}, columns {column * width + 1} to {(column + 1) * width}: "
                    f"expected a number, got '{word}'"
                ) from None
            if not np.isfinite(value):
                raise ImportFormatError(f"{path}, line {number}: '{word}' is not finite")
            found.append(value)
    return found
