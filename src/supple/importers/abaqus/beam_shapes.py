"""Sections of beams by their shape in Abaqus and CalculiX.

y is along the first axis of the section (n1), z along the second (n2); positions are relative to the node.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.importers.section_values import SectionValues, bar, box, compact, thin, tube, walled
from supple.mesh import SectionGeometry, Wall


def beam_shape(kind: str, dimensions: list[float]) -> SectionValues | None:
    """The shape of SECTION=kind; None if the kind is unsupported or the dimensions are inconsistent.

    Kinds: RECT, CIRC, PIPE, THICK PIPE, BOX, I, T, L, TRAPEZOID. Missing dimensions are 0.
    """
    for word in ("RECT", "CIRC"):
        kind = word if kind.startswith(word) else kind
    maker, n, signed, factor = _SHAPES.get(kind, (None, 0, -1, 0.0))
    if maker is None or any(value < 0 for i, value in enumerate(dimensions[:n]) if i != signed):
        return None
    try:
        made = maker(*[*dimensions, *n * [0.0]][:n])
    except (OverflowError, ZeroDivisionError):  # inconsistent dimensions
        return None
    numbers = [0.0] if made is None else [made.area, made.I1, made.I2, made.J]
    if made is None or not (min(numbers) > 0 and np.isfinite(numbers).all()):
        return None
    return replace(made, K1=factor, K2=factor)


def _rectangle(a: float, b: float) -> SectionValues | None:
    return bar(b or a, a)  # CalculiX: a square if one side is given


def _pipe(r: float, t: float) -> SectionValues | None:
    return tube(r, r - t) if t <= r else None


def _box(a: float, b: float, t1: float, t2: float, t3: float, t4: float) -> SectionValues | None:
    """Box a x b with walls t1 at +y, t2 at +z, t3 at -y, t4 at -z; J of closed cell (Bredt) and open walls.

    J = 4 A^2 / sum(s / t) + sum(s t^3) / 3  (Megson, Aircraft Structures, sections 18.1 and 18.2), along the
    middle lines. The second term matters for a profile that is almost open.
    """
    t2, t3, t4 = t2 or t1, t3 or t1, t4 or t1
    cell = box(b, a, t1, t3, t2, t4)
    if cell is None or cell.geometry is None:
        return None
    w, h = b - (t2 + t4) / 2, a - (t1 + t3) / 2
    inner = Wall((t3 - t1) / 2, (t4 - t2) / 2, a - t1 - t3, b - t2 - t4)
    rims = SectionGeometry(loops=(Wall(0.0, 0.0, a, b).corners,), hole=inner.corners)
    rims = rims.moved(-cell.centroid[0], -cell.centroid[1])
    geometry = replace(cell.geometry, loops=rims.loops, hole=rims.hole)
    return replace(cell, J=cell.J + thin((w, t1), (w, t3), (h, t2), (h, t4)), geometry=geometry)


def _i_section(
    below: float, h: float, b1: float, b2: float, t1: float, t2: float, t3: float
) -> SectionValues | None:
    """I of height h: bottom flange b1 x t1, top flange b2 x t2, web t3; node `below` above the bottom."""
    bottom, top, between = t1 / 2 - below, h - below - t2 / 2, h - (t1 + t2) / 2
    walls = [
        Wall(0.0, bottom, b1, t1),
        Wall(0.0, top, b2, t2),
        Wall(0.0, (h + t1 - t2) / 2 - below, t3, h - t1 - t2),
    ]
    lower, upper = t1 * b1**3, t2 * b2**3
    z = (bottom * lower + top * upper) / (lower + upper) if lower + upper > 0 else 0.0
    return walled(walls, thin((b1, t1), (b2, t2), (between, t3)), (0.0, z))


def _t_section(b: float, h: float, below: float, tf: float, tw: float) -> SectionValues | None:
    return _i_section(below, h, 0.0, b, 0.0, tf, tw)


def _l_section(a: float, b: float, t1: float, t2: float) -> SectionValues | None:
    """Leg a along y of thickness t1, leg b along z of t2; the node lies where their middle lines meet."""
    walls = [Wall((a - t2) / 2, 0.0, a, t1), Wall(0.0, b / 2, t2, b - t1)]
    return walled(walls, thin((a - t2 / 2, t1), (b - t1 / 2, t2)), (0.0, 0.0))


def _trapezoid(a: float, b: float, c: float, d: float) -> SectionValues:
    """Bottom width a, height b, top width c; node d above the bottom."""
    area = b * (a + c) / 2
    z = b * (a + 2 * c) / (3 * (a + c))
    I1 = b * (a + c) * (a**2 + c**2) / 48
    I2 = b**3 * (a**2 + 4 * a * c + c**2) / (36 * (a + c))
    around = ((c / 2, b - z), (-c / 2, b - z), (-a / 2, -z), (a / 2, -z))
    return replace(compact(area, I1, I2, around), centroid=(0.0, z - d))


# Maker, number of dimensions, the index of a distance from the node, which may be negative, and the shear
# factor of both planes, that of Abaqus (User's Guide, "Choosing a beam element", transverse shear stiffness).
_SHAPES = {
    "RECT": (_rectangle, 2, -1, 0.85),
    "CIRC": (tube, 1, -1, 0.89),
    "PIPE": (_pipe, 2, -1, 0.53),
    "THICK PIPE": (_pipe, 2, -1, 0.53),
    "BOX": (_box, 6, -1, 0.44),
    "I": (_i_section, 7, 0, 0.44),
    "T": (_t_section, 5, 2, 0.44),
    "L": (_l_section, 4, -1, 1.0),
    "TRAPEZOID": (_trapezoid, 4, 3, 0.822),
}
