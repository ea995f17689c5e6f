"""Axes of materials: *ORIENTATION in rectangular, cylindrical and spherical coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from supple.importers.abaqus.model import AbaqusModel
from supple.importers.keyword_file import fields, numbers

__all__ = ["Orientation", "cylindrical_axes", "read_orientations"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Orientation:
    """system : R, C, S or Z;  a, b, c : (3,) points;  axis (1 to 3), angle : turn about a local axis"""

    system: str
    a: FloatArray
    b: FloatArray
    c: FloatArray
    axis: int = 0
    angle: float = 0.0

    def axes(self, places: FloatArray) -> FloatArray:
        """Axes of the material as columns (n, 3, 3) at places (n, 3)."""
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
            if self.system == "Z":  # a lies on the local z axis, b in the xz plane
                axes = np.column_stack([np.cross(np.cross(first, self.b - self.c), first), third, first])
            else:
                axes = np.column_stack([first, np.cross(third, first), third])
            axes = np.broadcast_to(axes / np.linalg.norm(axes, axis=0), (len(places), 3, 3))
        if not self.axis:
            return axes
        turn: FloatArray = Rotation.from_rotvec(self.angle * np.eye(3)[self.axis - 1]).as_matrix()
        return np.asarray(axes @ turn, dtype=np.float64)

    def shell_directions(self, places: FloatArray) -> FloatArray:
        """First in-plane directions (n, 3) before projection: of the axis after the one along the normal."""
        normal = self.axis or 3
        return self.axes(places)[:, :, normal % 3]


def cylindrical_axes(a: FloatArray, b: FloatArray, places: FloatArray) -> FloatArray:
    """Radial, tangential, axial direction as columns (n, 3, 3) at places (n, 3), about the axis from a to b.

    On the axis itself the radial direction is some direction across it.
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


def read_orientations(model: AbaqusModel) -> Mapping[tuple[int, str], Orientation]:
    """Orientations by scope and name in upper case; those by nodes or of other programs' fields are left out.

    Raises
    ------
    ImportFormatError   words for numbers; points on a line
    """
    found: dict[tuple[int, str], Orientation] = {}
    distributions = {
        each.block.options.get("NAME", "").upper()
        for each in model.blocks
        if each.block.key == "DISTRIBUTION"
    }
    for placed in model.named("ORIENTATION"):
        block = placed.block
        name = block.options.get("NAME", "")
        system = block.options.get("SYSTEM", "RECTANGULAR").upper()[:1]
        definition = block.options.get("DEFINITION", "COORDINATES").upper()
        if definition not in ("COORDINATES", "OFFSETTONODES") or system not in "RCSZ" or not block.data:
            model.report.leave_out_block(block, f"axes '{name}' of materials are not of a kind that is read")
            continue
        line, text = block.data[0]
        if fields(text)[0].upper() in distributions:
            model.report.leave_out_block(block, f"axes '{name}' of materials follow a distribution")
            continue
        values = [*numbers(model.file, line, fields(text)), *9 * [0.0]][:9]
        points = np.array(values).reshape(3, 3)
        turn = numbers(model.file, block.data[1][0], fields(block.data[1][1])) if len(block.data) > 1 else []
        scope = model.scopes[placed.scope]
        a, b, c = (points @ scope.rotation.T) + scope.shift
        if not np.linalg.norm(np.cross(a - c, b - c) if system in "RZ" else b - a) > 0:
            raise model.file.error(line, f"*ORIENTATION, NAME={name}: its points give no axes; correct them")
        axis, angle = int(turn[0]) if turn else 0, np.radians([*turn, 0.0, 0.0][1])
        found[placed.scope, name.upper()] = Orientation(system, a, b, c, axis if 1 <= axis <= 3 else 0, angle)
    return found


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
