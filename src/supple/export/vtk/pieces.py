"""What of a machine is drawn: its bodies, and its joints as points."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.body import BodyForm, RigidBody, in_space
from supple.errors import ModelError, did_you_mean
from supple.export.vtk.cells import LINE, TRIANGLE, VERTEX, Cells, cells_of
from supple.integrate import FloatingMotion, Solution
from supple.machine import GROUND, Placed, System
from supple.mesh import Mesh

Array = NDArray[np.float64]

JOINTS = "joints"
"""Name of the piece of all joints."""

_AROUND, _UP = 24, 12
"""Points on an ellipsoid of inertia."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of the picture, with cells that do not change.

    name : str
    points : (N, 3)             global, where they stand when the machine is put together, undeformed
    cells : Cells
    positions : of a Solution   (t, N, 3), global
    body : BodyForm | None      whose nodes the points are; None of rigid bodies and joints
    mesh : Mesh | None          whose cells these are
    """

    name: str
    points: Array
    cells: Cells
    positions: Callable[[Solution], Array]
    body: BodyForm | None = None
    mesh: Mesh | None = None


def pieces_of(
    system: System, meshes: Mapping[str, Mesh], bodies: Collection[str] | None = None
) -> tuple[Piece, ...]:
    """The bodies of a machine and its joints; or some bodies alone.

    A body with a mesh has its cells; one without is the points of its nodes. A rigid body is the ellipsoid
    of the same mass and inertia and of even density, and lines from its centre of mass to its interfaces. A
    joint is a point at its second end, or at its first where the second is the ground.

    Raises ModelError for a body that is not there, or none.
    """
    known = [placed.body.name for placed in system.bodies]
    for name in bodies or ():
        if name not in known:
            raise ModelError(
                f"no body '{name}' to write{did_you_mean(name, known)}; there are: {', '.join(known)}"
            )
    wanted = known if bodies is None else [name for name in known if name in bodies]
    if not wanted:
        raise ModelError("no body is chosen; name one at least, or none to write them all")
    rigid = system.bodies_of(RigidBody)
    found = [
        _rigid_piece(system.placed(name), rigid[name])
        if name in rigid
        else _elastic_piece(system.placed(name), meshes.get(name))
        for name in wanted
    ]
    joints = _joints_piece(system) if bodies is None else None
    return tuple(found) if joints is None else (*found, joints)


def _at_rest(placed: Placed, local: Array) -> Array:
    position, rotation = placed.assembly
    return position + local @ rotation.T


def _elastic_piece(placed: Placed, mesh: Mesh | None) -> Piece:
    body: Any = placed.body
    vertices = (VERTEX, np.arange(len(body.nodes))[:, None])
    cells = Cells.of(vertices) if mesh is None else cells_of(mesh)
    return Piece(
        body.name,
        _at_rest(placed, body.nodes),
        cells,
        lambda part: body.positions(part.bodies[body.name]),
        body,
        mesh,
    )


def _rigid_piece(placed: Placed, body: RigidBody) -> Piece:
    surface, triangles = _ellipsoid(body)
    local = np.concatenate([surface, body.centre[None], body.nodes])
    centre = len(surface)
    ends = centre + 1 + np.arange(len(body.nodes))
    lines = np.column_stack([np.full(len(ends), centre), ends])

    def positions(part: Solution) -> Array:
        motion = part.motion(body.name, FloatingMotion)
        return in_space(motion.position, motion.rotation, local[None])

    return Piece(
        body.name, _at_rest(placed, local), Cells.of((TRIANGLE, triangles), (LINE, lines)), positions
    )


def _ellipsoid(body: RigidBody) -> tuple[Array, NDArray[np.int64]]:
    """Points and triangles of the solid ellipsoid of even density with the body's mass and inertia.

    Of the principal moments I_k its half axes are `a_k^2 = 5 / (2 m) (I_1 + I_2 + I_3 - 2 I_k)`.
    """
    moments, axes = np.linalg.eigh(body.inertia)
    half = np.sqrt(np.maximum(5 / (2 * body.mass) * (moments.sum() - 2 * moments), 0.0))
    up, around = np.meshgrid(
        np.linspace(0, np.pi, _UP + 1), np.linspace(0, 2 * np.pi, _AROUND, endpoint=False), indexing="ij"
    )
    unit = np.stack([np.sin(up) * np.cos(around), np.sin(up) * np.sin(around), np.cos(up)], axis=-1)
    number = np.arange(unit[..., 0].size).reshape(_UP + 1, _AROUND)
    a, b = number[:-1], np.roll(number, -1, axis=1)[:-1]
    c, d = np.roll(number, -1, axis=1)[1:], number[1:]
    # At the poles one side of each mesh has no length.
    triangles = [np.stack([a[1:], d[1:], b[1:]], axis=-1), np.stack([b[:-1], d[:-1], c[:-1]], axis=-1)]
    return (
        body.centre + (unit.reshape(-1, 3) * half) @ axes.T,
        np.concatenate([each.reshape(-1, 3) for each in triangles]),
    )


def _joints_piece(system: System) -> Piece | None:
    ends = [joint.first if joint.second == GROUND else joint.second for joint in system.joints]
    if not ends:
        return None

    def positions(part: Solution) -> Array:
        def places() -> Iterator[Array]:
            for end in ends:
                body: Any = system.placed(end.body).body
                yield body.interface_motion(part.bodies[end.body], end.interface).position

        return np.stack(list(places()), axis=1)

    return Piece(
        JOINTS,
        np.stack([system.initial_point(end) for end in ends]),
        Cells.of((VERTEX, np.arange(len(ends))[:, None])),
        positions,
    )
