"""Four-point frame as published: constant mass, lagged or no gyroscopic force, optional link schemes.

    [M_E  M_C^T; M_C  M_V] [p''; y''] = F + F_gyr + [G^T lambda; -K_L y - C_L y'],   M_C linear in P

The scheme neglects the local displacement u_L relative to X: momentum has an error O(u_L / l). The links of
the open implementation act along the *predicted* link d + h v, from one linear solution. They reduce the
angular velocity by the fraction 2 pi Omega h per revolution. Both errors are kept to reproduce published
results; `ProjectedDifference` has neither.

Source: [Radioss] (9)-(25), and its routine FXLINK for `PredictedLinks`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

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
from supple.methods.explicit.frame_moments import arms

__all__ = ["ExactLinks", "LaggedGyroscopicForce", "NoGyroscopicForce", "PredictedLinks", "PublishedScheme"]


@dataclass(frozen=True)
class PredictedLinks:
    """Forces along d + h v from one linear equation, which also corrects length errors of earlier steps."""

    def accelerations(
        self, inverse_mass: Array, free: Array, p: Array, v: Array, squared_lengths: Array, steps: StepLengths
    ) -> tuple[Array, Array]:
        """Accelerations (12 + k,) and multipliers (6,), from accelerations `free` without links.

        The predicted links give the constraint and the directions of the forces.
        """
        d, rate, h = link_vectors(p), link_vectors(v), steps.after
        rows = _padded(link_rows(d + h * rate), len(free))
        open_ = ((squared_lengths - (d * d).sum(axis=1)) / h - ((2 * d + h * rate) * rate).sum(axis=1)) / (
            2 * h
        )
        spread = inverse_mass @ rows.T
        multipliers = jnp.linalg.solve(rows @ spread, open_ - rows @ free)
        return free + spread @ multipliers, multipliers


@dataclass(frozen=True)
class ExactLinks:
    """SHAKE: forces along the links at t_n such that D(p_n+1) = 0."""

    def accelerations(
        self, inverse_mass: Array, free: Array, p: Array, v: Array, squared_lengths: Array, steps: StepLengths
    ) -> tuple[Array, Array]:
        """As for `PredictedLinks`; Newton's method with a frozen Jacobian, to round-off."""
        h = steps.after
        rows = _padded(link_rows(link_vectors(p)), len(free))
        spread = inverse_mass @ rows.T
        inverse = jnp.linalg.inv(rows @ spread)

        def improve(carry):
            multipliers, _, passes = carry
            a = (free + spread @ multipliers)[:12].reshape(4, 3)
            residual = link_residual(p + h * (v + steps.mean * a), squared_lengths)
            size = jnp.abs(residual).max() / squared_lengths[0]
            return multipliers - inverse @ residual / (h * steps.mean), size, passes + 1

        multipliers, _, _ = lax.while_loop(
            lambda carry: (carry[1] > 1e-15) & (carry[2] < 30),
            improve,
            (jnp.zeros(6), jnp.asarray(jnp.inf), jnp.asarray(0)),
        )
        return free + spread @ multipliers, multipliers


@dataclass(frozen=True)
class NoGyroscopicForce:
    """No gyroscopic force, as in the open implementation."""

    def force(self, model: FrameModel, p: Array, v: Array, rates: Array) -> Generalized:  # noqa: ARG002
        """Zero."""
        return Generalized(jnp.zeros_like(p), jnp.zeros_like(rates))


@dataclass(frozen=True)
class LaggedGyroscopicForce:
    """-2 M_C^T(P') y' and -2 sum (P^T P')_ij C_ij y' at the last half step, as published."""

    def force(self, model: FrameModel, p: Array, v: Array, rates: Array) -> Generalized:
        """Force on points and modes, from the velocities half a step earlier; linear in their rates."""
        P, dP = arms(p), arms(v)
        k = len(rates)
        on_modes = (P.T @ dP).reshape(9) @ (model.moments.C.reshape(9, k, k) @ rates)
        return Generalized(-2 * (model.moments.S1 @ rates) @ dP.T, -2 * on_modes)


@dataclass(frozen=True)
class PublishedScheme:
    """The published scheme; the defaults are those of its open implementation.

    links : PredictedLinks() or ExactLinks()
    gyroscopic : NoGyroscopicForce() or LaggedGyroscopicForce()
    """

    links: PredictedLinks | ExactLinks = field(default_factory=PredictedLinks)
    gyroscopic: NoGyroscopicForce | LaggedGyroscopicForce = field(default_factory=NoGyroscopicForce)

    def step(
        self, model: FrameModel, state: FrameState, force: Generalized, steps: StepLengths
    ) -> tuple[FrameState, Array]:
        """The state after the step, and the link multipliers (6,); `force` applies at t_n."""
        p, y, vp, vy = state
        mean = steps.mean
        M_C = jnp.einsum("il,alk->aik", arms(p), model.moments.S1).reshape(12, -1)
        modal = jnp.eye(len(y)) * (1 + 0.5 * mean * model.mass_damping)
        mass = jnp.block([[jnp.kron(model.moments.S0, jnp.eye(3)), M_C], [M_C.T, modal]])
        inverse_mass = jnp.linalg.inv(mass)
        total = force + self.gyroscopic.force(model, p, vp, vy)
        on_modes = total.y + elastic_force(model, y, vy) - model.mass_damping * vy
        free = inverse_mass @ jnp.concatenate([total.p.reshape(12), on_modes])
        a, multipliers = self.links.accelerations(inverse_mass, free, p, vp, model.squared_lengths, steps)
        vp, vy = vp + mean * a[:12].reshape(4, 3), vy + mean * a[12:]
        return FrameState(p + steps.after * vp, y + steps.after * vy, vp, vy), multipliers

    def turning_work(self, *_: FrameModel | FrameState | Array | StepLengths) -> Array:
        """Zero: the energy error of the neglected terms remains in the balance."""
        return jnp.zeros(())


def _padded(rows: Array, size: int) -> Array:
    return jnp.hstack([rows, jnp.zeros((6, size - 12))])
