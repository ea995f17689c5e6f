"""Axes of materials: *ORIENTATION in rectangular, cylindrical and spherical coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.keywords import LEFT_OUT
from supple.importers.keyword_file import fields, numbers


@dataclass(frozen=True, eq=False)
class Orientation:
    """Axes of a material.

    system : R, C, S or Z;  a, b, c : (3,) points
    axis : local axis (1 to 3) of an additional rotation, 0 without it;  angle : of this rotation, rad
    distributed : orientations of some elements, by element numbers (*DISTRIBUTION); later ones override
    """

    system: str
    a: FloatArray
    b: FloatArray
    c: FloatArray
    axis: int = 0
    angle: float = 0.0
    distributed: tuple[tuple[IntArray, Orientation], ...] = ()

    def axes(self, places: FloatArray, elements: IntArray) -> FloatArray:
        """Axes of the material as columns (n, 3, 3), at positions (n, 3) in elements with numbers (n,)."""
        found = np.array(self._axes(places))
        for members, own in self.distributed:
            mine = np.isin(elements, members)
            found[mine] = own._axes(places[mine])
        return found

    def _axes(self, places: FloatArray) -> FloatArray:
        if self.system == "C":
            axes = cylindrical_axes(self.a, self.b, places)
        elif self.system == "S":
            radial = _unit(places - self.a)
            pole = _unit(self.b - self.a)
            tangent = _unit(np.cross(pole, radial))
            axes = np.stack([radial, tangent, np.cross(radial, tangent)], axis=-1)
        else:
            first = self.a - self.c
            third = np.cross(first, self.b - self.c)
            if self.system == "Z":  # a is on the local z axis, b in the xz plane
                axes = np.column_stack([np.cross(np.cross(first, self.b - self.c), first), third, first])
            else:
                axes = np.column_stack([first, np.cross(third, first), third])
            axes = np.broadcast_to(axes / np.linalg.norm(axes, axis=0), (len(places), 3, 3))
        if not self.axis:
            return axes
        turn: FloatArray = Rotation.from_rotvec(self.angle * np.eye(3)[self.axis - 1]).as_matrix()
        return np.asarray(axes @ turn, dtype=np.float64)

    def shell_directions(self, places: FloatArray, elements: IntArray) -> FloatArray:
        """Vectors (n, 3) to project on a shell: the local axis after `axis` in cyclic order; x if it is 0."""
        normal = self.axis or 3
        return self.axes(places, elements)[:, :, normal % 3]


def cylindrical_axes(a: FloatArray, b: FloatArray, places: FloatArray) -> FloatArray:
    """Radial, tangential, axial direction as columns (n, 3, 3) at places (n, 3), about the axis from a to b.

    On the axis itself the radial direction is any lateral direction.
    """
    axial = _unit(np.asarray(b - a)[None])[0]
    across = places - a
    radial = across - np.outer(across @ axial, axial)
    aside = np.cross(axial, np.eye(3)[np.argmin(np.abs(axial))])
    on_axis = np.linalg.norm(radial, axis=1) <= 1e-12 * (1 + np.linalg.norm(across, axis=1))
    radial = _unit(np.where(on_axis[:, None], aside, radial))
    axes = np.empty((len(places), 3, 3))
    axes[:, :, 0], axes[:, :, 1], axes[:, :, 2] = radial, np.cross(axial, radial), axial
    return axes


Orientations = Mapping[tuple[int, str], Orientation]
"""Orientations by scope and name in upper case."""


def orientation_of(orientations: Orientations, scope: int, name: str) -> Orientation | None:
    """The orientation of that name in a scope, else in the model; None without one."""
    return orientations.get((scope, name.upper())) or orientations.get((0, name.upper()))


def nodal_axes(
    model: AbaqusModel, placed: ScopedBlock, orientations: Orientations, nodes: IntArray
) -> FloatArray | None:
    """Axes (n, 3, 3) at nodes as columns, by the ORIENTATION of a keyword; None without one that is read."""
    found = orientation_of(orientations, placed.scope, placed.block.options.get("ORIENTATION", ""))
    if found is None or found.distributed:
        return None
    return found.axes(model.positions[nodes], np.full(len(nodes), -1))


def read_orientations(model: AbaqusModel) -> Orientations:
    """Orientations by scope and name in upper case; those by nodes or with distributed angles are left out.

    Raises
    ------
    ImportFormatError   words instead of numbers; points on a line; a distribution without default
    """
    found: dict[tuple[int, str], Orientation] = {}
    given = {
        (each.scope, each.block.options.get("NAME", "").upper()): each
        for each in model.blocks
        if each.block.key == "DISTRIBUTION" and not each.step
    }
    used: set[tuple[int, str]] = set()

    def distribution_of(scope: int, word: str) -> tuple[int, str] | None:
        keys = (scope, word.upper()), (0, word.upper())
        return next((key for key in keys if key in given), None)

    for placed in model.named("ORIENTATION"):
        block = placed.block
        name = block.options.get("NAME", "")
        system = block.options.get("SYSTEM", "RECTANGULAR").upper()[:1]
        definition = block.options.get("DEFINITION", "COORDINATES").upper()
        if definition not in ("COORDINATES", "OFFSETTONODES") or system not in "RCSZ" or not block.data:
            model.report.leave_out_block(block, f"axes '{name}' of materials are of an unsupported kind")
            continue
        rows = list(block.data)
        turn = fields(rows[1][1]) if len(rows) > 1 else []
        if len(turn) > 1 and distribution_of(placed.scope, turn[1]) is not None:
            model.report.leave_out_block(block, f"angles of axes '{name}' follow a distribution")
            continue
        values = numbers(model.file, rows[1][0], turn) if turn else []
        # Without an axis, an angle is about axis 1.
        axis, angle = int(values[0] or 1) if values else 0, np.radians([*values, 0.0, 0.0][1])
        what = f"*ORIENTATION, NAME={name}"
        of_points = partial(by_points, model, what, system, axis if 1 <= axis <= 3 else 0, angle)
        line, text = rows[0]
        distribution = distribution_of(placed.scope, fields(text)[0])
        if distribution is None:
            found[placed.scope, name.upper()] = of_points(placed.scope, line, fields(text))
        else:
            used.add(distribution)
            found[placed.scope, name.upper()] = _distributed(
                model, placed.scope, given[distribution], of_points
            )
    for key, placed in given.items() if used else ():
        if key in used:
            model.report.read[placed.block.name] += 1
        else:
            model.report.leave_out_block(placed.block, LEFT_OUT["DISTRIBUTION"])
    return found


def _distributed(
    model: AbaqusModel,
    scope: int,
    placed: ScopedBlock,
    of_points: Callable[[int, int, list[str]], Orientation],
) -> Orientation:
    """Axes by lines of an element or set and points; a line without elements is for all other elements."""
    whole, parts = None, []
    for line, text in placed.block.data:
        word, *rest = fields(text)
        own = of_points(scope, line, rest)
        if word:
            parts.append((model.elements_of(scope, word, line, "*DISTRIBUTION"), own))
        else:
            whole = own
    if whole is None:
        raise model.file.error(
            placed.block.line,
            "*DISTRIBUTION without a line of values for all other elements; add it",
        )
    return replace(whole, distributed=tuple(parts))


def by_points(
    model: AbaqusModel,
    what: str,
    system: str,
    axis: int,
    angle: float,
    scope: int,
    line: int,
    words: list[str],
) -> Orientation:
    """Axes by the coordinates of two points, or three.

    ImportFormatError, with the words `what`, if these give no axes.
    """
    points = np.array([*numbers(model.file, line, words), *9 * [0.0]][:9]).reshape(3, 3)
    a, b, c = (points @ model.scopes[scope].rotation.T) + model.scopes[scope].shift
    if not np.linalg.norm(np.cross(a - c, b - c) if system in "RZ" else b - a) > 0:
        raise model.file.error(line, f"{what}: its points give no axes; correct them")
    return Orientation(system, a, b, c, axis, angle)


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
