"""Projected nodal central difference: leap-frog of the nodes, projected on the motions of frame and modes.

    B(q_n)^T M [x(q_n+1) - 2 x_n + x_n-1] = h^2 {B(q_n)^T f_n - [0; K_L y_n] + G_n^T lambda},   D(p_n+1) = 0

with B = dx/dq, for equal steps. It follows from the discrete Lagrangian 1/(2h) |x(q_n+1) - x(q_n)|_M^2 -
h V(y_n). No term is neglected: gyroscopic, centrifugal and Euler forces are included, without a force that
depends on velocity. Momentum is conserved exactly, energy stays bounded, and the step limit is that of the
modes. The increment of a point is bilinear in the unknowns dp and dy,

    x_n+1 - x_n = xi_n dp + P_n Phi dy + dP Phi dy.

The equation is solved for dp and dy, because differences of positions would lose digits. Newton's method
keeps the Jacobian of t_n: each iteration multiplies the error by about the rotation angle (rad) of the step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from supple.methods.explicit.frame_model import (
    FrameModel,
    FrameState,
    Generalized,
    StepLengths,
    elastic_force,
    link_residual,
    link_rows,
    link_vectors,
)
from supple.methods.explicit.frame_moments import Spread, arms, spread
from supple.methods.explicit.spin_stiffness import spin_products

__all__ = ["ProjectedDifference"]

Gaps = Callable[[tuple[FrameState, ...]], Array]
"""Constraint residuals (R,) of ties and joints in given states."""

_MOST_PASSES = 40  # largest number of iterations of a step
_SMALL = 1e-13  # last correction relative to the arm; the next one is smaller by the rotation of a step


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
        self, model: FrameModel, state: FrameState, force: Generalized, steps: StepLengths
    ) -> tuple[FrameState, Array]:
        """The state after the step, and the link multipliers (6,), N/m; `force` applies at t_n."""
        none = jnp.zeros(0)
        after, multipliers, _ = self.step_joined((model,), (state,), (force,), (), lambda _: none, steps)
        return after[0], multipliers[0]

    def step_joined(
        self,
        models: tuple[FrameModel, ...],
        states: tuple[FrameState, ...],
        forces: tuple[Generalized, ...],
        rows: tuple[Generalized, ...],
        gaps: Gaps,
        steps: StepLengths,
    ) -> tuple[tuple[FrameState, ...], tuple[Array, ...], Array]:
        """Tied or joined frames after the step; multipliers of links (6,), and of ties and joints (R,).

        rows : for each frame at t_n, (R, 4, 3) on the points and (R, k) on the modes; () without ties
        gaps : constraint residuals (R,) of the states at t_n+1, which the step makes zero
        """
        h, mean = steps.after, steps.mean
        frozen, guesses = [], []
        for model, state, force in zip(models, states, forces, strict=True):
            frozen.append(_frozen(model, state, force, steps))
            guesses.append(Generalized(h * state.vp, h * state.vy))
        increments, links, pulls = _increments(tuple(frozen), states, tuple(guesses), rows, gaps)
        after = tuple(
            FrameState(state.p + d.p, state.y + d.y, d.p / h, d.y / h)
            for state, d in zip(states, increments, strict=True)
        )
        return after, tuple(each / (h * mean) for each in links), pulls / (h * mean)

    def joining_work(
        self,
        rows: tuple[Generalized, ...],
        old: tuple[FrameState, ...],
        new: tuple[FrameState, ...],
        pulls: Array,
        steps: StepLengths,
    ) -> Array:
        """Work (R,) of the multipliers of ties and joints in a step, J.

        It is zero except for the effect of finite rotation, as for links, and for joints with laws.
        """
        opened = sum(
            own.p.reshape(-1, 12) @ (0.5 * (a.vp + b.vp)).reshape(12) + own.y @ (0.5 * (a.vy + b.vy))
            for own, a, b in zip(rows, old, new, strict=True)
        )
        return steps.mean * pulls * opened

    def turning_work(
        self, model: FrameModel, old: FrameState, new: FrameState, multipliers: Array, steps: StepLengths
    ) -> Array:
        """Work of links and bilinear motion in a step, due to its finite rotation, J.

        With nodal velocities v = B d +- b half a step after and before t_n (d = (p', y'), b = h P' Phi y'),
        the kinetic energy grows by <M (v+ - v-), (v+ + v-) / 2>. Forces contribute B^T f . d; there remains

            lambda . G d + 1/2 [(d+ - d-) . B^T M (b+ - b-) + <b+, M b+> - <b-, M b->]

        This expression is exact. The work vanishes with the step, and does not accumulate, because the scheme
        is variational.
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


class _Frozen(NamedTuple):
    """Constants of a frame's step in all Newton iterations: B_n^T M B_n with the links, inverted.

    The modes are eliminated first; the links make the remaining matrix regular, even where modes include a
    uniform strain.

    unit : a mass, for scale;   factor : scales the rows of the links to masses
    spun : (6, k) impulse of the centrifugal stiffness per product of angular velocities after t_n, or None
    after : step h, s
    """

    model: FrameModel
    p: Array
    t: _Tangent
    right: Generalized
    modal_mass: Array | float
    unit: Array
    factor: Array
    border: Array
    inverse: Array
    spun: Array | None
    after: Array | float


def _frozen(model: FrameModel, state: FrameState, force: Generalized, steps: StepLengths) -> _Frozen:
    p, y, vp, vy = state
    h, mean = steps.after, steps.mean
    t = _tangent(model, p, y)
    moved, bilinear = _momentum(t, Generalized(vp, vy)), _bilinear(model, t, vp, vy)
    drag = 0.5 * mean * model.mass_damping
    right_p = h * (moved.p - steps.before * bilinear.p + mean * force.p)
    right_y = h * (
        moved.y - steps.before * bilinear.y + mean * (force.y + elastic_force(model, y, vy)) - drag * vy
    )
    spun = None
    if model.spin_stiffness is not None:
        # Half from the angular velocity before t_n, half from that after it: second order, reversible.
        spun = -0.5 * h * mean * (model.spin_stiffness @ y)
        right_y = right_y + spin_products(p, vp) @ spun
    unit = t.sums.Xi[0, 0] + t.sums.Xi[1, 1]
    factor = unit / jnp.sqrt(model.squared_lengths[0])
    S = jnp.kron(t.sums.Xi, jnp.eye(3)) - t.A_py @ t.A_py.T / (1 + drag)
    border = t.G * factor
    inverse = jnp.linalg.inv(jnp.block([[S, -border.T], [border, jnp.zeros((6, 6))]]))
    right = Generalized(right_p, right_y)
    return _Frozen(model, p, t, right, 1 + drag, unit, factor, border, inverse, spun, h)


def _residuals(f: _Frozen, d: Generalized, links: Array) -> tuple[Array, Array, Array]:
    """Residuals of momentum on points (12,) and modes (k,), and of the links (6,)."""
    moved, bilinear = _momentum(f.t, d), _bilinear(f.model, f.t, *d)
    r_p = (f.right.p - moved.p - bilinear.p).reshape(12) + f.border.T @ links
    r_y = f.right.y - moved.y - bilinear.y - (f.modal_mass - 1) * d.y
    if f.spun is not None:
        r_y = r_y + spin_products(f.p, d.p / f.after) @ f.spun
    return r_p, r_y, -link_residual(f.p + d.p, f.model.squared_lengths) * f.factor


def _corrections(f: _Frozen, r_p: Array, r_y: Array, r_D: Array) -> tuple[Array, Array, Array]:
    """Corrections of points (12, ..), modes (k, ..) and links (6, ..) for residuals, or columns of them."""
    solved = f.inverse @ jnp.concatenate([r_p - f.t.A_py @ r_y / f.modal_mass, r_D])
    dp = solved[:12]
    return dp, (r_y - f.t.A_py.T @ dp) / f.modal_mass, solved[12:]


class _Bound(NamedTuple):
    """The rows J (R, 12), (R, k) of ties and joints on a frame, and its responses Z to unit multipliers."""

    on_points: Array
    on_modes: Array
    responses: tuple[Array, Array, Array]


def _bound(frozen: tuple[_Frozen, ...], rows: tuple[Generalized, ...]) -> tuple[tuple[_Bound, ...], Array]:
    """The rows of each frame, and the inverse of H = sum J Z, (R, R)."""
    bound, H = [], jnp.zeros(())
    for f, own in zip(frozen, rows, strict=True):
        J_p, J_y = own.p.reshape(-1, 12), own.y
        Z = _corrections(f, J_p.T, J_y.T, jnp.zeros((6, len(J_p))))
        bound.append(_Bound(J_p, J_y, Z))
        H = H + J_p @ Z[0] + J_y @ Z[1]
    return tuple(bound), jnp.linalg.inv(H)


class _Pass(NamedTuple):
    """Iterate of Newton's method."""

    increments: tuple[Generalized, ...]
    links: tuple[Array, ...]
    pulls: Array
    size: Array
    passes: Array


def _increments(
    frozen: tuple[_Frozen, ...],
    states: tuple[FrameState, ...],
    guesses: tuple[Generalized, ...],
    rows: tuple[Generalized, ...],
    gaps: Gaps,
) -> tuple[tuple[Generalized, ...], tuple[Array, ...], Array]:
    """Increments d, lambda, mu: B_n^T M (x(q_n + d) - x_n) = right + G_n^T lambda + J_n^T mu, D = 0, g = 0.

    Each iteration solves frame by frame; the remaining residuals g then determine mu (Schur complement).
    """
    bound, inverse = _bound(frozen, rows) if rows else ((), jnp.zeros((0, 0)))

    def improve(now: _Pass) -> _Pass:
        changes = []
        for number, f in enumerate(frozen):
            r_p, r_y, r_D = _residuals(f, now.increments[number], now.links[number])
            if rows:
                r_p = r_p + bound[number].on_points.T @ now.pulls
                r_y = r_y + bound[number].on_modes.T @ now.pulls
            changes.append(_corrections(f, r_p, r_y, r_D))
        pulls = now.pulls
        if rows:
            moved = tuple(
                at._replace(p=at.p + d.p, y=at.y + d.y) for at, d in zip(states, now.increments, strict=True)
            )
            opened = gaps(moved) + sum(
                own.on_points @ dp + own.on_modes @ dy
                for own, (dp, dy, _) in zip(bound, changes, strict=True)
            )
            more = -inverse @ opened
            pulls = pulls + more
            changes = [
                tuple(part + Z @ more for part, Z in zip(change, own.responses, strict=True))
                for own, change in zip(bound, changes, strict=True)
            ]
        size = jnp.zeros(())
        for f, (dp, dy, _) in zip(frozen, changes, strict=True):
            scale = f.model.squared_lengths[0]
            on_modes = jnp.abs(dy).max(initial=0.0) * jnp.sqrt(1 / f.unit / scale)
            size = jnp.maximum(size, jnp.abs(dp).max() / jnp.sqrt(scale) + on_modes)
        increments = tuple(
            d + Generalized(dp.reshape(4, 3), dy)
            for d, (dp, dy, _) in zip(now.increments, changes, strict=True)
        )
        links = tuple(old + change[2] for old, change in zip(now.links, changes, strict=True))
        return _Pass(increments, links, pulls, size, now.passes + 1)

    def unfinished(now: _Pass) -> Array:
        return (now.size > _SMALL) & (now.passes < _MOST_PASSES)

    start = _Pass(
        guesses,
        tuple(jnp.zeros(6) for _ in frozen),
        jnp.zeros(len(inverse)),
        jnp.asarray(jnp.inf),
        jnp.asarray(0),
    )
    done = lax.while_loop(unfinished, improve, start)
    links = tuple(each * f.factor for each, f in zip(done.links, frozen, strict=True))
    return done.increments, links, done.pulls
