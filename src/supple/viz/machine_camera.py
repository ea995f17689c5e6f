"""The camera for all pictures and animations of one run."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from supple.arrays import FloatArray
from supple.integrate import Solution
from supple.machine import RigidPlane, System
from supple.quantities import node_positions
from supple.results.body_surface import Look
from supple.results.camera import Camera
from supple.viz.glyphs import glyphs_of

_INSTANTS, _NODES = 20, 500
"""Numbers of output times, and of nodes of each body, that represent the extent of a motion."""
_IN_FRONT = 0.1
"""Least cosine of the angle between the normal of a wall and the direction to the viewer."""


def machine_camera(system: System, solution: Solution, meshes: Mapping[str, Look | None]) -> Camera:
    """Camera with gravity downwards and the widest extent of the motion horizontal.

    If possible, all walls are viewed from the side on which bodies touch them.
    """
    rows = np.unique(np.linspace(0, len(solution.times) - 1, _INSTANTS).astype(int))
    points = [glyphs_of(system, solution, rows).points]
    for body in (placed.body for placed in system.bodies):
        if body.n_coordinates and body.name in meshes:
            nodes = np.arange(0, len(body.nodes), -(-len(body.nodes) // _NODES))
            points.append(node_positions(body, solution.bodies[body.name].at(rows), nodes))
    walls = [
        contact.obstacle.normal
        for contact in system.rigid_contacts
        if isinstance(contact.obstacle, RigidPlane)
    ]
    seen = np.concatenate(points, axis=1).reshape(-1, 3)
    return upright_camera(seen, system.gravity, np.reshape(walls, (-1, 3)))


def upright_camera(points: FloatArray, gravity: FloatArray, walls: FloatArray) -> Camera:
    """The camera for points (n, 3) and for walls with normals (w, 3), which point towards the bodies."""
    if not len(points):
        points = np.eye(3)
    if gravity.any():
        up = -gravity / np.linalg.norm(gravity)
        extent = np.ptp(points, axis=0)
        level = [axis for axis in np.argsort(extent, kind="stable") if abs(up[axis]) < 0.8]
        thin, wide = np.eye(3)[level[:2]]
        parts = thin, 0.35 * wide, 0.25 * up
    else:
        towards = Camera.three_quarter(points).axes[2]
        thin, middle, long = np.argsort(np.ptp(points, axis=0), kind="stable")
        parts = tuple(towards[axis] * np.eye(3)[axis] for axis in (middle, long, thin))
        up = np.eye(3)[thin]
    # From above, if the walls allow it.
    signs = sorted(product((1.0, -1.0), repeat=3), key=lambda each: -each[2])
    sights = [np.array(each) @ np.stack(parts) for each in signs]
    fitting = (each for each in sights if np.all(walls @ each > _IN_FRONT * np.linalg.norm(each)))
    return Camera.looking(along=-next(fitting, sights[0]), up=up)
