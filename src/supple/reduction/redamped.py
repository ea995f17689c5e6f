"""New damping for a reduced body without reducing it again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from supple.arrays import FloatArray
from supple.body import Damping
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.reduction.projection import counted_damping
from supple.reduction.reduced_body import ReducedBody

__all__ = ["redamped"]

ROUND_OFF = 1e-9
"""Largest ratio of the remaining damping, without that of `before`, to the damping of `before` that is
round-off and set to zero; a larger remainder is damping of imported matrices."""


def redamped(body: ReducedBody, before: Damping, after: Damping) -> ReducedBody:
    """The body with the damping `after` instead of `before`, of the same kind.

        D = D_own + alpha V^T P^T M P V + beta V^T K V,      D(q) - D(0) proportional to beta

    with P V = V - R a, the motion relative to the interface `held`, a the rigid motion of this interface;
    P = I without `held`. The Gram matrix of the body contains all mass terms. For ModalDamping, D follows
    from the modes of V^T K V and V^T P^T M P V. D_own is the damping of imported matrices.

    before : the damping that the body was reduced with
    after : the new damping
    Raises ModelError when `before` and `after` differ in kind or in `held`; for a nonlinear body, also when
        only `after` damps the strain rate (RayleighDamping with beta > 0).
    """
    if type(before) is not type(after) or before.held != after.held:
        raise ModelError(
            f"body '{body.name}' was reduced with another kind of damping, {before}, than {after}: reduce "
            "it again"
        )
    mass = _mass_beside(body, before.held)
    taken = np.asarray(before.matrix(body.stiffness, mass))
    own = body.damping - taken
    if np.abs(own).max(initial=0.0) <= ROUND_OFF * np.abs(taken).max(initial=0.0):
        own = 0.0 * own
    new, old = after.retardation_time, before.retardation_time
    if new and not old and body.cubic is not None:
        raise ModelError(
            f"body '{body.name}' was reduced without damping by strain rate: reduce it with beta > 0"
        )
    factor = new / old if old else 0.0
    return replace(
        body,
        damping=own + np.asarray(after.matrix(body.stiffness, mass)),
        damping_cubic=None if body.damping_cubic is None else factor * body.damping_cubic,
        damping_quartic=None if body.damping_quartic is None else factor * body.damping_quartic,
        full=None if body.full is None else replace(body.full, damping=counted_damping(after, body.r)),
    )


def _mass_beside(body: ReducedBody, held: str | None) -> FloatArray:
    """V^T P^T M P V (r, r) of the motion relative to the interface `held`; the identity if it is None."""
    r = body.r
    if held is None:
        return np.eye(r)
    place = body.interface(held)
    rigid = nodal_rigid_modes(place.position[None], 6)
    seen = np.vstack([-np.linalg.solve(rigid, place.motion), np.eye(r)])
    fields = np.r_[0:6, 6 + 3 * r : 6 + 4 * r]
    return seen.T @ body.gram[np.ix_(fields, fields)] @ seen
