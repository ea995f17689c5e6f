"""Arrays of ties: matching points of nodes on a modal part, ties between two modal parts, and their start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import jax.numpy as jnp
import numpy as np
from scipy import linalg

from supple.arrays import FloatArray, IntArray
from supple.errors import ModelError
from supple.machine import System, Tie
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit.frame_model import FrameState
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.modal_tie import ModalTie, TiedSide, tied_gap, tied_rates
from supple.methods.explicit.start_motion import undeformed

APART = 1e-9
"""Largest initial velocity difference of the nodes of a tie between modal parts, relative to their largest
speed; a larger difference is an error."""
ROUNDED = 1e-6
"""As `APART`, for ties of nodes of explicit parts."""


def largest_distance(system: System, tie: Tie) -> float:
    """Largest allowed distance between the two sides of a tie, m, with round-off of a single node."""
    every = system.placed(tie.nodes.body).body.nodes
    own = every[system.node_numbers(tie.nodes)]
    set_size, part_size = (float(np.linalg.norm(np.ptp(each, axis=0))) for each in (own, every))
    return tie.within * set_size + 1e-12 * part_size


def check_velocities(tie: Tie, one: FloatArray, two: FloatArray, rounding: float) -> None:
    """Raise ModelError if the velocities (n, 3) of both sides of a tie differ at the start."""
    sides = [np.linalg.norm(each, axis=-1).max(initial=0.0) for each in (one, two, one - two)]
    if sides[2] > rounding * max(sides[:2]):
        raise ModelError(
            f"tie of '{tie.nodes}' on '{tie.on}': the initial velocities of the two sides differ by "
            f"{sides[2]:.3g}; give both the velocity and angular velocity of one rigid motion, that of "
            "their joints if these move a part from the start"
        )


def check_positions(tie: Tie, apart: float, allowed: float) -> None:
    """Raise ModelError if a side of a tie starts deformed, or joints moved it from the other side."""
    if apart > allowed:
        raise ModelError(
            f"tie of '{tie.nodes}' on '{tie.on}': the two sides start {apart:.3g} apart, as a modal "
            "part has coordinates or was moved to close its joints; leave out its coordinates, and place it "
            "so that joints are closed"
        )


def met_material(system: System, tie: Tie, x: FloatArray) -> tuple[IntArray, FloatArray]:
    """Nodes (n, c) of the modal part that points x (n, 3) in space are tied to, and their weights (n, c)."""
    part, tied = system.placed(tie.on), system.mesh_of(tie.nodes.body)
    local = (x - part.position) @ part.rotation
    nodes = system.node_numbers(tie.nodes)
    place = np.full(tied.n_nodes, -1)
    place[nodes] = np.arange(len(nodes))
    faces = place[outer_triangles(tied, nodes)]
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    return tie.transfer.weights(local, faces, system.mesh_of(tie.on), largest_distance(system, tie), what)


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


def check_modal_ties(
    system: System,
    ties: tuple[ModalTie, ...],
    pairs: tuple[tuple[int, int], ...],
    frames: Mapping[str, ModalFrame],
    states: Sequence[FrameState],
) -> None:
    """Raise ModelError for ties of `modal_ties` whose sides differ in position or velocity at the start."""
    between = [tie for tie in system.ties if tie.nodes.body in frames]
    for tie, own, pair in zip(between, ties, pairs, strict=True):
        sides = [states[number] for number in pair]
        # Combinations of n nodes have unit norm: sqrt(n) times a displacement of all.
        share = 1 / np.sqrt(len(system.node_numbers(tie.nodes)))
        gap = np.abs(np.asarray(tied_gap(own, *sides))).max()
        check_positions(tie, float(share * gap / own.per_arm), largest_distance(system, tie))
        one, two = (share * np.asarray(each) for each in tied_rates(own, *sides))
        check_velocities(tie, one, two, APART)


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
