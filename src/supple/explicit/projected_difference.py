"""The projected nodal central difference: leap-frog of the nodes, projected on what frame and modes can do.

    B(q_n)^T M [x(q_n+1) - 2 x_n + x_n-1] = h^2 {B(q_n)^T f_n - [0; K_L y_n] + G_n^T lambda},   D(p_n+1) = 0

with B = dx/dq, in equal steps; from the discrete Lagrangian 1/(2h) |x(q_n+1) - x(q_n)|_M^2 - h V(y_n). No
term is neglected and no force depends on velocity: gyroscopic, centrifugal and Euler forces are inside.
Momentum is exact, energy stays bounded, the step limit of the modes holds. The unknown increments enter
bilinearly,

    x_n+1 - x_n = xi_n dp + P_n Phi dy + dP Phi dy,

so the equation is solved for them (not for positions, whose differences would lose digits) by Newton's method
with the Jacobian frozen at t_n: each pass shrinks the error by the turn of a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from supple.explicit.frame_model import FrameModel, FrameState, Generalized, Steps, elastic_force
from supple.explicit.frame_moments import Spread, arms, spread
from supple.explicit.rigid_links import link_residual, link_rows, link_vectors

__all__ = ["ProjectedDifference"]

_MOST_PASSES = 40
_SMALL = 1e-13  # of the last correction: the next would be its product with the turn of a step


class _Tangent(NamedTuple):
    """B_n^T M B_n in blocks, and the rows of the links."""

    sums: Spread
    P: Array
    A_py: Array
    G: Array


@dataclass(frozen=True)
class ProjectedDifference:
    """The default scheme of a four-point frame."""

    def step(
        self, model: FrameModel, state: FrameState, force: Generalized, steps: Steps
    ) -> tuple[FrameState, Array]:
        """The state after the step, and the link multipliers (6,), N/m; `force` applies at t_n."""
        p, y, vp, vy = state
        h, mean = steps.after, steps.mean
        t = _tangent(model, p, y)
        moved = _momentum(t, Generalized(vp, vy))
        bilinear = _bilinear(model, t, vp, vy)
        drag = 0.5 * mean * model.mass_damping
        right = Generalized(
            h * (moved.p - steps.before * bilinear.p + mean * force.p),
            h
            * (
                moved.y
                - steps.before * bilinear.y
                + mean * (force.y + elastic_force(model, y, vy))
                - drag * vy
            ),
        )
        guess = Generalized(h * vp, h * vy)
        after, multipliers = _increment(model, p, t, right, guess, 1 + drag)
        new = FrameState(p + after.p, y + after.y, after.p / h, after.y / h)
        return new, multipliers / (h * mean)

    def turning_work(
        self, model: FrameModel, old: FrameState, new: FrameState, multipliers: Array, steps: Steps
    ) -> Array:
        """Work that the links and the bilinear motion do in a step, for it turns by a finite angle, J.

        With nodal velocities v = B d +- b, b = h P' Phi y', half a step after and before t_n the kinetic
        energy grows by <M (v+ - v-), (v+ + v-) / 2>; forces do B^T f . d of it, and the rest is

            lambda . G d + 1/2 [(d+ - d-) . B^T M (b+ - b-) + <b+, M b+> - <b-, M b->]

        It vanishes with the step, does not accumulate (the scheme is variational), and is known exactly.
        """
        t = _tangent(model, old.p, old.y)
        before, after = _bilinear(model, t, old.vp, old.vy), _bilinear(model, t, new.vp, new.vy)
        dp, dy = new.vp - old.vp, new.vy - old.vy
        turned = [
            jnp.sum(dp * (steps.after * after.p - steps.before * before.p)),
            dy @ (steps.after * after.y - steps.before * before.y),
            steps.after**2 * _bilinear_square(model, new.vp, new.vy),
            -(steps.before**2) * _bilinear_square(model, old.vp, old.vy),
        ]
        links = multipliers @ (t.G @ (0.5 * (old.vp + new.vp)).reshape(12))
        return steps.mean * links + 0.5 * sum(turned[1:], turned[0])


def _tangent(model: FrameModel, p: Array, y: Array) -> _Tangent:
    sums = spread(model.moments, y)
    P = arms(p)
    A_py = jnp.einsum("il,alk->aik", P, sums.Q).reshape(12, -1)
    return _Tangent(sums, P, A_py, link_rows(link_vectors(p)))


def _momentum(t: _Tangent, d: Generalized) -> Generalized:
    """B_n^T M B_n d."""
    return Generalized(t.sums.Xi @ d.p + (t.A_py @ d.y).reshape(4, 3), t.A_py.T @ d.p.reshape(12) + d.y)


def _bilinear(model: FrameModel, t: _Tangent, dp: Array, dy: Array) -> Generalized:
    """B_n^T M (dP Phi dy)."""
    dP = arms(dp)
    on_p = (t.sums.Q @ dy) @ dP.T
    k = len(dy)
    on_y = (t.P.T @ dP).reshape(9) @ (model.moments.C.reshape(9, k, k) @ dy)
    return Generalized(on_p, on_y)


def _bilinear_square(model: FrameModel, dp: Array, dy: Array) -> Array:
    """<b, M b> of b = dP Phi dy."""
    dP, k = arms(dp), len(dy)
    sums = jnp.einsum("k,ijkl,l->ij", dy, model.moments.C, dy) if k else jnp.zeros((3, 3))
    return jnp.sum((dP.T @ dP) * sums)


def _increment(
    model: FrameModel,
    p: Array,
    t: _Tangent,
    right: Generalized,
    guess: Generalized,
    modal_mass: Array | float,
) -> tuple[Generalized, Array]:
    """D and lambda with B_n^T M (x(q_n + d) - x_n) = right + G_n^T lambda and D(p + dp) = 0."""
    scale = model.squared_lengths[0]
    # The modes are eliminated first; the links make the rest regular, even where modes repeat a uniform
    # strain.
    S = jnp.kron(t.sums.Xi, jnp.eye(3)) - t.A_py @ t.A_py.T / modal_mass
    unit = t.sums.Xi[0, 0] + t.sums.Xi[1, 1]
    border = t.G * (unit / jnp.sqrt(scale))
    saddle = jnp.block([[S, -border.T], [border, jnp.zeros((6, 6))]])
    inverse = jnp.linalg.inv(saddle)
    factor = unit / jnp.sqrt(scale)

    def correction(d: Generalized, multipliers: Array) -> tuple[Generalized, Array]:
        moved, bilinear = _momentum(t, d), _bilinear(model, t, *d)
        r_p = (right.p - moved.p - bilinear.p).reshape(12) + border.T @ multipliers
        r_y = right.y - moved.y - bilinear.y - (modal_mass - 1) * d.y
        r_D = -link_residual(p + d.p, model.squared_lengths) * factor
        solved = inverse @ jnp.concatenate([r_p - t.A_py @ r_y / modal_mass, r_D])
        dp = solved[:12]
        return Generalized(dp.reshape(4, 3), (r_y - t.A_py.T @ dp) / modal_mass), solved[12:]

    def unfinished(carry: tuple[Generalized, Array, Array, Array]) -> Array:
        _, _, size, passes = carry
        return (size > _SMALL) & (passes < _MOST_PASSES)

    def improve(carry: tuple[Generalized, Array, Array, Array]) -> tuple[Generalized, Array, Array, Array]:
        d, multipliers, _, passes = carry
        change, more = correction(d, multipliers)
        size = jnp.abs(change.p).max() / jnp.sqrt(scale) + jnp.abs(change.y).max(initial=0.0) * jnp.sqrt(
            1 / unit / scale
        )
        return d + change, multipliers + more, size, passes + 1

    start = guess, jnp.zeros(6), jnp.asarray(jnp.inf), jnp.asarray(0)
    d, multipliers, _, _ = lax.while_loop(unfinished, improve, start)
    return d, multipliers * factor
