"""Block of explicit solid elements: total Lagrangian, constant gradients, force summed at the nodes."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.elements.bulk_viscosity import BulkArrays, bulk_pressure, bulk_share
from supple.methods.explicit.elements.element_block import BlockState, ElementInstant, Forces, with_contact
from supple.methods.explicit.elements.incidence import gathered
from supple.methods.explicit.fusion_barrier import fusion_barrier
from supple.methods.explicit.materials.law import Law, viscous_stress
from supple.methods.explicit.tensor3 import (
    Tensor,
    as_array,
    cofactor,
    deviator,
    double_dot,
    product,
    scaled,
    tensor,
    transposed,
)

__all__ = ["SolidBlock"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class SolidBlock:
    """Constant arrays; elements are the last axis, so that a law compiles to one loop over them.

    nodes : (k, E);   gradients : (k, 3, g, E);   volumes : (g, E)
    gamma : (4 or 0, k, E);   hourglass : (E,) kappa, N/m
    table : (m, N)          element corners at each node, see `incidence`
    bulk : BulkArrays       None without bulk viscosity
    limit : (E,) stable steps at rest, s, without damping or viscosity
    beta : stiffness damping, s; None omits its operations
    """

    nodes: Array
    gradients: Array
    volumes: Array
    gamma: Array
    hourglass: Array
    table: Array
    bulk: BulkArrays | None
    limit: Array
    beta: Array | None
    law: Law = field(metadata={"static": True})
    deletion: float = field(metadata={"static": True})

    def start(self) -> BlockState:
        """Undeformed state."""
        shape = self.volumes.shape
        return BlockState(self.law.initial(shape), jnp.ones(shape), jnp.ones(shape[1]))

    def deformation(self, corners: Array) -> Tensor:
        """sum_k x_k (x) grad N_k of corner vectors (3, k, E), components (g, E)."""
        g = self.gradients
        return tensor(lambda i, j: sum(corners[i, k] * g[k, j] for k in range(len(g))))  # ty: ignore[invalid-argument-type] - a sum of arrays is no int

    def force(self, at: ElementInstant, state: BlockState) -> Forces:
        """Stress, damping and hourglass forces; elements that reach the deletion strain are then deleted."""
        g, gamma, alive, law = self.gradients, self.gamma, state.alive, self.law
        # Separate stages: the increment is not computed if the law does not use it.
        corners = fusion_barrier(lambda of: of[:, self.nodes], at.x)
        moves = fusion_barrier(lambda of: of[:, self.nodes], at.dx)
        F = fusion_barrier(self.deformation, corners)
        dF = fusion_barrier(self.deformation, moves)
        P, material, dissipated, J = law.respond(F, dF, state.material)
        lost = jnp.zeros_like(J)
        if self.beta is not None:
            viscous, lost = viscous_stress(law.elastic, self.beta, F, dF, at.h)
            P = tensor(lambda i, j: P[i][j] + viscous[i][j])
        if self.bulk is not None:
            assert state.ratios is not None
            bulk = self.bulk
            q, against = fusion_barrier(lambda of: bulk_pressure(bulk, *of, at.h), (J, state.ratios))
            lost = lost + against
            cof = cofactor(F)
            P = tensor(lambda i, j: P[i][j] - q * cof[i][j])
        volumes = self.volumes * alive
        stress = fusion_barrier(lambda of: as_array(tensor(lambda i, j: volumes * of[i][j])), P)
        forces = fusion_barrier(
            lambda of: -_summed([of[:, None, j] * g[None, :, j] for j in range(3)]).sum(axis=2), stress
        )
        against = jnp.zeros_like(at.x)
        if len(gamma):
            kappa = self.hourglass * alive
            amplitudes = fusion_barrier(
                lambda of: kappa * _summed([of[None, :, k] * gamma[:, None, k] for k in range(len(g))]),
                corners,
            )
            corner = fusion_barrier(
                lambda of: -_summed([of[a][:, None] * gamma[None, a] for a in range(4)]), amplitudes
            )
            against = gathered(corner, self.table)
        strain, left = law.plastic_strain(material), alive
        if strain is not None and self.deletion != float("inf"):
            left = alive * (strain.max(axis=0) < self.deletion)
        return Forces(
            gathered(forces, self.table),
            BlockState(material, J, left),
            hourglass=against,
            plastic=jnp.sum(volumes * dissipated),
            viscous=jnp.sum(volumes * lost),
            smallest=jnp.min(jnp.where(alive > 0, J, 1.0)),
        )

    def longest_step(self, x: Array, v: Array, alive: Array, contact_rate: Array) -> Array:
        """Step limit of the remaining elements in their present state, s, with all contacts closed.

        The limit at rest is multiplied by the smallest stretch, divided by sqrt(det F) where the volume has
        grown. The result includes the bulk viscosity, but not the stiffness damping.
        """
        F = self.deformation(x[:, self.nodes])
        each = as_array(F)
        C = jnp.einsum("kige,kjge->geij", each, each)
        least = jnp.sqrt(jnp.maximum(jnp.linalg.eigvalsh(C)[..., 0], 0.0))
        volume = jnp.sqrt(jnp.maximum(jnp.linalg.det(C), 0.0)) ** 0.5
        stretch = jnp.minimum(least, least / jnp.maximum(volume, 1e-30)).min(axis=0)
        longest = with_contact(self.limit * stretch, contact_rate)
        if self.bulk is not None:
            xi = bulk_share(self.bulk, F, self.deformation(v[:, self.nodes])) / stretch
            longest = longest * (jnp.sqrt(1 + xi**2) - xi)
        return jnp.min(jnp.where(alive > 0, longest, jnp.inf))

    def recorded(self, x: Array, _triads: Array, state: BlockState) -> tuple[Array, Array]:
        """Plastic strain and von Mises stress, Pa, (E,) at the worst point of each element.

        sqrt(3/2 s : s) with the deviator s of the Cauchy stress sigma = P F^T / J. With a zero increment, the
        law returns its present stress, also beyond yield.
        """
        F = self.deformation(x[:, self.nodes])
        response = self.law.respond(F, scaled(0.0, F), state.material)
        sigma = scaled(1 / response.volume_ratio, product(response.stress, transposed(F)))
        _, s = deviator(sigma)
        mises = jnp.sqrt(1.5 * double_dot(s, s)).max(axis=0)
        strain = self.law.plastic_strain(state.material)
        return jnp.zeros_like(state.alive) if strain is None else strain.max(axis=0), state.alive * mises


def _summed(terms: list[Array]) -> Array:
    """Sum of arrays, written as one expression, which compiles to one loop."""
    return sum(terms[1:], terms[0])
