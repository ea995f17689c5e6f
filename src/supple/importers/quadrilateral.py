"""Quadrilaterals of a file, which the mesh does not know, as triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def split_quadrilaterals(nodes: NDArray[np.float64], quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Two triangles (2 Q, 3) for each quadrilateral (Q, 4), cut along the shorter diagonal.

    Triangles 2 q and 2 q + 1 come from quadrilateral q and turn the same way.
    """
    corners = nodes[quads]
    diagonal_02 = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
    diagonal_13 = np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
    along_02, along_13 = quads[:, [0, 1, 2, 0, 2, 3]], quads[:, [0, 1, 3, 1, 2, 3]]
    return np.where((diagonal_02 <= diagonal_13)[:, None], along_02, along_13).reshape(-1, 3)
