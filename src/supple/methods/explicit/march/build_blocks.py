"""Element blocks of explicit sub-domains in the model, and the lumped mass of the nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.machine import Placed
from supple.methods.explicit.elements import solid_block
from supple.methods.explicit.explicit_subdomain import ExplicitSubdomain
from supple.methods.explicit.march.element_block import SolidArrays, Solids

__all__ = ["Blocks", "explicit_blocks"]


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of elements, one list entry each, and masses of the nodes.

    rules : law and deletion of each block
    spans : blocks of each part, by its name;   mass : (N,) kg;   damped : (N,) alpha m, kg/s
    """

    mass: NDArray[np.float64]
    damped: NDArray[np.float64]
    blocks: list[SolidArrays] = field(default_factory=list)
    rules: list[Solids] = field(default_factory=list)
    spans: dict[str, slice] = field(default_factory=dict)

    @property
    def step_limit(self) -> float:
        """Step limit of all elements at rest, s; infinite without any."""
        return min((float(own.limit.min()) for own in self.blocks), default=np.inf)


def explicit_blocks(
    parts: Sequence[Placed], numbers: Mapping[str, NDArray[np.int64]], n_nodes: int
) -> Blocks:
    """Blocks of explicit parts; `numbers` maps the nodes of each part to the n_nodes of the model."""
    mass, damped = np.zeros(n_nodes), np.zeros(n_nodes)
    made = Blocks(mass, damped)
    for part in parts:
        body = part.body
        if not isinstance(body, ExplicitSubdomain):
            continue
        own = numbers[body.name]
        np.add.at(mass, own, body.masses)
        if body.damping is not None:
            np.add.at(damped, own, body.damping.alpha * body.masses)
        made.spans[body.name] = slice(len(made.blocks), len(made.blocks) + len(body.points))
        for points, limit, bulk in zip(body.points, body.element_limits, body.bulk_arrays, strict=True):
            turned = points.gradients.swapaxes(2, 3) @ part.rotation.T
            gradients = turned.swapaxes(2, 3)
            beta = 0.0 if body.damping is None else body.damping.beta
            block = solid_block(points, own, n_nodes, gradients, body.law.elastic, body.hourglass, bulk)
            made.blocks.append(SolidArrays(block, jnp.asarray(limit), jnp.asarray(beta) if beta else None))
            made.rules.append(Solids(body.law, body.deletion))
    return made
