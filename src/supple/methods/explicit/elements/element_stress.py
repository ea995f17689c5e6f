"""Von Mises stress of explicit elements, from the Cauchy stress."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jax import Array

from supple.methods.explicit.elements.solid_block import SolidBlock, deformation
from supple.methods.explicit.materials.law import Law
from supple.methods.explicit.tensor3 import double_dot, product, scaled, tensor, transposed

__all__ = ["element_von_mises"]


def element_von_mises(law: Law, block: SolidBlock, x: Array, state: Any) -> Array:
    """Stress sqrt(3/2 s : s) (g, E), Pa, at positions x (3, N); s is the deviator of sigma = P F^T / J.

    With a zero increment, the law returns its present stress, also beyond yield.
    """
    F = deformation(block, x[:, block.nodes])
    response = law.respond(F, scaled(0.0, F), state)
    sigma = scaled(1 / response.volume_ratio, product(response.stress, transposed(F)))
    mean = (sigma[0][0] + sigma[1][1] + sigma[2][2]) / 3
    deviator = tensor(lambda i, j: sigma[i][j] - mean if i == j else sigma[i][j])
    return jnp.sqrt(1.5 * double_dot(deviator, deviator))
