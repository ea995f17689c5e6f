"""Cell types: the shapes of cells in a mesh, and the order of their nodes."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

__all__ = ["CellType"]

_TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
_TETRA_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_TETRA_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
_HEXA_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_HEXA_EDGES = (
    (0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
)  # fmt: skip

_WEDGE_EDGES = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
_WEDGE_FACES = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_PYRAMID_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4))
_PYRAMID_FACES = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))


class CellType(Enum):
    """A cell shape; the order of the nodes is that of meshio, Abaqus and CalculiX.

    Corners come first, then mid-edge nodes in the order of `edges`. The corners of a triangle are
    right-handed about its normal. The fourth corner of a tetrahedron is on the normal side of the triangle of
    the first three, and the fifth corner of a pyramid on the normal side of its base. Hexahedra and wedges
    begin with the corners of the bottom; those of the top follow. Both are right-handed about the axis from
    bottom to top.

    dimension : 1 line, 2 surface, 3 solid
    edges : pairs of corners
    faces : corners of each face, right-handed about the outward normal; a triangle has one face, a line none
    """

    LINE2 = ("line", 2, 2, 1, ((0, 1),), ())
    TRIANGLE3 = ("triangle", 3, 3, 2, _TRIANGLE_EDGES, ((0, 1, 2),))
    TETRA4 = ("tetra", 4, 4, 3, _TETRA_EDGES, _TETRA_FACES)
    TETRA10 = ("tetra10", 10, 4, 3, _TETRA_EDGES, _TETRA_FACES)
    PYRAMID5 = ("pyramid", 5, 5, 3, _PYRAMID_EDGES, _PYRAMID_FACES)
    PYRAMID13 = ("pyramid13", 13, 5, 3, _PYRAMID_EDGES, _PYRAMID_FACES)
    WEDGE6 = ("wedge", 6, 6, 3, _WEDGE_EDGES, _WEDGE_FACES)
    WEDGE15 = ("wedge15", 15, 6, 3, _WEDGE_EDGES, _WEDGE_FACES)
    HEXA8 = ("hexahedron", 8, 8, 3, _HEXA_EDGES, _HEXA_FACES)
    HEXA20 = ("hexahedron20", 20, 8, 3, _HEXA_EDGES, _HEXA_FACES)

    def __init__(
        self,
        meshio_name: str,
        n_nodes: int,
        n_corners: int,
        dimension: int,
        edges: tuple[tuple[int, int], ...],
        faces: tuple[tuple[int, ...], ...],
    ):
        self.meshio_name = meshio_name
        self.n_nodes = n_nodes
        self.n_corners = n_corners
        self.dimension = dimension
        self.edges = edges
        self.faces = faces

    def middles(self, corners: Sequence[int]) -> tuple[int, ...]:
        """Mid-edge nodes around a face, from its first corner to the second on; none of a linear cell."""
        if self.n_nodes == self.n_corners:
            return ()
        of_edge = {frozenset(edge): self.n_corners + i for i, edge in enumerate(self.edges)}
        return tuple(
            of_edge[frozenset(edge)] for edge in zip(corners, [*corners[1:], corners[0]], strict=True)
        )
