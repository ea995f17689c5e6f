"""A machine at some output times as one scene: bodies, obstacles, glyphs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm
from supple.errors import ModelError
from supple.integrate import Motion, Solution
from supple.machine import At, RigidPlane, System
from supple.mesh.skin import Skin
from supple.quantities import deflections, node_positions, observer_of
from supple.quantities.tracked_motion import Observer
from supple.results.body_surface import BodySurface, Look, body_surface
from supple.results.camera import Camera
from supple.results.colouring import Colouring
from supple.results.obstacle_shape import obstacle_offsets, obstacle_shape
from supple.units import UNNAMED, UnitSystem
from supple.viz.contact_clearance import clear_of_contact
from supple.viz.glyphs import POINT_STYLE, Glyphs, Mark, glyphs_of, surface_glyphs
from supple.viz.scene import Actor, obstacle_actor, scene_of

_EDGE_ON = 0.05
"""Least cosine of the angle between the normal of a wall and the direction to the viewer.

Below it, the wall is viewed edge-on or from behind, and is drawn as an outline.
"""


@dataclass(frozen=True, eq=False)
class MachineScene:
    """Bodies and obstacles as one skin, and glyphs of parts without a mesh, at t times.

    skin : None if no body has a surface;  positions : (t, P, 3)
    values : (t, P), NaN for the plain colour of surfaces
    label : name of the values with their unit, "" without colours
    glyphs : may be empty
    undeformed : (P, 3) positions of the undeformed bodies at the first of the times
    farthest : for each deformable body, the node of largest deflection
    """

    skin: Skin | None
    positions: FloatArray
    values: FloatArray | None
    label: str
    glyphs: Glyphs
    undeformed: FloatArray
    farthest: Mapping[str, int]

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to draw."""
        return self.skin is None and self.glyphs.is_empty


@dataclass(frozen=True, eq=False)
class _Seen:
    """A body at the times of a scene.

    nodes : (t, N, 3) positions to draw;  observer : None without a frame
    """

    body: BodyForm
    surface: BodySurface | None
    motion: Motion
    observer: Observer | None
    nodes: FloatArray


def machine_scene(
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    rows: IntArray,
    camera: Camera,
    *,
    enlargement: float = 1.0,
    colouring: Colouring | None = None,
    rest: Solution | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> MachineScene:
    """The scene of a machine at output times (t,).

        x = r + e (x(t) - r),   r the undeformed position, moved with the reference interface of deflections

    enlargement : e;  colouring : None leaves bodies plain
    rest : solution whose first time is drawn as the undeformed state
    Other parameters as for `draw_run`.
    Raises ModelError for an enlargement of bodies without a frame.
    """
    seen = _seen(system, solution, meshes, rows, bases)
    offsets = obstacle_offsets(system, solution)[rows]
    if system.contacts:
        shown = clear_of_contact(system, {each.body.name: each.nodes for each in seen}, offsets)
        seen = [replace(each, nodes=shown[each.body.name]) for each in seen]
    label, factor = ("", 1.0) if colouring is None else colouring.label(units)
    actors, undeformed, farthest = [], [np.empty((0, 3))], {}
    glyphs = [glyphs_of(system, solution, rows)]
    for each in seen:
        nodes = _enlarged(each.nodes, each, each.body.nodes, enlargement)
        if each.surface is None:
            glyphs.append(Glyphs(np.empty((len(nodes), 0, 2, 3)), (Mark(POINT_STYLE, nodes),)))
            continue
        deflection = None
        if each.observer is not None:
            deflection = np.linalg.norm(deflections(each.body, each.motion, each.observer), axis=2)
            farthest[each.body.name] = int(np.argmax(deflection.max(axis=0)))
        values = None if colouring is None else colouring.values(each.body, each.motion, deflection)
        places = each.surface.positions(each.body, each.motion, each.nodes)
        actors.append(
            Actor(
                each.surface.skin,
                _enlarged(places, each, each.surface.rest, enlargement),
                None if values is None else factor * each.surface.at_points(values),
            )
        )
        undeformed.append(_undeformed(each, rest))
        if (own := surface_glyphs(each.surface, nodes)) is not None:
            glyphs.append(own)
    walls, outlines = _obstacles(system, offsets, actors, camera)
    undeformed += [wall.positions[0] for wall in walls]
    scene = scene_of(actors + walls) if actors else None
    coloured = any(actor.values is not None for actor in actors)
    return MachineScene(
        None if scene is None else scene.skin,
        np.empty((len(rows), 0, 3)) if scene is None else scene.positions,
        scene.values if scene is not None and coloured else None,
        label if coloured else "",
        glyphs[0].beside(glyphs[1:] + outlines),
        np.concatenate(undeformed),
        farthest,
    )


def drawn_bodies(
    system: System, meshes: Mapping[str, Look | None]
) -> list[tuple[BodyForm, BodySurface | None]]:
    """Elastic bodies and their surfaces; bodies without a surface are drawn by their nodes.

    Raises ModelError for a mesh of an unknown body.
    """
    for name in meshes:
        system.placed(name, "meshes")  # a misspelt name is an error
    return [
        (body, None if (look := meshes[body.name]) is None else body_surface(look))
        for body in (placed.body for placed in system.bodies)
        if body.n_coordinates and body.name in meshes
    ]


def _undeformed(seen: _Seen, rest: Solution | None) -> FloatArray:
    """Positions (P, 3) of a surface: in a state of rest, or undeformed and moved with the observer.

    Without a state of rest, bodies without a frame have their positions at the first of the times.
    """
    assert seen.surface is not None
    if rest is not None:
        return seen.surface.positions(seen.body, rest.bodies[seen.body.name].at(np.array([0])))[0]
    if seen.observer is None:
        return seen.surface.positions(seen.body, seen.motion)[0]
    return _carried(seen.observer, seen.surface.rest)[0]


def _seen(
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look | None],
    rows: IntArray,
    bases: Mapping[str, At],
) -> list[_Seen]:
    found = []
    for body, surface in drawn_bodies(system, meshes):
        motion = solution.bodies[body.name].at(rows)
        observer = observer_of(system, solution, body.name, bases, rows) if body.has_frame else None
        found.append(_Seen(body, surface, motion, observer, node_positions(body, motion)))
    return found


def _carried(observer: Observer, rest: FloatArray) -> FloatArray:
    """Undeformed positions (P, 3) moved with an interface, (t, P, 3)."""
    return observer.origin[:, None] + np.einsum("tij,pj->tpi", observer.axes, rest - observer.rest)


def _enlarged(places: FloatArray, seen: _Seen, rest: FloatArray, enlargement: float) -> FloatArray:
    if enlargement == 1.0:
        return places
    if seen.observer is None:
        raise ModelError(
            f"body '{seen.body.name}' is in explicit elements, whose motion and deformation are "
            "not separated: draw it true to scale (leave out the enlargement)"
        )
    carried = _carried(seen.observer, rest)
    return carried + enlargement * (places - carried)


def _obstacles(
    system: System, offsets: FloatArray, actors: list[Actor], camera: Camera
) -> tuple[list[Actor], list[Glyphs]]:
    """Obstacles as surfaces, but walls viewed from behind as outlines.

    Such walls would hide the bodies that touch them.
    """
    surfaces, outlines = [], []
    if not system.rigid_contacts:
        return surfaces, outlines
    moved = np.concatenate([actor.positions.reshape(-1, 3) for actor in actors])
    for number, obstacle in enumerate(contact.obstacle for contact in system.rigid_contacts):
        own = offsets[:, number]
        if isinstance(obstacle, RigidPlane) and camera.axes[2] @ np.array(obstacle.normal) < _EDGE_ON:
            corners, _ = obstacle_shape(obstacle, moved)
            rim = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
            outlines.append(Glyphs(np.empty((len(own), 0, 2, 3)), (), rim[None] + own[:, None, None]))
        else:
            surfaces.append(obstacle_actor(obstacle, own, moved))
    return surfaces, outlines
