"""Block of explicit solid elements: total Lagrangian, constant gradients, force summed at the nodes."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from supple.fem import Isotropic
from supple.methods.explicit.elements.bulk_viscosity import BulkArrays, bulk_pressure
from supple.methods.explicit.elements.incidence import gathered, incidence
from supple.methods.explicit.elements.mean_gradient import SolidPoints
from supple.methods.explicit.fusion_barrier import fusion_barrier
from supple.methods.explicit.materials.law import Law, viscous_stress
from supple.methods.explicit.tensor3 import Tensor, as_array, cofactor, tensor

__all__ = ["BlockForce", "SolidBlock", "block_force", "solid_block"]


class SolidBlock(NamedTuple):
    """Constant arrays; elements are the last axis, so that a law compiles to one loop over them.

    nodes : (k, E);   gradients : (k, 3, g, E);   volumes : (g, E)
    gamma : (4 or 0, k, E);   hourglass : (E,) kappa, N/m
    table : (m, N)          element corners at each node, see `incidence`
    bulk : BulkArrays       None without bulk viscosity
    """

    nodes: Array
    gradients: Array
    volumes: Array
    gamma: Array
    hourglass: Array
    table: Array
    bulk: BulkArrays | None = None


class BlockForce(NamedTuple):
    """Forces and works of a block in a step.

    force : (3, N)          negative internal force on the nodes, without hourglass forces
    hourglass : (3, N)      hourglass forces
    state : state of the law;   ratios : (g, E) det F
    plastic, viscous : work of the step, J
    smallest : smallest det F of elements that are not deleted
    """

    force: Array
    hourglass: Array
    state: Any
    ratios: Array
    plastic: Array
    viscous: Array
    smallest: Array


def solid_block(
    points: SolidPoints,
    numbers: np.ndarray,
    n_nodes: int,
    gradients: np.ndarray,
    elastic: Isotropic,
    hourglass: float,
    bulk: BulkArrays | None = None,
) -> SolidBlock:
    """The arrays of a block.

    numbers : (N_part,) numbers of the part's nodes among the n_nodes of the model
    gradients : (E, g, 3, k) gradients at the points, in the axes of space
    hourglass : stiffness of an hourglass mode relative to that of the stretching mode
    """
    nodes = numbers[points.nodes.T]
    return SolidBlock(
        jnp.asarray(nodes),
        jnp.asarray(np.ascontiguousarray(gradients.transpose(3, 2, 1, 0))),
        jnp.asarray(points.volumes.T),
        jnp.asarray(np.ascontiguousarray(points.gamma.transpose(1, 2, 0))),
        jnp.asarray(hourglass_stiffness(points, elastic, hourglass)),
        jnp.asarray(incidence(nodes, n_nodes)),
        bulk,
    )


def hourglass_stiffness(points: SolidPoints, elastic: Isotropic, hourglass: float) -> np.ndarray:
    """Stiffness kappa (E,), N/m: kappa |gamma|^2 is `hourglass` times (lambda + 2 mu) V |b|^2 / 3."""
    b = (points.gradients[:, 0] ** 2).sum(axis=(1, 2)) / 3
    norm = (points.gamma**2).sum(axis=2).max(axis=1, initial=0.0)
    free = np.where(norm > 0, norm, 1.0)
    return hourglass * elastic.elasticity[0, 0] * points.volumes.sum(axis=1) * b / free


def deformation(block: SolidBlock, corners: Array) -> Tensor:
    """sum_k x_k (x) grad N_k of corner vectors (3, k, E), components (g, E)."""
    g = block.gradients
    return tensor(lambda i, j: sum(corners[i, k] * g[k, j] for k in range(len(g))))  # ty: ignore[invalid-argument-type] - a sum of arrays is no int


def block_force(
    law: Law,
    block: SolidBlock,
    x: Array,
    dx: Array,
    state: Any,
    ratios: Array,
    alive: Array,
    beta: Array | None,
    h: Array,
) -> BlockForce:
    """Forces at positions x (3, N), reached by the increment dx in a step h.

    ratios : (g, E) det F before the step;   alive : (E,) 1, or 0 for deleted elements
    beta : stiffness damping, s; None omits its operations
    """
    g, gamma = block.gradients, block.gamma
    # Separate stages: the increment is not computed if the law does not use it.
    corners = fusion_barrier(lambda of: of[:, block.nodes], x)
    moves = fusion_barrier(lambda of: of[:, block.nodes], dx)
    F = fusion_barrier(lambda of: deformation(block, of), corners)
    dF = fusion_barrier(lambda of: deformation(block, of), moves)
    P, state, dissipated, J = law.respond(F, dF, state)
    lost = jnp.zeros_like(J)
    if beta is not None:
        viscous, lost = viscous_stress(law.elastic, beta, F, dF, h)
        P = tensor(lambda i, j: P[i][j] + viscous[i][j])
    if block.bulk is not None:
        bulk = block.bulk
        q, against = fusion_barrier(lambda of: bulk_pressure(bulk, *of, h), (J, ratios))
        lost = lost + against
        cof = cofactor(F)
        P = tensor(lambda i, j: P[i][j] - q * cof[i][j])
    volumes = block.volumes * alive
    stress = fusion_barrier(lambda of: as_array(tensor(lambda i, j: volumes * of[i][j])), P)
    forces = fusion_barrier(
        lambda of: -_summed([of[:, None, j] * g[None, :, j] for j in range(3)]).sum(axis=2), stress
    )
    against = jnp.zeros_like(x)
    if len(gamma):
        kappa = block.hourglass * alive
        amplitudes = fusion_barrier(
            lambda of: kappa * _summed([of[None, :, k] * gamma[:, None, k] for k in range(len(g))]), corners
        )
        corner = fusion_barrier(
            lambda of: -_summed([of[a][:, None] * gamma[None, a] for a in range(4)]), amplitudes
        )
        against = gathered(corner, block.table)
    return BlockForce(
        gathered(forces, block.table),
        against,
        state,
        J,
        jnp.sum(volumes * dissipated),
        jnp.sum(volumes * lost),
        jnp.min(jnp.where(alive > 0, J, 1.0)),
    )


def _summed(terms: list[Array]) -> Array:
    """Sum of arrays, written as one expression, which compiles to one loop."""
    return sum(terms[1:], terms[0])
