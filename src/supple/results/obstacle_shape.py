"""Rigid obstacles as triangles for drawing: a square of a plane, a piece of a cylinder, a sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.integrate import Solution
from supple.machine import RigidCylinder, RigidPlane, RigidSphere, System
from supple.machine.obstacles import Obstacle
from supple.methods.explicit import OBSTACLES

_AROUND, _UP = 32, 16


def obstacle_offsets(system: System, solution: Solution) -> FloatArray:
    """Displacements (t, o, 3) of the rigid obstacles in an explicit run."""
    if not system.rigid_contacts:
        return np.zeros((len(solution.times), 0, 3))
    return solution.series[OBSTACLES].reshape(len(solution.times), -1, 6)[:, :, :3]


def obstacle_shape(obstacle: Obstacle, seen: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """Points (n, 3) and triangles (m, 3) of an obstacle at its initial position.

    seen : (k, 3) points of the moving bodies, which determine the drawn extent of a plane or cylinder
    """
    if isinstance(obstacle, RigidPlane):
        return _patch(obstacle, seen)
    if isinstance(obstacle, RigidCylinder):
        return _tube(obstacle, seen)
    assert isinstance(obstacle, RigidSphere)
    return _ball(obstacle)


def _across(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit directions normal to a unit vector."""
    _, _, rows = np.linalg.svd(axis[None])
    return rows[1], rows[2]


def _patch(plane: RigidPlane, seen: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """A square in the plane, centred on the projection of the moving points and twice as wide."""
    normal, point = np.array(plane.normal), np.array(plane.point)
    first, second = _across(normal)
    shadow = np.column_stack([(seen - point) @ first, (seen - point) @ second])
    low, high = shadow.min(axis=0), shadow.max(axis=0)
    half = max(float((high - low).max()), 0.1 * float(np.ptp(seen, axis=0).max()))
    middle = point + 0.5 * (low + high) @ np.stack([first, second])
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    return np.array([middle + a * first + b * second for a, b in corners]), np.array([(0, 1, 2), (0, 2, 3)])


def _tube(cylinder: RigidCylinder, seen: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    axis, point = np.array(cylinder.axis), np.array(cylinder.point)
    first, second = _across(axis)
    along = (seen - point) @ axis
    angle = np.linspace(0, 2 * np.pi, _AROUND + 1)
    rim = cylinder.radius * (np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second)
    ends = point + np.array([along.min(), along.max()])[:, None] * axis
    return (ends[:, None] + rim).reshape(-1, 3), _grid(2, _AROUND + 1)


def _ball(sphere: RigidSphere) -> tuple[FloatArray, NDArray[np.int64]]:
    latitude = np.linspace(0, np.pi, _UP + 1)[:, None]
    longitude = np.linspace(0, 2 * np.pi, _AROUND + 1)
    x, y = np.sin(latitude) * np.cos(longitude), np.sin(latitude) * np.sin(longitude)
    unit = np.stack(np.broadcast_arrays(x, y, np.cos(latitude)), axis=-1)
    return np.array(sphere.centre) + sphere.radius * unit.reshape(-1, 3), _grid(_UP + 1, _AROUND + 1)


def _grid(rows: int, columns: int) -> NDArray[np.int64]:
    """Two triangles in each cell of a grid of rows x columns points."""
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (
        part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
