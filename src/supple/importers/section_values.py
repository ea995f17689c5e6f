"""Sections of beams made of walls, a rectangle or a tube: areas, second moments, torsion and centres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

from supple.importers.deck import BeamValues
from supple.mesh import SectionGeometry, Wall, circular_section, rectangular_section, walled_section
from supple.mesh.section_geometry import torsion_constant


@dataclass(frozen=True)
class SectionValues:
    """Values of a section about its centroid.

    I1, I2, I12 : integrals of y^2, z^2, y z over the area
    K1, K2 : shear factors along y and z
    geometry : outline and points of stress recovery, from the centroid; None if only numbers are given
    shear_centre : (y, z) from the centroid
    centroid : (y, z) in the axes in which the shape is described
    """

    area: float
    I1: float
    I2: float
    I12: float
    J: float
    K1: float
    K2: float
    geometry: SectionGeometry | None = None
    shear_centre: tuple[float, float] = (0.0, 0.0)
    centroid: tuple[float, float] = (0.0, 0.0)

    def turned(self) -> SectionValues:
        """The section rotated by 90 degrees, its z axis to y and its y axis to -z."""
        (y, z), (own_y, own_z) = self.shear_centre, self.centroid
        geometry = self.geometry and self.geometry.turned()
        return SectionValues(
            *(self.area, self.I2, self.I1, -self.I12, self.J, self.K2, self.K1, geometry),
            *((z, -y), (own_z, -own_y)),
        )

    def beam_values(self, density: float, added: float = 0.0) -> BeamValues:
        """Values of a beam about its shear centre.

        added : non-structural mass at the shear centre, kg/m
        """
        y, z = (0.0 - place for place in self.shear_centre)
        own = density * self.area
        mass = own + added
        share = own / mass if mass else 0.0
        return BeamValues(
            *(self.area, self.I1, self.I2, self.J, self.K1, self.K2, mass, self.I12),
            *((y, z), (share * y, share * z)),
            geometry=self.geometry and self.geometry.moved(y, z),
        )


def walled(
    walls: Sequence[Wall], J: float, shear_centre: tuple[float | None, float | None] = (None, None)
) -> SectionValues | None:
    """Values of a section of walls without overlap; None if a size is negative or J is not positive.

    K1 is the share of vertical walls (height > width) in the area, K2 that of other walls; 5/6 if there are
    none. A wall without given shear stress per unit of torsional moment has that of open sections, thickness
    divided by J.

    shear_centre : (y, z) in the axes of the walls; a None component is that of the centroid
    """
    sizes = [size for wall in walls for size in (wall.height, wall.width)]
    if not J > 0 or min(sizes) < -1e-9 * max(sizes):
        return None
    walls = [wall for wall in walls if min(wall.height, wall.width) > 0]
    area = sum(b.area for b in walls)
    y, z = (sum(b.area * getattr(b, axis) for b in walls) / area for axis in "yz")
    I1 = sum(b.area * ((b.y - y) ** 2 + b.height**2 / 12) for b in walls)
    I2 = sum(b.area * ((b.z - z) ** 2 + b.width**2 / 12) for b in walls)
    I12 = sum(b.area * (b.y - y) * (b.z - z) for b in walls)
    upright = sum(b.area for b in walls if b.height > b.width) / area
    lying = sum(b.area for b in walls if b.height <= b.width) / area
    at = tuple(0.0 if s is None else s - c for s, c in zip(shear_centre, (y, z), strict=True))
    stressed = [b if b.shear else replace(b, shear=min(b.height, b.width) / J) for b in walls]
    geometry = walled_section(stressed).moved(-y, -z)
    K1, K2 = upright or 5 / 6, lying or 5 / 6
    return SectionValues(area, I1, I2, I12, J, K1, K2, geometry, (at[0], at[1]), (y, z))


def thin(*strips: tuple[float, float]) -> float:
    """J of an open thin-walled section: int t^3 / 3 ds over strips of length and thickness."""
    return sum(length * thickness**3 for length, thickness in strips) / 3


def closed(walls: Sequence[Wall], area: float) -> list[Wall]:
    """Walls around a cell, with the shear stress 1 / (2 A t) of a unit torsional moment [Bredt]."""
    return [replace(wall, shear=1 / (2 * area * min(wall.height, wall.width))) for wall in walls]


def box(
    width: float, height: float, top: float, bottom: float, right: float, left: float
) -> SectionValues | None:
    """One cell; J by Bredt: 4 A^2 / (int ds / t)."""
    inner = height - top - bottom
    walls = [
        Wall((height - top) / 2, 0.0, top, width),
        Wall(-(height - bottom) / 2, 0.0, bottom, width),
        Wall((bottom - top) / 2, (width - right) / 2, inner, right),
        Wall((bottom - top) / 2, -(width - left) / 2, inner, left),
    ]
    if min(top, bottom, right, left, inner, width - right - left) <= 0:
        return None
    w, h = width - (left + right) / 2, height - (top + bottom) / 2
    J = 4 * (w * h) ** 2 / (w / top + w / bottom + h / left + h / right)
    return walled(closed(walls, w * h), J)


def tube(outer: float, inner: float = 0.0, K: float = 0.5) -> SectionValues:
    """A tube or rod with these radii."""
    area, second = pi * (outer**2 - inner**2), pi * (outer**4 - inner**4) / 4
    return SectionValues(area, second, second, 0.0, 2 * second, K, K, circular_section(outer, inner))


def bar(width: float, height: float) -> SectionValues | None:
    """A solid rectangle."""
    if min(width, height) <= 0:
        return None
    I1, I2, J = width * height**3 / 12, height * width**3 / 12, torsion_constant(width, height)
    return SectionValues(width * height, I1, I2, 0.0, J, 5 / 6, 5 / 6, rectangular_section(height, width))


def compact(area: float, I1: float, I2: float, outline: tuple[tuple[float, float], ...]) -> SectionValues:
    """A convex polygon about its centroid, symmetric to an axis; J by Saint-Venant's A^4 / (40 I_p)."""
    J = area**4 / (40 * (I1 + I2))
    return SectionValues(area, I1, I2, 0.0, J, 5 / 6, 5 / 6, SectionGeometry(outline, (), (outline,)))
