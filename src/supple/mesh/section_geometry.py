"""Geometry of a beam's section: its outline, and the points at which its stress is recovered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, cosh, isfinite, pi, sin, tanh

import numpy as np

from supple.errors import MeshError

__all__ = ["SectionGeometry", "Wall", "circular_section", "rectangular_section", "walled_section"]

Point = tuple[float, float]
Loop = tuple[Point, ...]

ROUND_POINTS = 8
"""Points on a circle; between two of them, bending stress is at most 8 % above their larger stress."""
ROUND_CORNERS = 16
"""Corners of the polygon that represents a circle."""
SAME_PLACE = 1e-9
"""Largest distance between coincident points, relative to the size of a section."""


@dataclass(frozen=True)
class SectionGeometry:
    """Positions (y, z) in the axes of the section, from the beam's axis (its shear centre), m.

    points : points of stress recovery
    torsion_shear : (y, z) components of the shear stress at each point per unit torsional moment, m^-3;
        empty where it is unknown, which counts as zero
    loops : convex polygons that form the section; empty where its shape is unknown
    hole : inner rim of the first loop, with as many corners; empty for a solid section

    Raises
    ------
    MeshError   positions that are not finite; torsion_shear neither empty nor as long as points; a hole with
                another number of corners than its loop
    """

    points: Loop = ()
    torsion_shear: Loop = ()
    loops: tuple[Loop, ...] = ()
    hole: Loop = ()

    def __post_init__(self) -> None:
        pairs = [*self.points, *self.torsion_shear, *self.hole, *(p for loop in self.loops for p in loop)]
        if not all(len(pair) == 2 and isfinite(pair[0]) and isfinite(pair[1]) for pair in pairs):
            raise MeshError("the geometry of a section needs places (y, z) that are finite")
        if self.torsion_shear and len(self.torsion_shear) != len(self.points):
            raise MeshError(
                f"{len(self.torsion_shear)} shear stresses by torsion for {len(self.points)} points of a "
                "section; give one each, or none"
            )
        if self.hole and (not self.loops or len(self.hole) != len(self.loops[0])):
            raise MeshError("the hole of a section needs as many corners as its first loop")

    def moved(self, y: float, z: float) -> SectionGeometry:
        """The geometry shifted by (y, z), m; the torsional shear is unchanged."""
        return self._mapped(lambda p: (p[0] + y, p[1] + z), lambda shear: shear)

    def mirrored(self) -> SectionGeometry:
        """The geometry with z replaced by -z; the y components of the torsional shear change sign."""
        return self._mapped(lambda p: (p[0], -p[1]), lambda shear: (-shear[0], shear[1]))

    def turned(self) -> SectionGeometry:
        """The geometry rotated by a right angle about the origin: the y axis to -z, the z axis to y."""
        return self._mapped(lambda p: (p[1], -p[0]), lambda shear: (shear[1], -shear[0]))

    def _mapped(self, place: Callable[[Point], Point], shear: Callable[[Point], Point]) -> SectionGeometry:
        loops = tuple(tuple(map(place, loop)) for loop in self.loops)
        return SectionGeometry(
            *(tuple(map(place, self.points)), tuple(map(shear, self.torsion_shear)), loops),
            hole=tuple(map(place, self.hole)),
        )


@dataclass(frozen=True)
class Wall:
    """A rectangle of a thin-walled section, with centre (y, z), height along y and width along z, m.

    shear : stress along its longer side per unit torsional moment, m^-3: thickness / J of an open section,
            1 / (2 A thickness) around a closed cell of area A (Bredt)
    """

    y: float
    z: float
    height: float
    width: float
    shear: float = 0.0

    @property
    def area(self) -> float:
        """Height times width."""
        return self.height * self.width

    @property
    def corners(self) -> Loop:
        """Corners (y, z) of the rectangle, in order around it."""
        h, w = self.height / 2, self.width / 2
        return tuple((self.y + a * h, self.z + b * w) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1)))

    @property
    def shear_stress(self) -> Point:
        """(y, z) components of the shear stress that a unit torsional moment about x causes, m^-3."""
        if self.height > self.width:
            return (-self.shear if self.z > 0 else self.shear, 0.0)
        return (0.0, self.shear if self.y >= 0 else -self.shear)


def torsion_constant(a: float, b: float) -> float:
    """Torsion constant J of a solid rectangle [Timoshenko & Goodier, Theory of Elasticity, eq. (170)]."""
    long, short = max(a, b), min(a, b)
    series = sum(tanh(n * pi * long / (2 * short)) / n**5 for n in range(1, 200, 2))
    return long * short**3 / 3 * (1 - 192 / pi**5 * short / long * series)


def rectangular_section(height: float, width: float) -> SectionGeometry:
    """A solid rectangle with a height along y and a width along z: its corners and mid-sides.

    The torsional shear vanishes at corners. With a the longer side, b the shorter, n odd and
    c_n = n pi a / 2b, at the middle of the longer and of the shorter sides, in this order,

        tau / M = b / J (1 - 8/pi^2 sum 1 / (n^2 cosh c_n)),   b / J 8/pi^2 sum (-1)^((n-1)/2) tanh c_n / n^2

    [Timoshenko & Goodier, Theory of Elasticity, 3rd ed., section 109]
    """
    long, short = max(height, width), min(height, width)
    odd, J = range(1, 200, 2), torsion_constant(height, width)
    c = [n * pi * long / (2 * short) for n in odd]
    by_long = 1 - 8 / pi**2 * sum(1 / (n**2 * cosh(min(x, 300.0))) for n, x in zip(odd, c, strict=True))
    by_short = sum((-1) ** (n // 2) * tanh(x) / n**2 for n, x in zip(odd, c, strict=True)) * 8 / pi**2
    # The sides normal to y are as long as the section is wide.
    across_y, across_z = (by_long, by_short) if width >= height else (by_short, by_long)
    h, w = height / 2, width / 2
    corners = Wall(0.0, 0.0, height, width).corners
    middles = ((h, 0.0), (0.0, w), (-h, 0.0), (0.0, -w))
    ty, tz = short / J * across_y, short / J * across_z
    shear = ((0.0, 0.0),) * 4 + ((0.0, ty), (-tz, 0.0), (0.0, -ty), (tz, 0.0))
    return SectionGeometry(corners + middles, shear, (corners,))


def circular_section(radius: float, inner: float = 0.0) -> SectionGeometry:
    """A circle or tube: eight points around it, with tau = M r / J."""
    J = pi * (radius**4 - inner**4) / 2
    places = _around(radius, ROUND_POINTS)
    hole = _around(inner, ROUND_CORNERS) if inner > 0 else ()
    shear = tuple((-z / J, y / J) for y, z in places)
    return SectionGeometry(places, shear, (_around(radius, ROUND_CORNERS),), hole)


def walled_section(walls: Sequence[Wall]) -> SectionGeometry:
    """A section of rectangles; the points are corners of its convex hull, where bending stress is largest."""
    owners = [(corner, wall) for wall in walls if min(wall.height, wall.width) > 0 for corner in wall.corners]
    hull = np.array(_convex_hull([corner for corner, _ in owners]))
    # The points start at the upper right and go towards -y, as C, D, E, F of Nastran's shapes.
    first = int(np.argmax((hull / np.ptp(hull, axis=0)).sum(axis=1).round(9)))
    hull = np.roll(hull, -first, axis=0)
    size = float(np.ptp(hull, axis=0).max())

    def shear(place: np.ndarray) -> Point:
        own = [wall for corner, wall in owners if np.abs(place - corner).max() <= SAME_PLACE * size]
        return max(own, key=lambda wall: abs(wall.shear)).shear_stress

    points, shears = tuple((float(y), float(z)) for y, z in hull), tuple(shear(place) for place in hull)
    return SectionGeometry(points, shears, tuple(wall.corners for wall in walls))


def _convex_hull(places: list[Point]) -> list[Point]:
    """Corners of the convex hull, from y towards z, by Andrew's monotone chain; none on a straight side."""

    def turn(a: Point, b: Point, c: Point) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    def chain(ordered: list[Point]) -> list[Point]:
        found: list[Point] = []
        for place in ordered:
            while len(found) > 1 and turn(*found[-2:], place) <= 0:
                found.pop()
            found.append(place)
        return found[:-1]

    ordered = sorted(set(places))
    hull, i = chain(ordered) + chain(ordered[::-1]), 0
    # A tolerance in the chains could drop a corner for one beside it: corners of walls differ by rounding.
    flat = SAME_PLACE * float(np.prod(np.ptp(places, axis=0)))
    while i < len(hull):
        if turn(hull[i - 1], hull[i], hull[(i + 1) % len(hull)]) <= flat:
            del hull[i]
        else:
            i += 1
    return hull


def _around(radius: float, count: int) -> Loop:
    angles = (2 * pi * k / count for k in range(count))
    return tuple((radius * cos(a), radius * sin(a)) for a in angles)
