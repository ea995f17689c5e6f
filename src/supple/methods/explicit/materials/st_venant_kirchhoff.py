"""St. Venant-Kirchhoff material: stress linear in the Green-Lagrange strain, as in full bodies."""

from __future__ import annotations

from dataclasses import dataclass

from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.materials.law import MaterialResponse, linear_stress, no_dissipation
from supple.methods.explicit.tensor3 import Tensor, cofactor, determinant, product, tensor, transposed

__all__ = ["StVenantKirchhoff"]


@dataclass(frozen=True)
class StVenantKirchhoff:
    """P = F (lambda tr(E) I + 2 mu E), E = (F^T F - I) / 2; for small strains: it softens in compression."""

    elastic: Isotropic

    def initial(self, shape: tuple[int, ...]) -> tuple[()]:  # noqa: ARG002 - of the protocol
        """No internal variables."""
        return ()

    def respond(self, F: Tensor, dF: Tensor, state: tuple[()]) -> MaterialResponse:  # noqa: ARG002 - of the protocol
        """Stress at F."""
        C = product(transposed(F), F)
        E = tensor(lambda i, j: 0.5 * (C[i][j] - (1.0 if i == j else 0.0)))
        stress = product(F, linear_stress(self.elastic, E))
        return MaterialResponse(stress, state, no_dissipation(F), determinant(F, cofactor(F)))

    def plastic_strain(self, state: tuple[()]) -> Array | None:  # noqa: ARG002 - of the protocol
        """None, without plasticity."""
        return None
