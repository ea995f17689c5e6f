"""Blades of BeamDyn (OpenFAST): the primary file with the curve, the blade file with 6 x 6 matrices."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy  # its parts are imported when first used

from supple.arrays import FloatArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import number_of_word, plain_integer
from supple.importers.section_table import SectionTable, check_sections, fine_grid, matrices_at, twisted_axes
from supple.importers.text_file import file_lines

__all__ = ["read_beamdyn_sections"]

SAMPLES = 20
"""Number of chords between two key points whose lengths add up to the length of the curve."""


def read_beamdyn_sections(path: str | Path) -> SectionTable:
    """Section table of a blade from a BeamDyn primary file and the blade file that it names.

    The curve is that of BeamDyn: for each member, a natural cubic spline of x, y and twist over z through its
    key points. Blade axes are x to the suction side, y to the trailing edge, z from the root to the tip; the
    twist is about -z. The blade file gives stations by fractions of the length of the curve; matrices are
    linear in between. The damping coefficients (mu) are not read: a body has its own damping.

    Raises
    ------
    ImportFormatError   missing files, entries or numbers; members or stations out of order
    ModelError          sections that `SectionTable` rejects
    Source: BeamDyn user's guide, input files (OpenFAST 4).
    """
    primary = _BeamdynFile.read(path)
    curve, turn, lengths = _curve(primary)
    name = primary.entry("BldFile")[1].strip("\"'").strip()
    blade = _BeamdynFile.read(Path(path).parent / name.replace("\\", "/"))
    eta, stiffness, inertia = _stations(blade)
    grid = fine_grid(eta)
    z = np.interp(grid * lengths[0][-1], *lengths)

    member = np.clip(np.searchsorted([each.x[0] for each in curve], z, side="right") - 1, 0, len(curve) - 1)
    points, tangents, twist = np.empty((len(z), 3)), np.ones((len(z), 3)), np.empty(len(z))
    for k, own in enumerate(curve):
        at = member == k
        points[at] = np.column_stack([own(z[at]), z[at]])
        tangents[at, :2] = own(z[at], 1)
        twist[at] = turn[k](z[at])
    axes = twisted_axes(tangents, np.radians(twist))
    return SectionTable(points, axes, matrices_at(grid, eta, stiffness), matrices_at(grid, eta, inertia))


@dataclass(frozen=True)
class _BeamdynFile:
    path: Path
    lines: list[str]

    @classmethod
    def read(cls, path: str | Path) -> _BeamdynFile:
        """The file; ImportFormatError if it is missing or no text."""
        return cls(Path(path), file_lines(Path(path), "it is no BeamDyn file"))

    def entry(self, name: str) -> tuple[int, str]:
        """Number, from 0, and value of the first line `VALUE NAME - ..`; ImportFormatError without one."""
        for number, line in enumerate(self.lines):
            found = re.match(r"\s*(\"[^\"]*\"|'[^']*'|\S+)\s+(\w+)", line)
            if found is not None and found[2].lower() == name.lower():
                return number, found[1]
        raise ImportFormatError(
            f"{self.path}: no line 'VALUE {name}'; is this a BeamDyn file, and the "
            f"{'primary' if name != 'station_total' else 'blade'} one?"
        )

    def count(self, name: str, least: int) -> tuple[int, int]:
        """Line number and value as for `entry`; ImportFormatError unless it is an integer from `least`."""
        number, word = self.entry(name)
        try:
            value = plain_integer(word)
        except ValueError:
            value = least - 1
        if value < least:
            raise ImportFormatError(
                f"{self.path}, line {number + 1}: {name} is {word[:40]}; write a whole number from {least}"
            )
        return number, value

    def numbers(self, number: int, count: int, what: str) -> list[float]:
        """The first `count` numbers of line `number`, from 0; ImportFormatError if the line has fewer."""
        words = self.lines[number].split() if number < len(self.lines) else []
        try:
            values = [number_of_word(word.lower().replace("d", "e")) for word in words[:count]]
        except ValueError:
            values = []
        if len(values) < count:
            raise ImportFormatError(
                f"{self.path}, line {number + 1}: {what} needs {count} numbers; the line is "
                f"'{' '.join(words)[:60]}'"
            )
        return values


Curves = list["scipy.interpolate.CubicSpline"]


def _curve(
    primary: _BeamdynFile,
) -> tuple[Curves, Curves, tuple[FloatArray, FloatArray]]:
    """Splines over z of each member, for (x, y) and for twist in degrees; then arc lengths and their z."""
    _, members = primary.count("member_total", 1)
    after, total = primary.count("kp_total", 3)
    sizes = [int(primary.numbers(after + 1 + k, 2, f"member {k + 1}")[1]) for k in range(members)]
    if min(sizes) < 3 or sum(sizes) - members + 1 != total:
        raise ImportFormatError(
            f"{primary.path}, line {after + 1}: {total} key points for members of "
            f"{', '.join(map(str, sizes))}: each member has at least three and shares its last with the next"
        )
    first = after + members + 3
    points = np.array([primary.numbers(first + k, 4, "a key point (x, y, z, twist)") for k in range(total)])
    back = np.flatnonzero(np.diff(points[:, 2]) <= 0)
    if back.size:
        raise ImportFormatError(
            f"{primary.path}, line {first + back[0] + 2}: the key point is not beyond the one before in z; "
            "order them from the root to the tip"
        )
    curve, turn, start = [], [], 0
    z, length = [points[:1, 2]], [np.zeros(1)]
    for size in sizes:
        own = points[start : start + size]
        curve.append(scipy.interpolate.CubicSpline(own[:, 2], own[:, :2], bc_type="natural"))
        turn.append(scipy.interpolate.CubicSpline(own[:, 2], own[:, 3], bc_type="natural"))
        fine = np.interp(np.arange((size - 1) * SAMPLES + 1) / SAMPLES, np.arange(size), own[:, 2])
        steps = np.linalg.norm(np.diff(np.column_stack([curve[-1](fine), fine]), axis=0), axis=1)
        z.append(fine[1:])
        length.append(length[-1][-1] + steps.cumsum())
        start += size - 1
    return curve, turn, (np.concatenate(length), np.concatenate(z))


def _stations(blade: _BeamdynFile) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions from 0 to 1 (n,), stiffness and inertia (n, 6, 6) of the stations of a blade file."""
    _, total = blade.count("station_total", 2)
    number = next((k for k, line in enumerate(blade.lines) if "distributed properties" in line.lower()), None)
    if number is None:
        raise ImportFormatError(f"{blade.path}: no heading 'DISTRIBUTED PROPERTIES'; is this the blade file?")
    rows = [k for k in range(number + 1, len(blade.lines)) if blade.lines[k].strip()]
    if len(rows) < 13 * total:
        raise ImportFormatError(
            f"{blade.path}: {total} stations need 13 lines each, a position and two matrices; there are "
            f"{len(rows)}"
        )
    eta, matrices, where = np.empty(total), np.empty((total, 2, 6, 6)), []
    for k in range(total):
        own = rows[13 * k : 13 * k + 13]
        where.append(f"{blade.path}, line {own[0] + 1}")
        (eta[k],) = blade.numbers(own[0], 1, "the place of a station")
        matrices[k] = np.reshape([blade.numbers(line, 6, "a row of a matrix") for line in own[1:]], (2, 6, 6))
    if eta[0] != 0 or eta[-1] != 1 or (np.diff(eta) <= 0).any():
        k = int(np.argmax(np.append(False, np.diff(eta) <= 0))) if eta[0] == 0 and eta[-1] == 1 else 0
        raise ImportFormatError(f"{where[k]}: stations go from 0 (root) to 1 (tip), in ascending order")
    check_sections(where, matrices[:, 0], matrices[:, 1])
    return eta, matrices[:, 0], matrices[:, 1]
