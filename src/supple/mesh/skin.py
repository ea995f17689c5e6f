"""The visible triangles of a mesh: a shell itself, or the outer faces of a solid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arrays import BoolArray, IntArray
from supple.errors import ModelError
from supple.mesh.mesh import Mesh
from supple.mesh.outer_faces import outer_faces

__all__ = ["Skin", "skin_of"]

# Triangles of a face by its number of nodes, which are counted around the rim (corner, mid-edge, ...).
_CUTS = {
    3: ((0, 1, 2),),
    4: ((0, 1, 2), (0, 2, 3)),
    6: ((0, 1, 5), (1, 2, 3), (3, 4, 5), (1, 3, 5)),
    8: ((0, 1, 7), (1, 2, 3), (3, 4, 5), (5, 6, 7), (1, 3, 7), (3, 5, 7)),
}


@dataclass(frozen=True, eq=False)
class Skin:
    """Visible triangles of a mesh, with a mark for those of their sides that are edges of the mesh.

    triangles : int array (T, 3)        node numbers; on solids, right-handed about the outward normal
    mesh_lines : bool array (T, 3)      for side i, opposite to corner i: True if it is an edge of the mesh,
                                        False if it is a cut through a face

    Raises
    ------
    ModelError  an array of another shape, or no triangle
    """

    triangles: IntArray
    mesh_lines: BoolArray

    def __post_init__(self) -> None:
        if self.triangles.ndim != 2 or self.triangles.shape[1] != 3 or not len(self.triangles):
            raise ModelError(
                f"skin: triangles of shape {self.triangles.shape}; give (T, 3) with at least one"
            )
        if self.mesh_lines.shape != self.triangles.shape:
            raise ModelError(
                f"skin: mesh lines of shape {self.mesh_lines.shape} for triangles of shape "
                f"{self.triangles.shape}"
            )
        for array in (self.triangles, self.mesh_lines):
            array.setflags(write=False)

    @classmethod
    def of_triangles(cls, triangles: IntArray) -> Skin:
        """Skin of triangles whose sides are all edges of the mesh."""
        return cls(np.array(triangles), np.ones(np.shape(triangles), dtype=bool))


def skin_of(mesh: Mesh) -> Skin:
    """The skin of a mesh.

    Faces shared by two solid cells are interior and left out. Faces with mid-edge nodes are divided at these
    nodes, so that a curved face looks curved. Beams (LINE2) have no faces; `body_surface` draws them.

    Raises ModelError for a mesh without faces, such as beams alone.
    """
    parts = [_skin_of_faces(faces) for faces in outer_faces(mesh, middles=True)]
    if not parts:
        raise ModelError("a mesh of beams alone has no skin; draw the model: body_surface(model)")
    return Skin(np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]))


def _skin_of_faces(faces: IntArray) -> tuple[IntArray, BoolArray]:
    n_rim = faces.shape[1]
    cuts = np.array(_CUTS[n_rim])
    # A side is an edge of the mesh if its two nodes are neighbours on the rim.
    gap = (cuts[:, [2, 0, 1]] - cuts[:, [1, 2, 0]]) % n_rim
    on_rim = (gap == 1) | (gap == n_rim - 1)
    return faces[:, cuts].reshape(-1, 3), np.tile(on_rim, (len(faces), 1))
