"""Compressible neo-Hookean material: rubber-like, with infinite energy as its volume vanishes."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.materials.law import MaterialResponse, lame, no_dissipation
from supple.methods.explicit.tensor3 import Tensor, cofactor, determinant, tensor

__all__ = ["NeoHookean"]


@dataclass(frozen=True)
class NeoHookean:
    """P = mu (F - F^-T) + lambda ln(J) F^-T.

    Its energy is mu/2 (tr F^T F - 3) - mu ln J + lambda/2 ln^2 J.
    """

    elastic: Isotropic

    def initial(self, shape: tuple[int, ...]) -> tuple[()]:  # noqa: ARG002 - of the protocol
        """No internal variables."""
        return ()

    def respond(self, F: Tensor, dF: Tensor, state: tuple[()]) -> MaterialResponse:  # noqa: ARG002 - of the protocol
        """Stress at F."""
        first, mu = lame(self.elastic)
        cof = cofactor(F)
        J = determinant(F, cof)
        on_inverse = (first * jnp.log(J) - mu) / J
        return MaterialResponse(
            tensor(lambda i, j: mu * F[i][j] + on_inverse * cof[i][j]), state, no_dissipation(F), J
        )

    def plastic_strain(self, state: tuple[()]) -> Array | None:  # noqa: ARG002 - of the protocol
        """None, without plasticity."""
        return None
