"""Sections of beams by their shape: areas, second moments, torsion, shear factors and centres.

y is along the first axis of the section (n1), z along the second (n2); positions are relative to the node.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.mesh import SectionGeometry, Wall, circular_section, rectangular_section, walled_section

_Rectangle = tuple[float, float, float, float, float]
"""From y, to y, from z, to z, and the sign of the area."""


@dataclass(frozen=True)
class BeamShape:
    """area; Iyy, Izz, Iyz = int y^2, z^2, y z dA about the centroid; J; the shear factor of both planes.

    centroid, shear_centre : (y, z) from the node;  size : (y, z) extents
    geometry : outline and points of stress recovery, relative to the node; None if only numbers are given
    """

    area: float
    Iyy: float
    Izz: float
    Iyz: float
    J: float
    factor: float
    centroid: tuple[float, float] = (0.0, 0.0)
    shear_centre: tuple[float, float] = (0.0, 0.0)
    size: tuple[float, float] = (0.0, 0.0)
    geometry: SectionGeometry | None = None


# Shear factors are those of Abaqus (User's Guide, "Choosing a beam element", transverse shear stiffness).
_SOLID_ROUND, _SOLID_RECTANGLE, _TRAPEZOID = 0.89, 0.85, 0.822
_THIN_PIPE, _BOX, _I, _L = 0.53, 0.44, 0.44, 1.0


def beam_shape(kind: str, dimensions: list[float]) -> BeamShape | None:
    """The shape of SECTION=kind; None if the kind is unsupported or the dimensions are inconsistent.

    Kinds: RECT, CIRC, PIPE, THICK PIPE, BOX, I, T, L, TRAPEZOID. Missing dimensions are 0.
    """
    for word in ("RECT", "CIRC"):
        kind = word if kind.startswith(word) else kind
    maker, n, signed = _SHAPES.get(kind, (None, 0, -1))
    if maker is None or any(value < 0 for i, value in enumerate(dimensions[:n]) if i != signed):
        return None
    try:
        made = maker(*[*dimensions, *n * [0.0]][:n])
    except (OverflowError, ZeroDivisionError):  # inconsistent dimensions
        return None
    positive = min(made.area, made.Iyy, made.Izz, made.J) > 0
    return made if positive and np.isfinite([made.area, made.Iyy, made.Izz, made.J]).all() else None


def _rectangle(a: float, b: float) -> BeamShape:
    b = b or a  # CalculiX: a square if one side is given
    shape = BeamShape(a * b, a**3 * b / 12, a * b**3 / 12, 0.0, _torsion(a, b), _SOLID_RECTANGLE, size=(a, b))
    return replace(shape, geometry=rectangular_section(a, b)) if min(a, b) > 0 else shape


def _torsion(a: float, b: float) -> float:
    """Saint-Venant's constant of a rectangle (Timoshenko and Goodier, Theory of Elasticity, section 109)."""
    long, short = max(a, b), min(a, b)
    if not short > 0:
        return 0.0
    n = np.arange(1, 40, 2)
    series = np.sum(np.tanh(n * np.pi * long / (2 * short)) / n**5.0)
    return float(long * short**3 / 3 * (1 - 192 * short / (np.pi**5 * long) * series))


def _circle(r: float) -> BeamShape:
    second = np.pi * r**4 / 4
    return BeamShape(
        np.pi * r**2,
        second,
        second,
        0.0,
        2 * second,
        _SOLID_ROUND,
        size=(2 * r, 2 * r),
        geometry=circular_section(r),
    )


def _pipe(r: float, t: float) -> BeamShape:
    if t > r:
        return _NO_SHAPE
    inner = r - t
    second = np.pi * (r**4 - inner**4) / 4
    return BeamShape(
        np.pi * (r**2 - inner**2),
        second,
        second,
        0.0,
        2 * second,
        _THIN_PIPE,
        size=(2 * r, 2 * r),
        geometry=circular_section(r, inner),
    )


def _box(a: float, b: float, t1: float, t2: float, t3: float, t4: float) -> BeamShape:
    """Box a x b with walls t1 at +y, t2 at +z, t3 at -y, t4 at -z; J of closed cell (Bredt) and open walls.

    J = 4 A^2 / sum(s / t) + sum(s t^3) / 3  (Megson, Aircraft Structures, sections 18.1 and 18.2), along the
    middle lines. The second term matters for a profile that is almost open.
    """
    t2, t3, t4 = t2 or t1, t3 or t1, t4 or t1
    inner_y, inner_z = (t3 - a / 2, a / 2 - t1), (t4 - b / 2, b / 2 - t2)
    sides = _section([(-a / 2, a / 2, -b / 2, b / 2, 1.0), (*inner_y, *inner_z, -1.0)], _BOX, size=(a, b))
    width, height = a - (t1 + t3) / 2, b - (t2 + t4) / 2
    if not t1 > 0:
        return sides
    J = 4 * (width * height) ** 2 / (height / t1 + height / t3 + width / t2 + width / t4)
    J += (height * (t1**3 + t3**3) + width * (t2**3 + t4**3)) / 3
    outer, inner = _rim(-a / 2, a / 2, -b / 2, b / 2), _rim(*inner_y, *inner_z)
    walls = [
        Wall(y, z, h, w, 1 / (2 * width * height * min(h, w)))
        for y, z, h, w in (
            ((a - t1) / 2, 0.0, t1, b),
            ((t3 - a) / 2, 0.0, t3, b),
            ((t3 - t1) / 2, (b - t2) / 2, a - t1 - t3, t2),
            ((t3 - t1) / 2, (t4 - b) / 2, a - t1 - t3, t4),
        )
    ]
    return _with(sides, J, sides.centroid, walled_section(walls, box=(outer, inner)))


def _rim(y0: float, y1: float, z0: float, z1: float) -> tuple[tuple[float, float], ...]:
    return ((y1, z1), (y0, z1), (y0, z0), (y1, z0))


def _i_section(below: float, h: float, b1: float, b2: float, t1: float, t2: float, t3: float) -> BeamShape:
    """I of height h: bottom flange b1 x t1, top flange b2 x t2, web t3; node `below` above the bottom."""
    bottom, top = -below, h - below
    parts = [
        (-b1 / 2, b1 / 2, bottom, bottom + t1, 1.0),
        (-b2 / 2, b2 / 2, top - t2, top, 1.0),
        (-t3 / 2, t3 / 2, bottom + t1, top - t2, 1.0),
    ]
    shape = _section(parts, _I, size=(max(b1, b2), h))
    lower, upper = t1 * b1**3, t2 * b2**3
    z = ((bottom + t1 / 2) * lower + (top - t2 / 2) * upper) / (lower + upper) if lower + upper > 0 else 0.0
    J = (b1 * t1**3 + b2 * t2**3 + (h - (t1 + t2) / 2) * t3**3) / 3
    return _with(shape, J, (0.0, z), _open(parts, J))


def _t_section(b: float, h: float, below: float, tf: float, tw: float) -> BeamShape:
    return _i_section(below, h, 0.0, b, 0.0, tf, tw)


def _l_section(a: float, b: float, t1: float, t2: float) -> BeamShape:
    """Leg a along y of thickness t1, leg b along z of t2; the node lies where their middle lines meet."""
    parts = [
        (-t2 / 2, a - t2 / 2, -t1 / 2, t1 / 2, 1.0),
        (-t2 / 2, t2 / 2, t1 / 2, b - t1 / 2, 1.0),
    ]
    shape = _section(parts, _L, size=(a, b))
    J = ((a - t2 / 2) * t1**3 + (b - t1 / 2) * t2**3) / 3
    return _with(shape, J, (0.0, 0.0), _open(parts, J))


def _open(parts: list[_Rectangle], J: float) -> SectionGeometry | None:
    """Geometry of an open thin-walled section; None if its walls are inconsistent."""
    walls = [
        Wall((y0 + y1) / 2, (z0 + z1) / 2, y1 - y0, z1 - z0, min(y1 - y0, z1 - z0) / J)
        for y0, y1, z0, z1, _ in parts
        if y1 > y0 and z1 > z0
    ]
    return walled_section(walls) if walls and J > 0 else None


def _trapezoid(a: float, b: float, c: float, d: float) -> BeamShape:
    """Bottom width a, height b, top width c; node d above the bottom; J = A^4 / (40 I_p) (Saint-Venant)."""
    area = b * (a + c) / 2
    z = b * (a + 2 * c) / (3 * (a + c)) if a + c > 0 else 0.0
    Izz = b**3 * (a**2 + 4 * a * c + c**2) / (36 * (a + c)) if a + c > 0 else 0.0
    Iyy = b * (a + c) * (a**2 + c**2) / 48
    J = area**4 / (40 * (Iyy + Izz)) if Iyy + Izz > 0 else 0.0
    centre = (0.0, z - d)
    around = ((c / 2, b - d), (-c / 2, b - d), (-a / 2, -d), (a / 2, -d))
    shape = SectionGeometry(around, (), (around,))
    return BeamShape(area, Iyy, Izz, 0.0, J, _TRAPEZOID, centre, centre, (max(a, c), b), shape)


def _section(parts: list[_Rectangle], factor: float, *, size: tuple[float, float]) -> BeamShape:
    """The sum of rectangles (from y, to y, from z, to z, sign), with J = 0."""
    y0, y1, z0, z1, sign = np.array(parts).T
    area = sign * (y1 - y0) * (z1 - z0)
    total = float(area.sum())
    # Walls thicker than their section leave no inside, or a web of negative height.
    if not total > 0 or min(*(y1 - y0), *(z1 - z0)) < -1e-9 * max(size):
        return _NO_SHAPE
    y, z = (y0 + y1) / 2, (z0 + z1) / 2
    cy, cz = float(area @ y / total), float(area @ z / total)
    return BeamShape(
        total,
        float(area @ ((y1 - y0) ** 2 / 12 + (y - cy) ** 2)),
        float(area @ ((z1 - z0) ** 2 / 12 + (z - cz) ** 2)),
        float(area @ ((y - cy) * (z - cz))),
        0.0,
        factor,
        (cy, cz),
        (cy, cz),
        size,
    )


def _with(
    shape: BeamShape, J: float, shear_centre: tuple[float, float], geometry: SectionGeometry | None
) -> BeamShape:
    return replace(shape, J=J, shear_centre=shear_centre, geometry=geometry)


_NO_SHAPE = BeamShape(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
# Maker, number of dimensions, and the index of a distance from the node, which may be negative.
_SHAPES = {
    "RECT": (_rectangle, 2, -1),
    "CIRC": (_circle, 1, -1),
    "PIPE": (_pipe, 2, -1),
    "THICK PIPE": (_pipe, 2, -1),
    "BOX": (_box, 6, -1),
    "I": (_i_section, 7, 0),
    "T": (_t_section, 5, 2),
    "L": (_l_section, 4, -1),
    "TRAPEZOID": (_trapezoid, 4, 3),
}
