"""Ties, joints and force elements of frames: independent multipliers, and the common step limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy import linalg

from supple.algebra.cross import cross_matrix
from supple.arrays import FloatArray, IntArray
from supple.equations import marker_force
from supple.equations.compiler_options import STARTING
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import Model
from supple.equations.places import assembled_matrix
from supple.errors import ModelError
from supple.integrate import StepFactors
from supple.machine import System
from supple.methods.explicit.frame_chart import configuration
from supple.methods.explicit.frame_model import FrameState, Generalized
from supple.methods.explicit.march.build_ties import check_modal_ties, modal_ties
from supple.methods.explicit.march.frame_forces import joint_rows
from supple.methods.explicit.march.march_model import FrameArrays
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.modal_tie import ModalTie, TiedSide, tied_rows
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.published_scheme import PublishedScheme
from supple.methods.explicit.step_limit import damped_limit
from supple.programs.program_cache import CachedProgram

_REDUNDANT = 1e-8
"""Mobility of a constraint with the previous ones closed, divided by its mobility without them, below which
the constraint is redundant."""
_ROUNDED = 1e-13
"""Entries of a stiffness on free motions, relative to those on all motions, that are round-off."""


@dataclass(frozen=True, eq=False)
class JoinedFrames:
    """Ties of frames to each other, and their joints.

    ties, tied : ties with their independent multipliers, and the numbers of the two frames of each
    machine : the frames as floating bodies, with independent equations of joints
    numbers : frames with multipliers;   driven : (m,) 1 for equations with a law, else 0
    limited, step_limit : frames with ties, joints or force elements, and their common step limit, s
    """

    ties: tuple[ModalTie, ...]
    tied: tuple[tuple[int, int], ...]
    machine: Model | None
    numbers: tuple[int, ...]
    driven: FloatArray
    limited: tuple[int, ...]
    step_limit: float


def joined_frames(
    system: System,
    scheme: ProjectedDifference | PublishedScheme,
    frames: Mapping[str, ModalFrame],
    arrays: tuple[FrameArrays, ...],
    states: tuple[FrameState, ...],
    penalties: Mapping[str, FloatArray | None],
    machine: Model | None,
    time: float,
) -> JoinedFrames:
    """Ties, joints and forces between the frames of a system.

    states : initial states of the frames;   penalties : contact stiffness (6 + k, 6 + k) of each, or None
    Raises ModelError for a scheme other than ProjectedDifference, and for parts that do not match or start
    apart.
    """
    ties, pairs = modal_ties(system, frames)
    if machine is None or not (ties or machine.active or machine.forces):
        return JoinedFrames((), (), machine, (), np.zeros(0), (), np.inf)
    if not isinstance(scheme, ProjectedDifference) and (ties or machine.active):
        raise ModelError(
            "parts that are tied or joined to each other need ProjectedDifference(), not "
            f"{type(scheme).__name__}"
        )
    check_modal_ties(system, ties, pairs, frames, states)
    order, now = list(frames), jnp.asarray(time)
    joined = {number for pair in pairs for number in pair} | _touched(machine.joints)
    limited = sorted(joined | _touched(machine.forces))
    rigid = [
        np.einsum("ij,ajc->aic", system.placed(name).rotation, frame.body.points.rigid_rates)
        for name, frame in frames.items()
    ]
    rows = [
        _pencil_rows(dict(zip(pair, tied_rows(tie, *(states[i] for i in pair)), strict=True)), rigid, arrays)
        for tie, pair in zip(ties, pairs, strict=True)
    ]
    if machine.active:
        of_joints = _JOINT_ROWS(machine, arrays, states, now)
        rows.append(_pencil_rows(dict(enumerate(of_joints)), rigid, arrays))
    names = [order[number] for number in limited]
    mass = np.asarray(linalg.block_diag(*(frames[name].pencil()[0] for name in names)))
    blocks = [frames[name].pencil()[1] for name in names]
    pressed = [penalties[name] for name in names]
    stiffness = np.asarray(
        linalg.block_diag(*(K if own is None else K + own for K, own in zip(blocks, pressed, strict=True)))
    )
    sizes = [6 + frame.body.n_modes for frame in frames.values()]
    spans = np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])
    own = np.concatenate([spans[number] for number in limited])
    rates = (_floating_rates(system, name, frame) for name, frame in frames.items())
    moving = np.asarray(linalg.block_diag(*rates))
    elastic, damping = (
        (moving.T @ np.asarray(part) @ moving)[np.ix_(own, own)]
        for part in _OF_ELEMENTS(machine, arrays, states, now)
    )
    every = np.concatenate([each[:, own] for each in rows]) if rows else np.zeros((0, len(mass)))
    kept = _independent(every, mass)
    numbers = np.split(np.arange(len(every)), np.cumsum([len(each) for each in rows])[:-1]) if rows else []
    chosen = [np.flatnonzero(np.isin(own, kept)) for own in numbers]
    free = linalg.null_space(every[kept]) if len(kept) else np.eye(len(mass))
    largest = _largest(free, stiffness + elastic, mass)
    drag = 0.5 * _largest(free, damping, mass)
    # h^2 omega^2 / 4 + h c / 2 = 1, because damping lags by half a step.
    limit = 2 / (drag + np.sqrt(drag**2 + largest)) if drag + largest > 0 else np.inf
    # Stiffness damping of each part is bounded by the largest beta.
    beta = max(frames[name].body.stiffness_damping for name in names)
    if machine.active:
        *chosen, of_machine = chosen
        machine = replace(machine, active=tuple(machine.active[row] for row in of_machine))
    # A tie without independent rows is redundant.
    left = [number for number, own in enumerate(chosen) if len(own)]
    driven = np.array([float(joint.law is not None) for joint in system.joints for _ in joint.rows])
    return JoinedFrames(
        tuple(_only(ties[number], chosen[number]) for number in left),
        tuple(pairs[number] for number in left),
        machine,
        tuple(sorted(joined)),
        driven[list(machine.active)],
        tuple(limited),
        damped_limit(limit, beta),
    )


def _touched(groups: Sequence) -> set[int]:
    """Numbers of the bodies that joints or forces act on."""
    return {body for own in groups for end in (own.first, own.second) for body in end.bodies if body >= 0}


def _largest(free: FloatArray, matrix: FloatArray, mass: FloatArray) -> float:
    """Largest eigenvalue of the symmetric part of a matrix on free motions; zero if none is positive."""
    own = free.T @ (0.5 * (matrix + matrix.T)) @ free
    if np.abs(own).max(initial=0.0) <= _ROUNDED * np.abs(matrix).max(initial=0.0):
        return 0.0
    return max(float(linalg.eigh(own, free.T @ mass @ free, eigvals_only=True)[-1]), 0.0)


def _floating_rates(system: System, name: str, frame: ModalFrame) -> FloatArray:
    """Matrix of (dR, omega, dq) by velocity of the centre, angular velocity (mesh axes), and modal rates."""
    k = frame.body.n_modes
    found = np.zeros((6 + k, 6 + k))
    A, centre = system.placed(name).rotation, frame.body.points.origin
    found[:3, :3], found[:3, 3:6] = A, A @ cross_matrix(centre)
    found[3:6, 3:6], found[6:, 6:] = np.eye(3), frame.turned
    return found


def _of_elements(
    machine: Model, arrays: tuple[FrameArrays, ...], states: tuple[FrameState, ...], time: Array
) -> tuple[Array, Array]:
    """Stiffness and damping (n, n) of force elements at the start, with their ends at rest."""
    n = machine.n_velocities
    where, still = configuration(tuple(each.chart for each in arrays), states), jnp.zeros(n)
    motion = SystemMotion(time, where, still, still, jnp.zeros(len(machine.active)))
    unturned = jnp.broadcast_to(jnp.eye(3), (len(states), 3, 3))

    def matrix(factors: StepFactors) -> Array:
        blocks = [
            block
            for group in machine.forces
            for block in marker_force.tangent(machine, group, motion, unturned, factors)
        ]
        return assembled_matrix((n, n), blocks)

    return matrix(StepFactors(-1.0, 0.0)), matrix(StepFactors(0.0, -1.0))


_JOINT_ROWS = CachedProgram(joint_rows, STARTING)
_OF_ELEMENTS = CachedProgram(_of_elements, STARTING)


def _pencil_rows(
    rows: Mapping[int, Generalized], rigid: Sequence[FloatArray], arrays: Sequence[FrameArrays]
) -> FloatArray:
    """(r, sum (6 + k)): rows of a tie, or of the joints, on rigid motions and modes of all frames."""
    r = len(next(iter(rows.values())).y)
    blocks = []
    for number, (turned, own) in enumerate(zip(rigid, arrays, strict=True)):
        if number in rows:
            at = rows[number]
            blocks += [np.einsum("raj,ajc->rc", np.asarray(at.p), turned), np.asarray(at.y)]
        else:
            blocks.append(np.zeros((r, 6 + len(own.chart.turned))))
    return np.concatenate(blocks, axis=1)


def _independent(rows: FloatArray, mass: FloatArray) -> IntArray:
    """Numbers of rows that are linearly independent of those before; ties in a closed loop are redundant."""
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
