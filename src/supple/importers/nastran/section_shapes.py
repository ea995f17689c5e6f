"""Sections of beams by shape (PBARL, PBEAML); y is up, z is right in the pictures of Nastran's manual."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.importers.section_values import SectionValues, bar, box, closed, compact, thin, tube, walled
from supple.mesh import Wall


def _tube2(outer: float, thickness: float) -> SectionValues | None:
    return tube(outer, outer - thickness) if thickness <= outer else None


def _box(width: float, height: float, lying: float, upright: float) -> SectionValues | None:
    return box(width, height, lying, lying, upright, upright)


def _i(
    height: float, bottom: float, top: float, web: float, t_bottom: float, t_top: float
) -> SectionValues | None:
    inner, between = height - t_bottom - t_top, height - (t_bottom + t_top) / 2
    if min(height, bottom, top, web, t_bottom, t_top, inner) <= 0:
        return None
    boxes = [
        Wall(0.0, 0.0, t_bottom, bottom),
        Wall(between, 0.0, t_top, top),
        Wall((t_bottom + inner) / 2, 0.0, inner, web),
    ]
    centre = between * t_top * top**3 / (t_top * top**3 + t_bottom * bottom**3)
    return walled(boxes, thin((bottom, t_bottom), (top, t_top), (between, web)), (centre, 0.0))


def _i1(flanges: float, web: float, inner: float, height: float) -> SectionValues | None:
    thickness = (height - inner) / 2
    return _i(height, flanges + web, flanges + web, web, thickness, thickness)


def _chan(width: float, height: float, web: float, flange: float) -> SectionValues | None:
    """Web on the left; its shear centre lies 3 b^2 t_f / (6 b t_f + h t_w) outside the middle of the web."""
    inner, b, h = height - 2 * flange, width - web / 2, height - flange
    if min(width, web, flange, inner, width - web) <= 0:
        return None
    boxes = [
        Wall(h / 2, b / 2 - web / 4, flange, width),
        Wall(-h / 2, b / 2 - web / 4, flange, width),
        Wall(0.0, 0.0, inner, web),
    ]
    out = 3 * b**2 * flange / (6 * b * flange + h * web)
    return walled(boxes, thin((b, flange), (b, flange), (h, web)), (0.0, -out))


def _chan1(flange: float, web: float, inner: float, height: float) -> SectionValues | None:
    return _chan(flange + web, height, web, (height - inner) / 2)


def _chan2(leg: float, base: float, height: float, width: float) -> SectionValues | None:
    """A channel that opens upwards: CHAN rotated by 90 degrees."""
    lying = _chan(height, width, base, leg)
    return lying and lying.turned()


def _t(width: float, height: float, flange: float, web: float) -> SectionValues | None:
    """Flange on top; the shear centre is where the centre lines of the walls meet."""
    stem = height - flange
    if min(width, flange, web, stem) <= 0:
        return None
    boxes = [Wall(0.0, 0.0, flange, width), Wall(-height / 2, 0.0, stem, web)]
    return walled(boxes, thin((width, flange), (height - flange / 2, web)), (0.0, 0.0))


def _t1(height: float, stem: float, flange: float, web: float) -> SectionValues | None:
    """Flange upright on the right, stem to the left: T rotated by 270 degrees."""
    s = _t(height, stem + flange, flange, web)
    return s and s.turned().turned().turned()


def _t2(width: float, height: float, flange: float, web: float) -> SectionValues | None:
    """Flange at the bottom: T upside down."""
    s = _t(width, height, flange, web)
    return s and s.turned().turned()


def _l(width: float, height: float, lying: float, upright: float) -> SectionValues | None:
    """Corner at the bottom left; the shear centre is where the centre lines meet."""
    b, h = width - upright / 2, height - lying / 2
    if min(width - upright, height - lying, lying, upright) <= 0:
        return None
    boxes = [Wall(0.0, (width - upright) / 2, lying, width), Wall(height / 2, 0.0, height - lying, upright)]
    return walled(boxes, thin((b, lying), (h, upright)), (0.0, 0.0))


def _cross(arms: float, web: float, height: float, thickness: float) -> SectionValues | None:
    if min(arms, web, height, thickness, height - thickness) <= 0:
        return None
    boxes = [
        Wall(0.0, 0.0, height, web),
        *(Wall(0.0, s * (web + arms / 2) / 2, thickness, arms / 2) for s in (1, -1)),
    ]
    return walled(boxes, thin((height, web), (arms, thickness)))


def _h(inner: float, flanges: float, height: float, web: float) -> SectionValues | None:
    if min(inner, flanges, height, web) <= 0:
        return None
    boxes = [
        Wall(0.0, 0.0, web, inner),
        *(Wall(0.0, s * (inner + flanges / 2) / 2, height, flanges / 2) for s in (1, -1)),
    ]
    return walled(boxes, thin((inner, web), (height, flanges / 2), (height, flanges / 2)))


def _z(flange: float, web: float, inner: float, height: float) -> SectionValues | None:
    """Upper flange to the left, lower to the right."""
    t = (height - inner) / 2
    if min(flange, web, inner, t) <= 0:
        return None
    boxes = [
        Wall(0.0, 0.0, height, web),
        *(Wall(s * (height - t) / 2, -s * (web + flange) / 2, t, flange) for s in (1, -1)),
    ]
    strip = (flange + web / 2, t)
    return walled(boxes, thin(strip, strip, (height - t, web)))


def _hexa(corner: float, width: float, height: float) -> SectionValues | None:
    """Hexagon with points left and right."""
    flat = width - 2 * corner
    if min(corner, height, flat) <= 0:
        return None
    # A rectangle and two triangles, each with its tip outwards.
    rectangle, triangle = flat * height, corner * height / 2
    area = rectangle + 2 * triangle
    I1 = flat * height**3 / 12 + 2 * corner * height**3 / 48
    I2 = height * flat**3 / 12 + 2 * (height * corner**3 / 36 + triangle * (flat / 2 + corner / 3) ** 2)
    y, z = height / 2, width / 2
    around = ((y, flat / 2), (0.0, z), (-y, flat / 2), (-y, -flat / 2), (0.0, -z), (y, -flat / 2))
    return compact(area, I1, I2, around)


def _hat(height: float, t: float, top: float, brim: float) -> SectionValues | None:
    inner = height - 2 * t
    if min(t, brim, inner, top - 2 * t) <= 0:
        return None
    boxes = [Wall((height - t) / 2, 0.0, t, top)]
    for s in (1, -1):
        boxes.append(Wall(0.0, s * (top - t) / 2, inner, t))
        boxes.append(Wall(-(height - t) / 2, s * (top / 2 - t + (brim + t) / 2), t, brim + t))
    h = height - t
    return walled(boxes, thin((top - t, t), (h, t), (h, t), (brim + t / 2, t), (brim + t / 2, t)))


def _hat1(width: float, height: float, top: float, t: float, bottom: float) -> SectionValues | None:
    """A hat on a plate: one closed cell, with brim and plate beside it."""
    inner, brim = height - bottom - 2 * t, (width - top) / 2
    if min(t, bottom, inner, top - 2 * t) <= 0 or brim < 0:
        return None
    sides = [Wall(bottom + t + inner / 2, s * (top - t) / 2, inner, t) for s in (1, -1)]
    brims = [Wall(bottom + t / 2, s * (top / 2 - t + (brim + t) / 2), t, brim + t) for s in (1, -1)]
    w, h = top - t, height - t / 2 - bottom / 2
    cell = 4 * (w * h) ** 2 / (w / t + 2 * h / t + w / bottom)
    around = [Wall(bottom / 2, 0.0, bottom, width), Wall(height - t / 2, 0.0, t, top), *sides]
    return walled([*closed(around, w * h), *brims], cell + thin((2 * brim, t + bottom)))


def _dbox(
    width: float,
    height: float,
    middle_at: float,
    left: float,
    middle: float,
    right: float,
    top_left: float,
    bottom_left: float,
    top_right: float,
    bottom_right: float,
) -> SectionValues | None:
    """Two cells side by side; both have the same twist [Bredt]."""
    wl, wr = middle_at - left - middle / 2, width - middle_at - right - middle / 2
    if min(wl, wr, left, middle, right, top_left, bottom_left, top_right, bottom_right) <= 0:
        return None
    # `twist` is half the shear flows q of a unit twist per length with G = 1. For each cell, the sum of
    # (q - q of the neighbour cell) s / t over its walls is 2 A.
    spans = (wl + (left + middle) / 2, wr + (right + middle) / 2)
    depths = (height - (top_left + bottom_left) / 2, height - (top_right + bottom_right) / 2)
    areas = np.array([w * h for w, h in zip(spans, depths, strict=True)])
    shared = (depths[0] + depths[1]) / 2 / middle
    flow = np.array(
        [
            [spans[0] / top_left + spans[0] / bottom_left + depths[0] / left + shared, -shared],
            [-shared, spans[1] / top_right + spans[1] / bottom_right + depths[1] / right + shared],
        ]
    )
    twist = np.linalg.solve(flow, areas)
    J = float(4 * areas @ twist)
    q = 2 * np.abs(twist) / J
    boxes = [
        Wall(height / 2, left / 2, height, left, q[0] / left),
        Wall(height / 2, middle_at, height, middle, abs(q[0] - q[1]) / middle),
        Wall(height / 2, width - right / 2, height, right, q[1] / right),
    ]
    for at, w, top, bottom, own in (
        (left + wl / 2, wl, top_left, bottom_left, q[0]),
        (middle_at + middle / 2 + wr / 2, wr, top_right, bottom_right, q[1]),
    ):
        boxes.append(Wall(height - top / 2, at, top, w, own / top))
        boxes.append(Wall(bottom / 2, at, bottom, w, own / bottom))
    return walled(boxes, J)


SHAPES: dict[str, Callable[..., SectionValues | None]] = {
    "ROD": lambda radius: tube(radius, 0.0, 0.9),
    "TUBE": lambda outer, inner: tube(outer, inner, 0.5),
    "TUBE2": _tube2,
    "BAR": bar,
    "BOX": _box,
    "BOX1": box,
    "I": _i,
    "I1": _i1,
    "CHAN": _chan,
    "CHAN1": _chan1,
    "CHAN2": _chan2,
    "T": _t,
    "T1": _t1,
    "T2": _t2,
    "L": _l,
    "CROSS": _cross,
    "H": _h,
    "Z": _z,
    "HEXA": _hexa,
    "HAT": _hat,
    "HAT1": _hat1,
    "DBOX": _dbox,
}
"""The shapes of PBARL and PBEAML: functions of the sizes DIM1, DIM2 ..; None if these are inconsistent."""
