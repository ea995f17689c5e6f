"""J2 plasticity in plane stress: small strains in the axes of a shell, isotropic hardening, backward Euler.

The elastic trial stress returns along the flow direction at the end of the step. In the sum and difference of
the normal stresses and in the shear, both Hooke's law and the von Mises stress are diagonal, so that

    s+ = s+_trial / (1 + c E / (3 (1 - nu))),   s- = s-_trial / (1 + 2 mu c),   t = t_trial / (1 + 2 mu c)
    q(c)^2 = 1/4 s+^2 + 3/4 s-^2 + 3 t^2,       q(c) = sigma_y(eps_p + 2/3 c q(c))

The last equation determines the multiplier c: its left side decreases with c, its right side increases.

Source: J. C. Simo, R. L. Taylor, "A return mapping algorithm for plane stress elastoplasticity", Int. J.
Numer. Methods Eng. 22 (1986) 649-670.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from supple.methods.explicit.materials.j2_plasticity import J2Plasticity

_MOST_PASSES = 60  # largest number of iterations for the multiplier
_SMALL = 1e-12  # relative correction of the multiplier; the next one would be its square


class LayerState(NamedTuple):
    """Plastic strain xx yy xy (3, ...) with engineering shear, and equivalent plastic strain (...)."""

    tensor: Array
    strain: Array


def elastic_state(shape: tuple[int, ...]) -> LayerState:
    """No plastic strain."""
    return LayerState(jnp.zeros((3, *shape)), jnp.zeros(shape))


def plane_stress(law: J2Plasticity, strain: Array, state: LayerState) -> tuple[Array, LayerState, Array]:
    """Stress xx yy xy (3, ...) at a total strain (3, ...), new state, plastic work of the step per volume."""
    E, nu, mu = law.elastic.youngs_modulus, law.elastic.poissons_ratio, law.elastic.shear_modulus
    xx, yy, xy = strain - state.tensor
    total, apart, shear = E / (1 - nu) * (xx + yy), 2 * mu * (xx - yy), mu * xy
    c = _multiplier(law, (total, apart, shear), state.strain)
    on_total, on_rest = 1 + c * E / (3 * (1 - nu)), 1 + 2 * mu * c
    total, apart, shear = total / on_total, apart / on_rest, shear / on_rest
    mises = _mises(total, apart, shear)
    grown = 2 / 3 * c * mises
    stress = jnp.stack([0.5 * (total + apart), 0.5 * (total - apart), shear])
    flow = c * jnp.stack([total / 6 + 0.5 * apart, total / 6 - 0.5 * apart, 2 * shear])
    return stress, LayerState(state.tensor + flow, state.strain + grown), mises * grown


def mises_of(stress: Array) -> Array:
    """Von Mises stress (...) of plane stress (3, ...)."""
    return _mises(stress[0] + stress[1], stress[0] - stress[1], stress[2])


def _mises(total: Array, apart: Array, shear: Array) -> Array:
    return jnp.sqrt(0.25 * total**2 + 0.75 * apart**2 + 3 * shear**2)


def _multiplier(law: J2Plasticity, trial: tuple[Array, Array, Array], strain: Array) -> Array:
    """The multiplier c >= 0, 1/Pa, by Newton's method within a bracket that narrows in each pass."""
    E, nu, mu = law.elastic.youngs_modulus, law.elastic.poissons_ratio, law.elastic.shear_modulus
    fast, slow = 2 * mu, E / (3 * (1 - nu))
    total, apart, shear = trial

    def excess(c: Array) -> Array:
        mises = _mises(total / (1 + slow * c), apart / (1 + fast * c), shear / (1 + fast * c))
        return mises - law.hardening.yield_stress(strain + 2 / 3 * c * mises)

    first = law.hardening.yield_stress(strain)
    trial_mises = _mises(total, apart, shear)
    yields = trial_mises > first
    # An upper bound of c, which c can reach only without hardening; 1 % is added.
    high = jnp.where(yields, 1.01 * (trial_mises / first - 1) / slow, 0.0)

    def unfinished(carry: tuple[Array, Array, Array, Array, Array]) -> Array:
        *_, moved, passes = carry
        return moved & (passes < _MOST_PASSES)

    def narrow(
        carry: tuple[Array, Array, Array, Array, Array],
    ) -> tuple[Array, Array, Array, Array, Array]:
        low, high, c, _, passes = carry
        value, slope = jax.jvp(excess, (c,), (jnp.ones_like(c),))
        low, high = jnp.where(value > 0, c, low), jnp.where(value > 0, high, c)
        better = c - value / slope
        better = jnp.where((better >= low) & (better <= high), better, 0.5 * (low + high))
        return low, high, better, jnp.any(jnp.abs(better - c) > _SMALL * high), passes + 1

    start = jnp.zeros_like(high), high, 0.5 * high, jnp.any(yields), jnp.asarray(0)
    _, _, c, _, _ = lax.while_loop(unfinished, narrow, start)
    return c
