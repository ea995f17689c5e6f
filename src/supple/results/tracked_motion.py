"""Motion of a place of a body, in space and against the body's first interface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from supple.body import BodyForm, in_space, node_displacements
from supple.integrate import FloatingMotion, Solution
from supple.intrinsic import IntrinsicBody, IntrinsicMotion
from supple.machine import System
from supple.results.recovery import displacement_from_axes, node_positions


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """A place of a body over time.

    position : (t, 3)        in global axes, unit of length
    seen_from : str          the body's first interface, or "" when the body has none to look from
    deflection : (t, 3)      displacement as seen from there, in the mesh axes that turn with it;
                             zero of a rigid body
    is_elastic : bool        whether the body deforms
    """

    position: np.ndarray
    seen_from: str
    deflection: np.ndarray
    is_elastic: bool = True


def tracked_motion(body: BodyForm, motion: Any, at: str | ArrayLike) -> TrackedMotion:
    """Motion of one place, `r = R + A (x + u)`, and its deflection `A_p^T (r - r_p) - (x - x_p)`.

    p is the body's first interface, with its own axes A_p: what is seen from there does not depend on the
    choice of the floating frame.

    Parameters
    ----------
    motion : FloatingMotion | IntrinsicMotion   of the body, at t times
    at : name of an interface, or node numbers (k,), whose mean is taken

    Raises
    ------
    ModelError  a node number outside the body, an interface that it does not have
    """
    if isinstance(body, IntrinsicBody):
        return _of_line(body, motion, at)
    if isinstance(at, str):
        interface = body.interface(at)
        rest, displacement = interface.position, (motion.coordinates @ interface.motion.T)[:, :3]
    else:
        nodes = np.asarray(at)
        rest = body.nodes[nodes].mean(axis=0)
        displacement = node_displacements(body, motion.coordinates, nodes).mean(axis=1)
    position = _in_space(motion, rest + displacement)
    if not (body.n_coordinates and body.interfaces):
        return TrackedMotion(position, "", displacement, body.n_coordinates > 0)
    origin, axes = _base_axes(body, motion)
    base = body.interfaces[0]
    deflection = displacement_from_axes(position, origin, axes, rest - base.position)
    return TrackedMotion(position, base.name, deflection)


def _of_line(body: IntrinsicBody, motion: IntrinsicMotion, at: str | ArrayLike) -> TrackedMotion:
    """The same of an intrinsic body, at any rotation of its sections."""
    if isinstance(at, str):
        station = body.interface(at)
        rest, position = station.position, body.places(motion)[1][:, station.number]
    else:
        rest = body.nodes[np.asarray(at)].mean(axis=0)
        position = body.positions(motion, at).mean(axis=1)
    origin, axes = _base_axes(body, motion)
    base = body.interfaces[0]
    seen = displacement_from_axes(position, origin, axes, rest - base.position)
    return TrackedMotion(position, base.name, seen)


def tracked_places(
    system: System, solution: Solution, places: Mapping[str, tuple[str, str | ArrayLike]]
) -> dict[str, TrackedMotion]:
    """`tracked_motion` of places by their names; of each the name of its body, and where on the body."""
    return {
        place: tracked_motion(system.bodies[system.body_index(name)].body, solution.bodies[name], at)
        for place, (name, at) in places.items()
    }


def deflections(body: BodyForm, motion: Any) -> np.ndarray:
    """Displacements (t, N, 3) of all nodes seen from the body's first interface, or else from its frame."""
    if not body.interfaces:
        return node_displacements(body, motion.coordinates)
    origin, axes = _base_axes(body, motion)
    seen = np.einsum("tji,tnj->tni", axes, node_positions(body, motion) - origin[:, None])
    return seen - (body.nodes - body.interfaces[0].position)


def _base_axes(body: BodyForm, motion: Any) -> tuple[np.ndarray, np.ndarray]:
    """Position (t, 3) and axes (t, 3, 3) in space of the first interface."""
    if isinstance(body, IntrinsicBody):
        rotations, positions = body.places(motion)
        base = body.interfaces[0].number
        return positions[:, base], rotations[:, base]
    base = body.interfaces[0]
    base_motion = motion.coordinates @ base.motion.T
    origin = _in_space(motion, base.position + base_motion[:, :3])
    return origin, motion.rotation @ Rotation.from_rotvec(base_motion[:, 3:]).as_matrix()


def _in_space(motion: FloatingMotion, local: np.ndarray) -> np.ndarray:
    return in_space(motion.position, motion.rotation, local[:, None])[:, 0]
