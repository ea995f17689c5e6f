"""Nodes in contact, drawn slightly in front of the surface that they touch.

A penalty contact has a small penetration, and faces in contact coincide. Without the shift, the visible face
would change from frame to frame, and a tip would show through a wall.
"""

from __future__ import annotations

from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np

from supple.arrays import FloatArray
from supple.machine import System
from supple.machine.obstacles import Obstacle
from supple.mesh.outer_faces import is_shell, outer_triangles
from supple.methods.explicit.march.touching_surface import projected, touching_surface

CLEARANCE = 5e-4
"""Distance of drawn nodes from the touched surface, relative to the largest extent of the bodies: about
a third of a pixel of an animation."""


def clear_of_contact(
    system: System, positions: Mapping[str, FloatArray], offsets: FloatArray
) -> dict[str, FloatArray]:
    """Positions (t, N, 3) by part, with nodes in contact moved in front of the surface that they touch.

    offsets : (t, o, 3) of the obstacles of the rigid contacts
    """
    shown = {name: own.copy() for name, own in positions.items()}
    clear = CLEARANCE * float(np.ptp(np.concatenate([own[0] for own in shown.values()]), axis=0).max())
    for number, contact in enumerate(system.rigid_contacts):
        nodes, own = system.node_numbers(contact.nodes), shown[contact.nodes.body]
        own[:, nodes] = _before(contact.obstacle, own[:, nodes], offsets[:, number, None], clear)
    for contact in system.surface_contacts:
        first, second = contact.nodes.body, contact.surface.body
        nodes = system.node_numbers(contact.nodes)
        mesh = system.mesh_of(second)
        faces = outer_triangles(mesh, system.node_numbers(contact.surface))
        surface = None
        for mine, theirs in zip(shown[first], shown[second], strict=True):
            x = np.concatenate([theirs, mine[nodes]])
            numbers = len(theirs) + np.arange(len(nodes))
            centre = mine.mean(axis=0) if is_shell(mesh) else None
            surface = surface or touching_surface(numbers, np.ones(len(nodes)), faces, x, centre)
            at = projected(surface, jnp.asarray(x.T))
            gap = np.asarray(at.gap)
            depth = np.where(gap > -float(surface.reach), np.maximum(clear - gap, 0.0), 0.0)
            mine[nodes] += (depth * np.asarray(at.normals)).T
    return shown


def _before(obstacle: Obstacle, points: FloatArray, offsets: FloatArray, clear: float) -> FloatArray:
    """Points (t, n, 3) moved out of an obstacle with offsets (t, 1, 3)."""
    flat = (points - offsets).reshape(-1, 3)
    gap, normals = (np.asarray(each) for each in obstacle.gap(jnp.asarray(flat.T)))
    return points + (np.maximum(clear - gap, 0.0) * normals).T.reshape(points.shape)
