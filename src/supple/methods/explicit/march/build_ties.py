"""Arrays of ties: matching points of nodes on a modal part, and ties between two modal parts."""

from __future__ import annotations

from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.machine import System, Tie
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.modal_tie import ModalTie, TiedSide
from supple.methods.explicit.start_motion import undeformed

__all__ = ["largest_distance", "met_material", "modal_ties"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def largest_distance(tie: Tie, points: FloatArray) -> float:
    """Largest allowed distance between the two sides of a tie, m."""
    return tie.within * max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-300)


def met_material(system: System, tie: Tie, x: FloatArray) -> tuple[IntArray, FloatArray]:
    """Nodes (n, c) of the modal part that points x (n, 3) in space are tied to, and their weights (n, c)."""
    part, tied = system.placed(tie.on), system.mesh_of(tie.nodes.body)
    local = (x - part.position) @ part.rotation
    nodes = system.node_numbers(tie.nodes)
    place = np.full(tied.n_nodes, -1)
    place[nodes] = np.arange(len(nodes))
    faces = place[outer_triangles(tied, nodes)]
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    return tie.transfer.weights(local, faces, system.mesh_of(tie.on), largest_distance(tie, local), what)


def modal_ties(
    system: System, frames: Mapping[str, ModalFrame]
) -> tuple[tuple[ModalTie, ...], tuple[tuple[int, int], ...]]:
    """Ties of modal parts to each other, and the numbers of their frames; ModelError for unmatched nodes."""
    order = list(frames)
    between = [tie for tie in system.ties if tie.nodes.body in frames]
    return (
        tuple(_tie(system, tie, frames) for tie in between),
        tuple((order.index(tie.nodes.body), order.index(tie.on)) for tie in between),
    )


def _tie(system: System, tie: Tie, frames: Mapping[str, ModalFrame]) -> ModalTie:
    first, second = system.placed(tie.nodes.body), system.placed(tie.on)
    nodes = system.node_numbers(tie.nodes)
    x = undeformed(first)[nodes]
    corners, shares = met_material(system, tie, x)
    own, other = frames[tie.nodes.body], frames[tie.on]
    local = (x - second.position) @ second.rotation
    weights = own.weights(nodes), other.body.points.weights(local)
    shapes = own.shapes[nodes], np.einsum("nc,ncik->nik", shares, other.shapes[corners])
    turn = second.rotation.T @ first.rotation
    reach = [
        _reached(own, np.einsum("ij,njk->nik", turn, own.motion(nodes))),
        _reached(other, other.material_motion(weights[1], shapes[1])),
    ]
    L = tie.continuity.patterns(local, np.concatenate(reach, axis=1))
    one, two = (
        TiedSide(jnp.einsum("rci,ca->ria", L, w), jnp.einsum("rci,cmk->rimk", L, s))
        for w, s in zip(weights, shapes, strict=True)
    )
    return ModalTie(one, two, jnp.asarray(1 / other.body.points.arm))


def _reached(frame: ModalFrame, motion: FloatArray) -> FloatArray:
    """(3 n, 6 + k): motion of points per motion v of the part with v^T M v = 1."""
    factor = np.linalg.cholesky(frame.pencil()[0])
    return linalg.solve_triangular(factor, motion.reshape(-1, motion.shape[2]).T, lower=True).T
