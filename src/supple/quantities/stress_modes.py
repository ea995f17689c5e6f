"""Stress modes: the stress of a reduced body over time, without a full vector per step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.errors import ModelError
from supple.fem import (
    FiniteElementModel,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)
from supple.quantities.tensor_modes import TensorModes, tensor_modes
from supple.reduction import ReducedBody

__all__ = ["StrainModes", "StressModes", "strain_modes", "stress_modes"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StressModes:
    """Second Piola-Kirchhoff stress at nodes of a reduced body, Pa: `fem.stress_recovery`'s of its motion.

    modes : TensorModes     of N nodes; l = 1 layer (solids) or 3 (shells: bottom, middle, top)
    """

    modes: TensorModes

    @property
    def nodes(self) -> NDArray[np.int64]:
        """The node numbers (N,)."""
        return self.modes.nodes

    def at(self, coordinates: ArrayLike) -> Array:
        """Stress (..., N, l, 6), xx yy zz yz xz xy in the body's frame, of coordinates (..., r)."""
        return self.modes.at(coordinates)

    def von_mises(self, coordinates: ArrayLike) -> Array:
        """Von Mises stress (..., N), the largest over the layers; in blocks of times that fit in memory."""
        return self.modes.largest(coordinates, von_mises)


@dataclass(frozen=True, eq=False)
class StrainModes:
    """Green-Lagrange strain at nodes of a reduced body: `fem.strain_recovery`'s of its motion.

    modes : TensorModes     as in StressModes; engineering shears
    """

    modes: TensorModes

    @property
    def nodes(self) -> NDArray[np.int64]:
        """The node numbers (N,)."""
        return self.modes.nodes

    def at(self, coordinates: ArrayLike) -> Array:
        """Strain (..., N, l, 6), xx yy zz yz xz xy in the body's frame, of coordinates (..., r)."""
        return self.modes.at(coordinates)

    def von_mises(self, coordinates: ArrayLike) -> Array:
        """Von Mises equivalent strain (..., N), sqrt(2/3 e:e), the largest over the layers."""
        return self.modes.largest(coordinates, von_mises_strain)


def stress_modes(body: ReducedBody, model: FiniteElementModel, nodes: ArrayLike | None = None) -> StressModes:
    """Stress modes of a reduced body: computed once, then a small matrix product per instant.

        sigma(gamma) = S1 gamma + S2 (gamma gamma) + S3 z(gamma)

    S1 holds the stress of each column, S2 that of each pair of columns by the quadratic part of the strain,
    without which a body that turns far against its frame, as a bent blade does, shows stress that it does
    not have. S3 holds that of the condensed motion z, which takes back the stress of stiff motion that the
    columns lack. A linear body has S1 alone, the stress that belongs to its K gamma. Memory: N l 6 r numbers,
    and N 6 r(r+1)/2 and N l 6 m (m fields of z) for a nonlinear body; choose nodes where that is much.

    Parameters
    ----------
    body : ReducedBody
    model : FiniteElementModel      the one the body was made of
    nodes : int array (N,)          numbers of the nodes of interest; all of them when omitted

    Raises
    ------
    ModelError   a model of other nodes or freedoms, a node number outside it, a laminate
    """
    _check_same(body, model)
    return StressModes(tensor_modes(body, stress_recovery(model), nodes))


def strain_modes(body: ReducedBody, model: FiniteElementModel, nodes: ArrayLike | None = None) -> StrainModes:
    """Strain modes of a reduced body: as stress_modes, with the same parameters and errors."""
    _check_same(body, model)
    return StrainModes(tensor_modes(body, strain_recovery(model), nodes))


def _check_same(body: ReducedBody, model: FiniteElementModel) -> None:
    same_count = body.nodal_basis.shape[0] == model.n_dofs and body.nodes.shape == model.mesh.nodes.shape
    if not (same_count and np.array_equal(body.nodes, model.mesh.nodes)):
        raise ModelError(
            f"body '{body.name}' ({len(body.nodes)} nodes of {body.dofs_per_node} freedoms) was not made of "
            f"this model ({model.mesh.n_nodes} nodes of {model.dofs_per_node}); give the model it was made of"
        )
