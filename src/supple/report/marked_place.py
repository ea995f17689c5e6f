"""Points of a machine that are marked in the page: joints, ends of springs, loads, contacts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm
from supple.integrate import Solution
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    ForceElement,
    NodalLoad,
    Pose,
    SphereContact,
    System,
    TimeLaw,
)
from supple.quantities import contact_forces, node_positions
from supple.quantities.end_motion import both_ends
from supple.value_content import UserFunction


@dataclass(frozen=True, eq=False)
class MarkedPlace:
    """A point with axes, over time.

    body : "" for the ground;   points : (t, 3) in space
    rest : (3,) undeformed, mesh axes of the body; for the ground, the first of the points
    axes : (t, 3, 3) in space, as columns
    """

    body: str
    points: FloatArray
    rest: FloatArray
    axes: FloatArray


@dataclass(frozen=True, eq=False)
class Link:
    """A joint, or a force element such as a spring, and the points of its ends.

    kind : description of a joint; "" for a force element
    """

    name: str
    kind: str
    first: MarkedPlace
    second: MarkedPlace


@dataclass(frozen=True, eq=False)
class Arrow:
    """A force, a moment or a contact force at a point.

    kind : "force", "moment" or "contact";   values : (t, 3) in space
    """

    name: str
    kind: str
    place: MarkedPlace
    values: FloatArray


def joint_marks(system: System, solution: Solution) -> Iterator[Link]:
    """Both ends of every joint, each with the joint axes that rotate with it."""
    for joint in system.joints:
        first, second = both_ends(system, solution, joint, joint.name)
        kind = "".join(f" {c.lower()}" if c.isupper() else c for c in type(joint).__name__).strip()
        yield Link(joint.name, kind, _place(system, joint.first, first), _place(system, joint.second, second))


def links_of(system: System, solution: Solution) -> Iterator[Link]:
    """Force elements between two points except contacts, including those driven by controllers."""
    for load in system.acting:
        if isinstance(load, ForceElement) and not _is_arrow(load):
            first, second = both_ends(system, solution, load, load.label)
            yield Link(load.label, "", _place(system, load.first, first), _place(system, load.second, second))


def arrows_of(system: System, solution: Solution) -> Iterator[Arrow]:
    """Forces and torques at one interface, or at some nodes, and contact forces, over time."""
    for load in system.loads:
        if isinstance(load, NodalLoad):
            yield _arrow_of_nodes(system, solution, load)
        elif isinstance(load, ForceElement) and _is_arrow(load):
            yield from _arrows_of_element(system, solution, load)
    axes = np.broadcast_to(np.eye(3), (len(solution.times), 3, 3))
    for contact in contact_forces(system, solution):
        place = MarkedPlace("", contact.place, contact.place[0], axes)
        yield Arrow(contact.name, "contact", place, contact.force)


def _is_arrow(load: ForceElement) -> bool:
    return load.acts_on_first_alone or isinstance(load, SphereContact)


def _arrows_of_element(system: System, solution: Solution, load: ForceElement) -> Iterator[Arrow]:
    """Force and moment on the first end of an element, or on the second if the first is on the ground."""
    ends = both_ends(system, solution, load, load.label)
    at = (load.first, load.second)
    own = 1 if load.first == GROUND else 0
    wrenches = np.asarray(
        _wrenches(UserFunction(type(load)), load.law, load.parameters, *ends, solution.times)
    )[:, own]
    place = _place(system, at[own], ends[own])
    if isinstance(load, SphereContact):
        yield Arrow(load.label, "contact", place, wrenches[:, :3])
        return
    for kind, values in (("force", wrenches[:, :3]), ("moment", wrenches[:, 3:])):
        if values.any():
            yield Arrow(load.label, kind, place, values)


@partial(jax.jit, static_argnums=0)
def _wrenches(
    of: UserFunction,
    law: TimeLaw | None,
    parameters: tuple[ArrayLike, ...],
    first: Pose,
    second: Pose,
    times: FloatArray,
) -> jax.Array:
    kind: Any = of.function

    def at(one: Pose, other: Pose, time: jax.Array) -> jax.Array:
        value = None if law is None else law(time)
        wrenches = kind.wrenches(one, other, value, parameters)
        return jnp.stack([jnp.concatenate([each.force, each.moment]) for each in wrenches])

    return jax.vmap(at)(first, second, jnp.asarray(times))


def _place(system: System, end: At, pose: Pose) -> MarkedPlace:
    points, axes = np.asarray(pose.point), np.asarray(pose.axes)
    if end == GROUND:
        return MarkedPlace("", points, points[0], axes)
    return MarkedPlace(end.body, points, system.placed(end.body).body.interface(end.interface).position, axes)


def _arrow_of_nodes(system: System, solution: Solution, load: NodalLoad) -> Arrow:
    """The sum of the forces of a nodal load, at its interface or at the mean of its nodes."""
    body: BodyForm = system.placed(load.body).body
    motion = solution.bodies[load.body]
    if isinstance(load, DeadForce) and isinstance(load.at, str):
        places = body.interface_motion(motion, load.at).position[:, None]
        rest = body.interface(load.at).position
    else:
        places, rest = node_positions(body, motion, load.nodes), body.nodes[load.nodes].mean(axis=0)
    dimensions = len(load.value_shapes[0])
    values = np.asarray(_sums(type(load), dimensions, load.law, load.facets, places, solution.times))
    points = places.mean(axis=1)
    axes = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    return Arrow(load.label, "force", MarkedPlace(load.body, points, rest, axes), values)


@partial(jax.jit, static_argnums=(0, 1))
def _sums(
    kind: type[NodalLoad],
    dimensions: int,
    law: TimeLaw,
    facets: IntArray,
    places: FloatArray,
    times: FloatArray,
) -> jax.Array:
    """Sums (t, 3) of the forces on all facets with nodes at positions (t, k, 3) in space.

    dimensions : number of axes of the law's value for one facet; separate values per facet add one axis
    """

    def at(instant: tuple[jax.Array, jax.Array]) -> jax.Array:
        corners, time = instant
        value = jnp.asarray(law(time), dtype=float)
        of_each = 0 if value.ndim > dimensions else None
        forces = jax.vmap(kind.facet_forces, (0, None, of_each))(corners[facets], jnp.eye(3), value)
        return forces.sum(axis=(0, 1))

    return jax.lax.map(at, (jnp.asarray(places), jnp.asarray(times)))
