"""Motion of the places a case asks to track, in space and against their body's first interface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from supple.body import FullBody, RigidBody, in_space
from supple.integrate import FloatingMotion, Solution
from supple.machine import System
from supple.mesh import Mesh
from supple.reduction import ReducedBody
from supple.results import displacement_from_axes, node_displacements, node_positions


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """A place of a body over time.

    place : str              BODY.INTERFACE or BODY.NODE_SET (the mean of its nodes)
    position : (t, 3)        global, m
    seen_from : str          the body's first interface, or "" when the body has none to look from
    deflection : (t, 3)      displacement as seen from there, in the mesh axes that turn with it, m
    """

    place: str
    position: np.ndarray
    seen_from: str
    deflection: np.ndarray


def track(place: str, system: System, meshes: Mapping[str, Mesh], solution: Solution) -> TrackedMotion:
    """Motion of one place, `r = R + A (x + u)`, and its deflection `A_p^T (r - r_p) - (x - x_p)`.

    p is the body's first interface, with its own axes A_p: what is seen from there does not depend on the
    choice of the floating frame.
    """
    name, _, where = place.partition(".")
    body = system.bodies[system.body_index(name)].body
    motion = solution.bodies[name]
    if isinstance(body, RigidBody):
        position = _in_space(motion, np.tile(body.interface(where).position, (len(solution.times), 1)))
        return TrackedMotion(place, position, "", np.zeros(position.shape))
    rest, displacement = _relative(body, where, motion, meshes)
    position = _in_space(motion, rest + displacement)
    if not body.interfaces:
        return TrackedMotion(place, position, "", displacement)
    origin, axes = _base_axes(body, motion)
    base = body.interfaces[0]
    deflection = displacement_from_axes(position, origin, axes, rest - base.position)
    return TrackedMotion(place, position, base.name, deflection)


def deflections(body: ReducedBody | FullBody, motion: FloatingMotion) -> np.ndarray:
    """Displacements (t, N, 3) of all nodes seen from the body's first interface, or else from its frame."""
    if not body.interfaces:
        return node_displacements(body, motion.coordinates)
    origin, axes = _base_axes(body, motion)
    seen = np.einsum("tji,tnj->tni", axes, node_positions(body, motion) - origin[:, None])
    return seen - (body.nodes - body.interfaces[0].position)


def _base_axes(body: ReducedBody | FullBody, motion: FloatingMotion) -> tuple[np.ndarray, np.ndarray]:
    """Position (t, 3) and axes (t, 3, 3) in space of the first interface."""
    base = body.interfaces[0]
    base_motion = motion.coordinates @ base.motion.T
    origin = _in_space(motion, base.position + base_motion[:, :3])
    return origin, motion.rotation @ Rotation.from_rotvec(base_motion[:, 3:]).as_matrix()


def _in_space(motion: FloatingMotion, local: np.ndarray) -> np.ndarray:
    return in_space(motion.position, motion.rotation, local[:, None])[:, 0]


def _relative(
    body: ReducedBody | FullBody, where: str, motion: FloatingMotion, meshes: Mapping[str, Mesh]
) -> tuple[np.ndarray, np.ndarray]:
    """Rest position (3,) and displacement (t, 3) in the floating frame."""
    for interface in body.interfaces:
        if interface.name == where:
            return interface.position, (motion.coordinates @ interface.motion.T)[:, :3]
    nodes = meshes[body.name].nodes_of(where)
    return body.nodes[nodes].mean(axis=0), node_displacements(body, motion.coordinates, nodes).mean(axis=1)
