"""From ties to the arrays of their march: where nodes meet a modal part, and what ties two of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from supple.errors import ModelError
from supple.machine import System, Tie
from supple.mesh.outer_faces import outer_triangles
from supple.methods.explicit.frame_model import FrameState
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.modal_tie import ModalTie, TiedSide, tied_rows
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.published_scheme import PublishedScheme
from supple.methods.explicit.start_motion import undeformed
from supple.methods.explicit.step_limit import damped_limit

__all__ = ["met_material", "modal_ties", "within"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_REDUNDANT = 1e-8
"""Of a multiplier's own mobility: what is left of it once those before it act."""


def within(tie: Tie, points: FloatArray) -> float:
    """How far apart the two sides of a tie may lie, m."""
    return tie.within * max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-300)


def met_material(system: System, tie: Tie, x: FloatArray) -> tuple[IntArray, FloatArray]:
    """Nodes (n, c) of the modal part that points x (n, 3) in space hang on, and their weights (n, c)."""
    part, tied = system.placed(tie.on), system.mesh_of(tie.nodes.body)
    local = (x - part.position) @ part.rotation
    nodes = system.node_numbers(tie.nodes)
    place = np.full(tied.n_nodes, -1)
    place[nodes] = np.arange(len(nodes))
    faces = place[outer_triangles(tied, nodes)]
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    return tie.transfer.weights(local, faces, system.mesh_of(tie.on), within(tie, local), what)


def modal_ties(
    system: System,
    scheme: ProjectedDifference | PublishedScheme,
    frames: Mapping[str, ModalFrame],
    states: Sequence[FrameState],
    penalties: Mapping[str, FloatArray | None],
) -> tuple[tuple[ModalTie, ...], tuple[tuple[int, int], ...], float]:
    """Ties of modal parts, the numbers of their frames, and the step limit of all of them together, s.

    states : of the frames at the start;   penalties : (6 + k, 6 + k) of the contacts of each, or None
    Raises ModelError: another scheme than the default, parts that do not meet.
    """
    between = [tie for tie in system.ties if tie.nodes.body in frames]
    if not between:
        return (), (), np.inf
    if not isinstance(scheme, ProjectedDifference):
        raise ModelError(
            f"modal sub-domains that are tied to each other march by ProjectedDifference() only, not by "
            f"{type(scheme).__name__}"
        )
    order = list(frames)
    ties, pairs = [], []
    for tie in between:
        ties.append(_tie(system, tie, frames))
        pairs.append((order.index(tie.nodes.body), order.index(tie.on)))
    names = [order[number] for number in sorted({number for pair in pairs for number in pair})]
    mass = np.asarray(linalg.block_diag(*(frames[name].pencil()[0] for name in names)))
    stiffness = linalg.block_diag(*(frames[name].pencil()[1] for name in names))
    pressed = [penalties[name] for name in names]
    sizes = [6 + frames[name].body.n_modes for name in names]
    stiffness += linalg.block_diag(
        *(np.zeros((n, n)) if own is None else own for n, own in zip(sizes, pressed, strict=True))
    )
    rows = [
        _pencil_rows(system, tie, pair, frames, states, names, order)
        for tie, pair in zip(ties, pairs, strict=True)
    ]
    kept = _independent(np.concatenate(rows), mass)
    numbers = np.split(np.arange(sum(map(len, rows))), np.cumsum([len(own) for own in rows])[:-1])
    chosen = [np.flatnonzero(np.isin(own, kept)) for own in numbers]
    free = linalg.null_space(np.concatenate(rows)[kept])
    largest = linalg.eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)[-1]
    limit = float(2 / np.sqrt(largest)) if largest > 0 else np.inf
    # Stiffness damping of each part is at most the largest beta's.
    beta = max(frames[name].body.stiffness_damping for name in names)
    # A tie whose rows follow from the others' says nothing more.
    left = [number for number, own in enumerate(chosen) if len(own)]
    return (
        tuple(_only(ties[number], chosen[number]) for number in left),
        tuple(pairs[number] for number in left),
        damped_limit(limit, beta),
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
    """(3 n, 6 + k): motion of points per motion of the part of unit kinetic energy (times 2)."""
    factor = np.linalg.cholesky(frame.pencil()[0])
    return linalg.solve_triangular(factor, motion.reshape(-1, motion.shape[2]).T, lower=True).T


def _pencil_rows(
    system: System,
    tie: ModalTie,
    pair: tuple[int, int],
    frames: Mapping[str, ModalFrame],
    states: Sequence[FrameState],
    names: list[str],
    order: list[str],
) -> FloatArray:
    """(r, sum (6 + k)): the rows of a tie on rigid motions and modes of all tied parts."""
    own = dict(zip(pair, tied_rows(tie, *(states[number] for number in pair)), strict=True))
    blocks = []
    for name in names:
        number, frame = order.index(name), frames[name]
        if number not in own:
            blocks.append(np.zeros((len(tie.first.weights), 6 + frame.body.n_modes)))
            continue
        turned = np.einsum("ij,ajc->aic", system.placed(name).rotation, frame.rigid_rates)
        blocks.append(
            np.concatenate(
                [np.einsum("raj,ajc->rc", np.asarray(own[number].p), turned), np.asarray(own[number].y)],
                axis=1,
            )
        )
    return np.concatenate(blocks, axis=1)


def _independent(rows: FloatArray, mass: FloatArray) -> IntArray:
    """Numbers of rows that do not follow from those before them: ties that close a loop say some twice."""
    factor = np.linalg.cholesky(mass)
    reached = linalg.solve_triangular(factor, rows.T, lower=True)
    reached = reached / np.linalg.norm(reached, axis=0)
    kept: list[int] = []
    directions = np.zeros((len(reached), 0))
    for number, column in enumerate(reached.T):
        left = column - directions @ (directions.T @ column)
        left -= directions @ (directions.T @ left)
        if (size := np.linalg.norm(left)) > _REDUNDANT**0.5:
            directions = np.column_stack([directions, left / size])
            kept.append(number)
    return np.array(kept, dtype=np.int64)


def _only(tie: ModalTie, rows: IntArray) -> ModalTie:
    one, two = (TiedSide(side.weights[rows], side.shapes[rows]) for side in (tie.first, tie.second))
    return ModalTie(one, two, tie.per_arm)
