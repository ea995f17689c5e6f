"""Elastic materials: linear in the Green-Lagrange strain as in full bodies, and rubber-like."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.materials.law import MaterialResponse, lame, linear_stress
from supple.methods.explicit.tensor3 import Tensor, cofactor, determinant, product, tensor, transposed

__all__ = ["NeoHookean", "StVenantKirchhoff"]


@dataclass(frozen=True)
class _ElasticLaw:
    """A `Law` without internal variables."""

    elastic: Isotropic

    def initial(self, shape: tuple[int, ...]) -> tuple[()]:  # noqa: ARG002 - of the protocol
        """No internal variables."""
        return ()

    def plastic_strain(self, state: tuple[()]) -> Array | None:  # noqa: ARG002 - of the protocol
        """None, without plasticity."""
        return None


@dataclass(frozen=True)
class StVenantKirchhoff(_ElasticLaw):
    """P = F (lambda tr(E) I + 2 mu E), E = (F^T F - I) / 2; for small strains: it softens in compression."""

    def respond(self, F: Tensor, dF: Tensor, state: tuple[()]) -> MaterialResponse:  # noqa: ARG002 - of the protocol
        """Stress at F."""
        C = product(transposed(F), F)
        E = tensor(lambda i, j: 0.5 * (C[i][j] - (1.0 if i == j else 0.0)))
        stress = product(F, linear_stress(self.elastic, E))
        return MaterialResponse(stress, state, jnp.zeros_like(F[0][0]), determinant(F, cofactor(F)))


@dataclass(frozen=True)
class NeoHookean(_ElasticLaw):
    """P = mu (F - F^-T) + lambda ln(J) F^-T, with infinite energy as its volume vanishes.

    Its energy is mu/2 (tr F^T F - 3) - mu ln J + lambda/2 ln^2 J.
    """

    def respond(self, F: Tensor, dF: Tensor, state: tuple[()]) -> MaterialResponse:  # noqa: ARG002 - of the protocol
        """Stress at F."""
        first, mu = lame(self.elastic)
        cof = cofactor(F)
        J = determinant(F, cof)
        on_inverse = (first * jnp.log(J) - mu) / J
        stress = tensor(lambda i, j: mu * F[i][j] + on_inverse * cof[i][j])
        return MaterialResponse(stress, state, jnp.zeros_like(F[0][0]), J)
