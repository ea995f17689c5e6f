"""Motion of a place of a body in space, and relative to an interface of this body or of another one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray
from supple.body import BodyForm
from supple.integrate import FramedMotion, Motion, Solution
from supple.machine import At, System
from supple.quantities.place import Place

__all__ = [
    "Observer",
    "TrackedMotion",
    "deflections",
    "displacement_from_axes",
    "node_positions",
    "observer",
    "observer_of",
    "tracked_motion",
    "tracked_places",
]


def node_positions(body: BodyForm, motion: Motion, nodes: ArrayLike | slice = slice(None)) -> FloatArray:
    """Positions (t, k, 3) in space of all or some nodes (k,).

    Raises
    ------
    ModelError  a node number outside the body
    Source: [Wu2019] (1)
    """
    return body.positions(motion, nodes)


def displacement_from_axes(
    positions: FloatArray, origin: ArrayLike, rotation: FloatArray, rest: ArrayLike
) -> FloatArray:
    """Displacement A^T (r - R) - q_0 of points relative to moving axes.

    The tip displacement of [Wu2019] (51) is relative to the axes of the driven root. It is therefore the same
    for any floating frame of the body.

    Parameters
    ----------
    positions : array (t, ..., 3)   r, in space
    origin : array                  R, in space, of a shape that broadcasts with the positions
    rotation : array (t, 3, 3)      A, axes to space
    rest : array (..., 3)           q_0, undeformed positions of the points in the axes

    Returns
    -------
    array (t, ..., 3)
    """
    return np.einsum("tji,t...j->t...i", rotation, positions - np.asarray(origin)) - np.asarray(rest)


class Observer(NamedTuple):
    """Motion of the reference interface of deflections, with axes that rotate with the interface.

    rest : (3,)         position of the interface at assembly, mesh axes of the observed body
    origin : (t, 3)     position of the interface in space
    axes : (t, 3, 3)    mesh axes of the observed body, rotated with the interface, as columns
    is_elsewhere : bool     whether the interface is on another body
    """

    name: str
    rest: FloatArray
    origin: FloatArray
    axes: FloatArray
    is_elsewhere: bool = False


def observer(body: BodyForm, motion: Motion, interface: str | None = None) -> Observer:
    """Motion of an interface, by default the first; for a body without interfaces, motion of its frame.

    Raises ModelError for an interface that the body does not have.
    """
    if interface is None and not body.interfaces:
        own = motion.of_type(FramedMotion)
        return Observer("", np.zeros(3), own.position, own.rotation)
    seen_from = body.interfaces[0] if interface is None else body.interface(interface)
    moving = body.interface_motion(motion, seen_from.name)
    return Observer(seen_from.name, seen_from.position, moving.position, moving.rotation)


def observer_of(
    system: System,
    solution: Solution,
    body: str,
    bases: Mapping[str, At] = MappingProxyType({}),
    rows: slice | np.ndarray = slice(None),
) -> Observer | None:
    """Motion of the reference of a body's deflections: its first interface, or the one given in `bases`.

    For a part of a split body, `bases` gives the first interface of the whole body, which may be on another
    part.

    bases : reference interfaces, by body name
    rows : indices of the output times; all by default
    Returns None for a body without a frame, unless an interface is given.
    """
    base, own = bases.get(body), system.placed(body)
    if base is None:
        return observer(own.body, solution.bodies[body].at(rows)) if own.body.has_frame else None
    other = system.placed(base.body)
    seen = observer(other.body, solution.bodies[base.body].at(rows), base.interface)
    if base.body == body:
        return seen
    # From the mesh axes of the other body to those of this body, as both are placed at assembly.
    apart = other.assembly.position - own.assembly.position
    return Observer(
        f"{base.body}.{base.interface}",
        own.assembly.rotation.T @ (apart + other.assembly.rotation @ seen.rest),
        seen.origin,
        seen.axes @ (other.assembly.rotation.T @ own.assembly.rotation),
        is_elsewhere=True,
    )


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """Motion of a place of a body.

    position : (t, 3)        in global axes, unit of length
    seen_from : str          name of the reference interface, as `BODY.INTERFACE` if it is on another body;
          "" without a reference
    deflection : (t, 3)      displacement relative to this interface, in the mesh axes that rotate with it.
          Zero for a rigid body if the interface is on this body; zero for a body without a frame if no
          interface is given
    is_elastic : bool        whether the body deforms relative to a frame
    """

    position: FloatArray
    seen_from: str
    deflection: FloatArray
    is_elastic: bool = True


def tracked_motion(
    body: BodyForm, motion: Motion, at: str | ArrayLike, seen_from: Observer | None = None
) -> TrackedMotion:
    """Position `r = R + A (x + u)` of one place, and its deflection `A_p^T (r - r_p) - (x - x_p)`.

    R and A are the origin and rotation of the body's frame, x the undeformed position and u the displacement.
    p is the body's first interface, with axes A_p: the deflection does not depend on the floating frame.

    Parameters
    ----------
    motion : of the body, at t times
    at : name of an interface, or node numbers (k,), whose mean is used
    seen_from : reference p if not the first interface: an interface of any body, at the same times

    Raises
    ------
    ModelError  a node number outside the body, or an interface that the body does not have
    """
    place = Place(body.name, at if isinstance(at, str) else tuple(np.asarray(at).tolist()))
    position = place.point(body, motion)
    is_elastic = bool(body.n_coordinates and body.has_frame)
    if not is_elastic and (seen_from is None or not (body.n_coordinates or seen_from.is_elsewhere)):
        return TrackedMotion(position, "", np.zeros_like(position), is_elastic=False)
    seen_from = seen_from or observer(body, motion)
    rest = place.rest(body) - seen_from.rest
    deflection = displacement_from_axes(position, seen_from.origin, seen_from.axes, rest)
    return TrackedMotion(position, seen_from.name, deflection, is_elastic)


def tracked_places(
    system: System,
    solution: Solution,
    places: Mapping[str, Place],
    bases: Mapping[str, At] = MappingProxyType({}),
) -> dict[str, TrackedMotion]:
    """Motions of places by their names, as from `tracked_motion`.

    bases : as for `observer_of`
    """
    return {
        name: tracked_motion(
            system.placed(place.body).body,
            solution.bodies[place.body],
            place.at,
            observer_of(system, solution, place.body, bases),
        )
        for name, place in places.items()
    }


def deflections(body: BodyForm, motion: Motion, seen_from: Observer | None = None) -> FloatArray:
    """Displacements (t, N, 3) of all nodes, relative to the first interface; without one, to the frame.

    seen_from : reference if not the first interface; an interface of this or another body, at the same times
    """
    seen_from = seen_from or observer(body, motion)
    origin, rest = seen_from.origin[:, None], body.nodes - seen_from.rest
    return displacement_from_axes(body.positions(motion), origin, seen_from.axes, rest)
