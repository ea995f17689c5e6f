"""Mean squares of a small motion over the nodes of a body, from a Gram matrix."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from supple.arrays import FloatArray
from supple.body.rigid_motion import cross_of_axes


class NodalSquares(NamedTuple):
    """Gram matrix over the nodes, with weight 1/N, of the fields `(1, e_i x X, e_i x V_j, Z)`.

    gram : (6 + 3 s + k, 6 + 3 s + k)
    """

    gram: FloatArray

    def rms(
        self,
        rotation: FloatArray,
        origin: FloatArray,
        turn: FloatArray,
        coordinates: FloatArray,
        error: FloatArray,
    ) -> FloatArray:
        """Root mean square over the nodes of `dR + A (e + psi x (X + V g))`, (t,).

        rotation (t, 3, 3) A;  origin (t, 3) dR;  turn (t, 3) psi;  coordinates (t, s) g;  error (t, k) e
        """
        turned = (coordinates[:, :, None] * turn[:, None]).reshape(len(turn), -1)
        fields = np.hstack([np.einsum("tij,ti->tj", rotation, origin), turn, turned, error])
        # After a diverged march the values are not finite: they are reported as unknown.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.sqrt(np.maximum(np.sum(fields * (fields @ self.gram), axis=1), 0.0))


def nodal_squares(nodes: FloatArray, motion: FloatArray, onto: FloatArray) -> NodalSquares:
    """Gram matrix from nodes (N, 3), fields of the run's motion (N, 3, s) and of its error (N, 3, k)."""
    N = len(nodes)
    turned = cross_of_axes(np.moveaxis(motion, 2, 1))  # (N, s, component, axis)
    fields = np.concatenate(
        [
            np.broadcast_to(np.eye(3), (N, 3, 3)),
            cross_of_axes(nodes),
            np.moveaxis(turned, 1, 2).reshape(N, 3, -1),
            onto,
        ],
        axis=2,
    ).reshape(3 * N, -1)
    return NodalSquares(fields.T @ fields / N)
