"""Modes of a reduced body with one interface clamped in space, and of a full body under a constraint."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg
from scipy.sparse import sparray

from supple.algebra import read_only
from supple.algebra.constrained_solve import dense_rows
from supple.body import FlexibleBody
from supple.body.rigid_motion import nodal_rigid_modes
from supple.reduction.reduced_body import ReducedBody

__all__ = ["BodyModes", "ClampedModes", "body_modes", "clamped_modes"]


@dataclass(frozen=True, eq=False)
class BodyModes:
    """Modes of unit modal mass, m in number.

    frequencies : (m,)      rad/s, ascending
    shapes : (m, N, 3)      nodal displacements, mesh axes
    rotations : (m, N, 3)   nodal rotations, mesh axes; None if the nodes have no rotational freedoms
    """

    frequencies: np.ndarray
    shapes: np.ndarray
    rotations: np.ndarray | None = field(default=None, kw_only=True)


@dataclass(frozen=True, eq=False)
class ClampedModes(BodyModes):
    """Modes of a reduced body, with their damping ratios.

    damping_ratios : (m,)   gamma^T D gamma / (2 omega), gamma the reduced coordinates of the mode, omega its
        frequency and D the damping matrix of the undeformed body
    """

    damping_ratios: np.ndarray


def clamped_modes(body: ReducedBody, interface: str, *, n_modes: int | None = None) -> ClampedModes:
    """The lowest modes of a reduced body with one interface clamped and all others free.

        q = R a + V gamma,   [ R_p  B_p V ] (a, gamma) = 0,   R_p the rigid motions at the interface p

    R : rigid motions of the body, with amplitudes a;  V gamma : motion relative to the frame;
    B_p V : motion of the interface p per unit gamma. The modes contain the rigid motion R a: they do not
    depend on the choice of frame.

    n_modes : number of modes; None: all
    Raises ModelError when the body has no interface of that name.
    """
    place = body.interface(interface)
    r = body.r
    fields = np.r_[0:6, 6 + 3 * r : 6 + 4 * r]
    mass = body.gram[np.ix_(fields, fields)]
    stiffness = linalg.block_diag(np.zeros((6, 6)), body.stiffness)
    rigid = nodal_rigid_modes(place.position[None], 6)
    free = linalg.null_space(np.hstack([rigid, place.motion]))
    values, vectors = linalg.eigh(free.T @ stiffness @ free, free.T @ mass @ free)
    motion = (free @ vectors[:, :n_modes]).T
    translations, rotations, gammas = motion[:, :3], motion[:, 3:6], motion[:, 6:]
    rigid_shapes = translations[:, None] + np.cross(rotations[:, None], body.nodes)
    frequencies = np.sqrt(np.maximum(values[:n_modes], 0.0))
    turned = None
    if body.dofs_per_node == 6:
        nodal = body.nodal_basis.reshape(len(body.nodes), 6, r)[:, 3:]
        turned = read_only(rotations[:, None] + np.einsum("nir,mr->mni", nodal, gammas))
    damped = np.einsum("mi,ij,mj->m", gammas, body.damping, gammas)
    return ClampedModes(
        frequencies=read_only(frequencies),
        damping_ratios=read_only(damped / (2 * frequencies)),
        shapes=read_only(rigid_shapes + body.expand_rates(np.zeros_like(gammas), gammas)),
        rotations=turned,
    )


def body_modes(body: FlexibleBody, constraint: ArrayLike | sparray, *, n_modes: int) -> BodyModes:
    """The lowest modes of a full body under the constraint `D q = 0`, or all if it has fewer than n_modes.

    constraint : D (m, n), such as the constraint of a frame or the motion of an interface
    Raises ModelError when D has the wrong shape or is not finite.
    """
    D = dense_rows(constraint, body.n)
    found = body.lowest_modes(min(n_modes, body.n - len(D)), D)
    nodal = (body.expansion @ found.vectors).T.reshape(-1, len(body.nodes), body.dofs_per_node)
    return BodyModes(
        frequencies=read_only(np.sqrt(np.maximum(found.values, 0.0))),
        shapes=read_only(nodal[..., :3]),
        rotations=read_only(nodal[..., 3:]) if body.dofs_per_node == 6 else None,
    )
