"""Coordinate systems of a Nastran file: rectangular, cylindrical and spherical, one defined in another."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray


class CoordinateKind(Enum):
    """Coordinates of a point; angles are in degrees."""

    RECTANGULAR = auto()
    """x, y, z"""
    CYLINDRICAL = auto()
    """r, theta about z, z"""
    SPHERICAL = auto()
    """r, theta from the z axis, phi about z"""


@dataclass(frozen=True, eq=False)
class CoordinateSystem:
    """A coordinate system, expressed in the basic coordinate system.

    origin : (3,)      in basic coordinates
    axes   : (3, 3)    unit vectors of its x, y, z as columns, in basic axes
    """

    coordinates: CoordinateKind
    origin: FloatArray
    axes: FloatArray

    def basic(self, points: ArrayLike) -> FloatArray:
        """Basic coordinates (k, 3) of points given in the coordinates of this system."""
        first, second, third = np.moveaxis(np.asarray(points, dtype=np.float64), -1, 0)
        match self.coordinates:
            case CoordinateKind.RECTANGULAR:
                x, y, z = first, second, third
            case CoordinateKind.CYLINDRICAL:
                theta = np.radians(second)
                x, y, z = first * np.cos(theta), first * np.sin(theta), third
            case CoordinateKind.SPHERICAL:
                theta, phi = np.radians(second), np.radians(third)
                x, y = first * np.sin(theta) * np.cos(phi), first * np.sin(theta) * np.sin(phi)
                z = first * np.cos(theta)
        return self.origin + np.stack([x, y, z], axis=-1) @ self.axes.T

    def directions(self, points: FloatArray) -> FloatArray:
        """Unit vectors (k, 3, 3) of the coordinate lines at points (k, 3), as columns; all in basic axes.

        On the axis of a cylindrical or spherical system, where the angle is undefined, they are axes x, y, z.
        """
        x, y, z = np.moveaxis((points - self.origin) @ self.axes, -1, 0)
        rho = np.hypot(x, y)
        on_axis = rho <= 1e-9 * float(np.abs(points - self.origin).max(initial=0.0))
        phi = np.where(on_axis, 0.0, np.arctan2(y, x))
        c, s, o, e = np.cos(phi), np.sin(phi), np.zeros_like(phi), np.ones_like(phi)
        match self.coordinates:
            case CoordinateKind.RECTANGULAR:
                rows = [[e, o, o], [o, e, o], [o, o, e]]
            case CoordinateKind.CYLINDRICAL:
                rows = [[c, -s, o], [s, c, o], [o, o, e]]
            case CoordinateKind.SPHERICAL:
                theta = np.arctan2(rho, z)
                ct, st = np.cos(theta), np.sin(theta)
                rows = [[st * c, ct * c, -s], [st * s, ct * s, c], [ct, -st, o]]
        local = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        local[on_axis] = np.eye(3)
        return self.axes @ local


BASIC = CoordinateSystem(CoordinateKind.RECTANGULAR, np.zeros(3), np.eye(3))


def through_points(
    coordinates: CoordinateKind, origin: FloatArray, on_axis: FloatArray, in_plane: FloatArray
) -> CoordinateSystem | None:
    """System with z axis from `origin` to `on_axis`, and `in_plane` in the x-z plane; None if collinear.

    origin, on_axis, in_plane : (3,) in basic coordinates
    """
    z, arm = on_axis - origin, in_plane - origin
    y = np.cross(z, arm)
    if not np.linalg.norm(y) > 1e-9 * np.linalg.norm(z) * np.linalg.norm(arm):
        return None
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return CoordinateSystem(coordinates, origin, np.stack([np.cross(y, z), y, z], axis=-1))
