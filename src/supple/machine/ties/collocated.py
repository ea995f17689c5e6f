"""Nodes tied to another mesh at their positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.machine.ties.meeting import meeting_nodes, on_faces
from supple.mesh import Mesh

__all__ = ["Collocated"]


@dataclass(frozen=True)
class Collocated:
    """Each node is tied to the node of the other mesh at its position, or to the face under it.

    Linear displacements are transferred exactly. Forces act on the corners near each node only: where the
    tied mesh is the coarser one, a constant traction is not transferred exactly.
    """

    def weights(
        self,
        points: NDArray[np.float64],
        faces: NDArray[np.int64],  # noqa: ARG002 - of the protocol
        mesh: Mesh,
        within: float,
        what: str,
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Nodes (n, c) of a mesh that points (n, 3) follow, and their weights (n, c), which sum to one.

        faces : (T, 3) triangles of the tied side, as indices of `points`
        within : largest distance between the sides, m
        Raises ModelError for a point without a face.
        """
        met = meeting_nodes(points, mesh.nodes, within)
        if (met >= 0).all():
            return met[:, None], np.ones((len(points), 1))
        return on_faces(points, mesh, within, what)
