"""Couplings of the modes as dense tensors, for comparison with the factorised equations."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from supple.methods.intrinsic.line_equations import l1, l2
from supple.methods.intrinsic.line_model import LineModel

__all__ = ["DenseCouplings", "dense_couplings", "dense_rates"]


class DenseCouplings(NamedTuple):
    """Gamma_1 (m, m, m) and Gamma_2 (m, e, e), for m modes of which e are elastic."""

    first: jax.Array
    second: jax.Array


def dense_couplings(model: LineModel) -> DenseCouplings:
    """The coupling tensors of a line.

        Gamma_1jkl = <Phi_1j, L_1(Phi_1k) M Phi_1l>,   Gamma_2jkl = <Phi_1j, L_2(Phi_2k) C Phi_2l>

    Source: [Wang2015] (15).
    """
    m, e, n = model.velocities.shape[1], model.omega.shape[0], model.n
    Phi = model.velocities.T.reshape(m, n, 6)
    if model.station_masses is None:
        momenta = model.momenta.T.reshape(m, n, 6)
    else:
        momenta = jnp.einsum("iab,kib->kia", model.station_masses, Phi)
    forces, strains = (array.T.reshape(e, n - 1, 6) for array in (model.forces, model.strains))
    middle = 0.5 * (Phi[:, 1:] + Phi[:, model.inner]) * model.lengths[:, None]
    pairs = jax.vmap(jax.vmap(l1, (None, 0)), (0, None))(Phi, momenta)
    bent = jax.vmap(jax.vmap(l2, (None, 0)), (0, None))(forces, strains)
    return DenseCouplings(jnp.einsum("jia,klia->jkl", Phi, pairs), jnp.einsum("jia,klia->jkl", middle, bent))


def dense_rates(
    model: LineModel, couplings: DenseCouplings, q1: jax.Array, q2: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Rates q_1' (m,) and q_2' (e,) of an unloaded, undamped line, equal to those of `line_rates`.

    Source: [Wang2015] (12)-(14).
    """
    k = model.n_rigid
    first, second = couplings
    d1 = -((first @ q1) @ q1) - ((second @ q2) @ q2)
    d2 = jnp.einsum("jk,j->k", second @ q2, q1) - model.omega * q1[k:]
    return d1.at[k:].add(model.omega * q2), d2
