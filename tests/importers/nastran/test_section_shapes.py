"""Sections by their shape: against counted points of their pictures, and against one another."""

from __future__ import annotations

import numpy as np
import pytest

from supple.importers.nastran.section_shapes import SHAPES


def values(shape, *sizes):
    found = SHAPES[shape](*sizes)
    assert found is not None
    return found


def between(x, low, high):
    return (x > low) & (x < high)


# Pictures of Nastran's manual, y up and z right, as conditions on points.
PICTURES = {
    "I": (
        (6.0, 3.0, 4.0, 0.4, 0.5, 0.7),
        lambda y, z: (
            (between(y, 0, 0.5) & (abs(z) < 1.5))
            | (between(y, 5.3, 6) & (abs(z) < 2))
            | (between(y, 0.5, 5.3) & (abs(z) < 0.2))
        ),
    ),
    "T": (
        (4.0, 5.0, 0.6, 0.4),
        lambda y, z: (between(y, 4.4, 5) & (abs(z) < 2)) | (between(y, 0, 4.4) & (abs(z) < 0.2)),
    ),
    "T1": (
        (4.0, 3.0, 0.5, 0.4),
        lambda y, z: (between(z, 3, 3.5) & (abs(y) < 2)) | (between(z, 0, 3) & (abs(y) < 0.2)),
    ),
    "T2": (
        (4.0, 5.0, 0.6, 0.4),
        lambda y, z: (between(y, 0, 0.6) & (abs(z) < 2)) | (between(y, 0.6, 5) & (abs(z) < 0.2)),
    ),
    "CHAN": (
        (3.0, 5.0, 0.4, 0.6),
        lambda y, z: between(z, 0, 3) & (abs(y) < 2.5) & ((abs(y) > 1.9) | (z < 0.4)),
    ),
    "CHAN1": (
        (2.6, 0.4, 3.8, 5.0),
        lambda y, z: between(z, 0, 3) & (abs(y) < 2.5) & ((abs(y) > 1.9) | (z < 0.4)),
    ),
    "CHAN2": (
        (0.5, 0.4, 3.0, 4.0),
        lambda y, z: between(y, 0, 3) & (abs(z) < 2) & ((y < 0.4) | (abs(z) > 1.5)),
    ),
    "L": (
        (4.0, 5.0, 0.6, 0.4),
        lambda y, z: between(y, 0, 5) & between(z, 0, 4) & ((y < 0.6) | (z < 0.4)),
    ),
    "Z": (
        (2.0, 0.5, 4.0, 5.0),
        lambda y, z: (
            ((abs(z) < 0.25) & (abs(y) < 2.5))
            | (between(y, 2, 2.5) & between(z, -2.25, 0))
            | (between(y, -2.5, -2) & between(z, 0, 2.25))
        ),
    ),
    "CROSS": (
        (4.0, 0.5, 3.0, 0.7),
        lambda y, z: ((abs(z) < 0.25) & (abs(y) < 1.5)) | ((abs(y) < 0.35) & (abs(z) < 2.25)),
    ),
    "H": (
        (3.0, 1.0, 4.0, 0.6),
        lambda y, z: ((abs(z) < 1.5) & (abs(y) < 0.3)) | (between(abs(z), 1.5, 2.0) & (abs(y) < 2)),
    ),
    "I1": (
        (3.0, 0.4, 4.0, 5.0),
        lambda y, z: ((abs(z) < 0.2) & (abs(y) < 2.5)) | (between(abs(y), 2, 2.5) & (abs(z) < 1.7)),
    ),
    "HAT": (
        (4.0, 0.5, 3.0, 1.0),
        lambda y, z: (
            (between(y, 3.5, 4) & (abs(z) < 1.5))
            | (between(abs(z), 1.0, 1.5) & between(y, 0, 4))
            | (between(abs(z), 1.0, 2.5) & between(y, 0, 0.5))
        ),
    ),
    "HAT1": (
        (5.0, 4.0, 3.0, 0.5, 0.7),
        lambda y, z: (
            (between(y, 0, 0.7) & (abs(z) < 2.5))
            | (between(y, 3.5, 4) & (abs(z) < 1.5))
            | (between(abs(z), 1.0, 1.5) & between(y, 0.7, 4))
            | (between(abs(z), 1.0, 2.5) & between(y, 0.7, 1.2))
        ),
    ),
    "BOX": (
        (4.0, 3.0, 0.4, 0.3),
        lambda y, z: (abs(y) < 1.5) & (abs(z) < 2) & ((abs(y) > 1.1) | (abs(z) > 1.7)),
    ),
    "HEXA": (
        (1.0, 4.0, 2.0),
        lambda y, z: (abs(y) < 1) & (abs(z) < 2 - abs(y)),
    ),
    "DBOX": (
        (6.0, 3.0, 2.5, 0.3, 0.4, 0.5, 0.2, 0.3, 0.4, 0.5),
        lambda y, z: (
            between(y, 0, 3)
            & between(z, 0, 6)
            & (
                (z < 0.3)
                | (z > 5.5)
                | (abs(z - 2.5) < 0.2)
                | ((z < 2.5) & ((y > 2.8) | (y < 0.3)))
                | ((z > 2.5) & ((y > 2.6) | (y < 0.5)))
            )
        ),
    ),
    "BAR": ((3.0, 5.0), lambda y, z: (abs(y) < 2.5) & (abs(z) < 1.5)),
    "TUBE": ((2.0, 1.5), lambda y, z: between(np.hypot(y, z), 1.5, 2.0)),
}


@pytest.mark.parametrize("shape", PICTURES)
def test_area_and_second_moments_are_those_of_the_picture(shape):
    sizes, inside = PICTURES[shape]
    h = 0.01
    axis = np.arange(-6.5, 6.5, h) + h / 2 + 1e-6
    y, z = np.meshgrid(axis, axis, indexing="ij")
    y, z = (c[inside(y, z)] for c in (y, z))
    y, z = y - y.mean(), z - z.mean()
    found = values(shape, *sizes)
    assert found.area == pytest.approx(h**2 * len(y), rel=5e-3)
    assert found.I1 == pytest.approx(h**2 * (y @ y), rel=5e-3)
    assert found.I2 == pytest.approx(h**2 * (z @ z), rel=5e-3)
    assert found.I12 == pytest.approx(h**2 * (y @ z), rel=5e-3, abs=5e-3 * found.I1)


def test_the_same_section_by_other_names():
    same = [
        (("TUBE", 2.0, 1.5), ("TUBE2", 2.0, 0.5)),
        (("ROD", 2.0), ("TUBE", 2.0, 0.0)),
        (("BOX", 4.0, 3.0, 0.4, 0.3), ("BOX1", 4.0, 3.0, 0.4, 0.4, 0.3, 0.3)),
        (("I", 5.0, 3.4, 3.4, 0.4, 0.5, 0.5), ("I1", 3.0, 0.4, 4.0, 5.0)),
        (("CHAN", 3.0, 5.0, 0.4, 0.6), ("CHAN1", 2.6, 0.4, 3.8, 5.0)),
    ]
    for (a, *sizes), (b, *others) in same:
        first, second = values(a, *sizes), values(b, *others)
        for name in ("area", "I1", "I2", "J"):
            assert getattr(first, name) == pytest.approx(getattr(second, name)), (a, b, name)


def test_torsion_of_closed_and_open_walls():
    """A thin square box by Bredt, t a^3; a channel a t^3; two equal cells as the outer one."""
    a, t = 1.0, 1e-3
    assert values("BOX", a, a, t, t).J == pytest.approx(t * a**3, rel=5e-3)
    assert values("CHAN", a, a, t, t).J == pytest.approx(3 * a * t**3 / 3, rel=5e-3)
    two = values("DBOX", 2 * a, a, a, t, t, t, t, t, t, t)
    assert two.J == pytest.approx(values("BOX", 2 * a, a, t, t).J, rel=5e-3)
    # A square bar: 0.140577 a^4 [Timoshenko & Goodier, table 7].
    assert values("BAR", a, a).J == pytest.approx(0.140577, rel=5e-6)


def test_shear_centres():
    """A thin channel: 3 b^2 / (h + 6 b) outside its web; T and L where their walls meet; I between."""
    b, h, t = 2.0, 3.0, 1e-4
    channel = values("CHAN", b, h, t, t)
    centroid = b**2 / (h + 2 * b)  # from the web
    assert channel.shear_centre == pytest.approx((0.0, -centroid - 3 * b**2 / (h + 6 * b)), rel=1e-3)
    tee = values("T", b, h, t, t)
    assert tee.shear_centre[0] == pytest.approx(h**2 / 2 / (b + h), rel=1e-3)
    assert values("T2", b, h, t, t).shear_centre[0] == pytest.approx(-tee.shear_centre[0])
    angle = values("L", b, h, t, t)
    assert angle.shear_centre == pytest.approx((-(h**2) / 2 / (b + h), -(b**2) / 2 / (b + h)), rel=1e-3)
    assert values("I", h, b, b, t, t, t).shear_centre == pytest.approx((0.0, 0.0), abs=1e-3)
    # With one flange all but gone it moves into the other.
    lower = values("I", h, b, 0.01, t, t, t)
    centroid = (h * h / 2 + 0.01 * h) / (b + h + 0.01)
    assert lower.shear_centre[0] == pytest.approx(-centroid, rel=1e-2)


@pytest.mark.parametrize(
    ("shape", "sizes"),
    [
        ("BAR", (0.0, 1.0)),
        ("I", (1.0, 1.0, 1.0, 0.1, 0.6, 0.6)),
        ("BOX", (1.0, 1.0, 0.6, 0.1)),
        ("T", (1.0, 0.1, 0.2, 0.1)),
    ],
)
def test_sizes_that_do_not_fit(shape, sizes):
    assert SHAPES[shape](*sizes) is None
