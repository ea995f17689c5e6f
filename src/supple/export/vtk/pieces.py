"""Grids of a machine: one per body, and the joints as points."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.arrays import FloatArray
from supple.body import BodyForm, RigidBody, in_space
from supple.errors import ModelError, did_you_mean
from supple.export.vtk.cells import LINE, TRIANGLE, VERTEX, Cells, vtk_cells
from supple.integrate import FloatingMotion, Solution
from supple.machine import GROUND, Placed, System
from supple.mesh import Mesh

JOINTS = "joints"
"""Name of the piece of all joints."""

_AROUND, _UP = 24, 12
"""Numbers of points on the ellipsoid of a rigid body."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Points and cells of a body, or of all joints; the cells do not change with time.

    points : (N, 3)             global positions in the assembled, undeformed machine
    positions : function        Solution -> global positions (t, N, 3)
    body : BodyForm | None      the body whose nodes are the points; None for rigid bodies and joints
    mesh : Mesh | None          the mesh with these cells
    """

    name: str
    points: FloatArray
    cells: Cells
    positions: Callable[[Solution], FloatArray]
    body: BodyForm | None = None
    mesh: Mesh | None = None


def pieces_of(
    system: System, meshes: Mapping[str, Mesh], bodies: Collection[str] | None = None
) -> tuple[Piece, ...]:
    """The pieces of all bodies of a machine and of its joints, or of some bodies only.

    A body with a mesh has the cells of the mesh; a body without a mesh has its nodes as points. A rigid body
    is drawn as the ellipsoid of uniform density with the same mass and inertia, and as lines from its centre
    of mass to its interfaces. A joint is a point at its second end, or at its first end if the second is the
    ground.

    Raises ModelError for an unknown body, no body, or a mesh of another body.
    """
    known = [placed.body.name for placed in system.bodies]
    for name in bodies or ():
        if name not in known:
            raise ModelError(
                f"no body '{name}' to write{did_you_mean(name, known)}; there are: {', '.join(known)}"
            )
    for name in meshes:
        system.placed(name, "meshes")  # a misspelt name is an error
    wanted = known if bodies is None else [name for name in known if name in bodies]
    if not wanted:
        raise ModelError(
            "the list of bodies to write is empty: name at least one, or omit the list to write all"
        )
    rigid = system.bodies_of(RigidBody)
    found = [
        _rigid_piece(system.placed(name), rigid[name])
        if name in rigid
        else _elastic_piece(system.placed(name), meshes.get(name))
        for name in wanted
    ]
    if bodies is None and system.joints:
        found.append(_joints_piece(system))
    return tuple(found)


def _at_rest(placed: Placed, local: FloatArray) -> FloatArray:
    position, rotation = placed.assembly
    return position + local @ rotation.T


def _elastic_piece(placed: Placed, mesh: Mesh | None) -> Piece:
    body = placed.body
    if mesh is not None and mesh.n_nodes > len(body.nodes):
        raise ModelError(
            f"the mesh given for body '{body.name}' has {mesh.n_nodes} nodes and the body {len(body.nodes)}: "
            "give the mesh of which the body was made"
        )
    vertices = (VERTEX, np.arange(len(body.nodes))[:, None])
    cells = Cells.of(vertices) if mesh is None else vtk_cells(mesh)
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

    def positions(part: Solution) -> FloatArray:
        motion = part.motion(body.name, FloatingMotion)
        return in_space(motion.position, motion.rotation, local[None])

    return Piece(
        body.name, _at_rest(placed, local), Cells.of((TRIANGLE, triangles), (LINE, lines)), positions
    )


def _ellipsoid(body: RigidBody) -> tuple[FloatArray, NDArray[np.int64]]:
    """Points and triangles of the solid ellipsoid of uniform density with the body's mass and inertia.

    With the principal moments I_k, its semi-axes are `a_k^2 = 5 / (2 m) (I_1 + I_2 + I_3 - 2 I_k)`.
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
    # At the poles one side of each quadrilateral has zero length.
    triangles = [np.stack([a[1:], d[1:], b[1:]], axis=-1), np.stack([b[:-1], d[:-1], c[:-1]], axis=-1)]
    return (
        body.centre + (unit.reshape(-1, 3) * half) @ axes.T,
        np.concatenate([each.reshape(-1, 3) for each in triangles]),
    )


def _joints_piece(system: System) -> Piece:
    ends = [joint.first if joint.second == GROUND else joint.second for joint in system.joints]

    def positions(part: Solution) -> FloatArray:
        bodies = [(system.placed(end.body).body, part.bodies[end.body], end.interface) for end in ends]
        return np.stack([body.interface_motion(own, name).position for body, own, name in bodies], axis=1)

    return Piece(
        JOINTS,
        np.stack([system.initial_point(end) for end in ends]),
        Cells.of((VERTEX, np.arange(len(ends))[:, None])),
        positions,
    )
