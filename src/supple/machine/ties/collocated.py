"""Tie of nodes to the points of another mesh at the same positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.machine.ties.meeting import meeting_nodes, on_faces
from supple.mesh import Mesh

__all__ = ["Collocated"]


@dataclass(frozen=True)
class Collocated:
    """Each node is tied to the node of the other mesh at its position, or to the nearest face.

    Faces are used unless every node has a node of the other mesh at its position. Linear displacements are
    transferred exactly. Forces act only on the corners of the face at each node: where the tied mesh is the
    coarser one, a constant traction is not transferred exactly.
    """

    def weights(
        self,
        points: NDArray[np.float64],
        faces: NDArray[np.int64],  # noqa: ARG002 - of the protocol
        mesh: Mesh,
        within: float,
        what: str,
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Nodes (n, c) of a mesh that points (n, 3) follow, and their weights (n, c), one in sum per point.

        faces : (T, 3) triangles of the tied side, as indices of `points`
        within : largest distance between the sides, m
        what : name of the tie in messages
        Raises ModelError for a point farther than `within` from every face.
        """
        met = meeting_nodes(points, mesh.nodes, within)
        if (met >= 0).all():
            return met[:, None], np.ones((len(points), 1))
        return on_faces(points, mesh, within, what)
