"""Two four-point frames tied to each other: the constraint residual g and its Jacobian.

    g_r = 1/l sum_c L_rc . P_2^T (x_1(X_c) - x_2(X_c)) = 0

at points X_c of both interfaces, with combinations L in the axes of the second frame, its arms P_2 and their
length l. g is invariant under a rigid motion of both parts, so its multipliers conserve linear and angular
momentum. Like all sums over nodes, g is a polynomial in the coordinates: L is contracted with weights and
shapes in advance.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.frame_model import FrameState, Generalized
from supple.methods.explicit.frame_moments import arms
from supple.methods.explicit.frame_points import CORNERS


class TiedSide(NamedTuple):
    """One part of a tie.

    weights : (r, 3, 4)     sum_c L_rci w_ca
    shapes : (r, 3, 3, k)   sum_c L_rci Phi_cmk
    """

    weights: Array
    shapes: Array


class ModalTie(NamedTuple):
    """The tied parts, and 1 / arm of the second, 1/m."""

    first: TiedSide
    second: TiedSide
    per_arm: Array


def tied_gap(tie: ModalTie, first: FrameState, second: FrameState) -> Array:
    """Residual g (r,), m."""
    apart = _combined(tie.first, first) - _combined(tie.second, second)
    return tie.per_arm * jnp.einsum("ji,rij->r", arms(second.p), apart)


def tied_rates(tie: ModalTie, first: FrameState, second: FrameState) -> tuple[Array, Array]:
    """Rates of both sides along the combinations of a tie, (r,), m/s; equal if the tie stays closed."""
    P = tie.per_arm * arms(second.p)

    def along(side: TiedSide, at: FrameState) -> Array:
        rates = FrameState(at.vp, at.vy, jnp.zeros_like(at.vp), jnp.zeros_like(at.vy))
        return jnp.einsum("ji,rij->r", P, jax.jvp(lambda now: _combined(side, now), (at,), (rates,))[1])

    return along(tie.first, first), along(tie.second, second)


def tied_rows(tie: ModalTie, first: FrameState, second: FrameState) -> tuple[Generalized, Generalized]:
    """dg/dq of both parts: rows on the points, (r, 4, 3), and on the modes, (r, k)."""
    P = tie.per_arm * arms(second.p)
    apart = _combined(tie.first, first) - _combined(tie.second, second)
    own, other = _rows(tie.first, first, P), _rows(tie.second, second, P)
    turned = tie.per_arm * jnp.einsum("ai,rij->raj", jnp.asarray(CORNERS), apart)
    return own, Generalized(turned - other.p, -other.y)


def _combined(side: TiedSide, at: FrameState) -> Array:
    """Sums over c of L_rci x_j(X_c), (r, 3, 3)."""
    return side.weights @ at.p + (side.shapes @ at.y) @ arms(at.p).T


def _rows(side: TiedSide, at: FrameState, P: Array) -> Generalized:
    tied = side.weights + (side.shapes @ at.y) @ jnp.asarray(CORNERS).T
    turned = P.T @ arms(at.p)
    return Generalized(jnp.einsum("ji,ria->raj", P, tied), jnp.einsum("im,rimk->rk", turned, side.shapes))
