"""Weights of modal derivatives for selection and compression, from expected amplitudes of the columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from supple.algebra import read_only
from supple.body import FlexibleBody
from supple.errors import ModelError
from supple.reduction.bases.linear_basis import LinearBasis
from supple.reduction.derivatives.modal_derivatives import ModalDerivatives

__all__ = [
    "AmplitudeProduct",
    "ModalAmplitudes",
    "ModalVirtualWork",
    "PairCriterion",
    "StaticLoad",
    "UnitLoad",
]


class ModalAmplitudes(Protocol):
    """Expected static amplitude of each column of a linear basis: UnitLoad or StaticLoad."""

    def amplitudes(self, body: FlexibleBody, basis: LinearBasis) -> np.ndarray:
        """(m,) amplitudes p_j >= 0."""
        ...


class PairCriterion(Protocol):
    """Ranking of pairs of columns: AmplitudeProduct or ModalVirtualWork."""

    def rank(self, body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives) -> np.ndarray:
        """(n_pairs,) values >= 0; pairs with larger values are preferred."""
        ...


@dataclass(frozen=True)
class UnitLoad:
    """Amplitudes under an unknown load, assumed to do equal work on every column: p_j = 1/omega_j^2."""

    def amplitudes(self, body: FlexibleBody, basis: LinearBasis) -> np.ndarray:  # noqa: ARG002 (protocol)
        """(m,) 1/omega^2."""
        return basis.frequencies**-2.0


@dataclass(frozen=True, eq=False)
class StaticLoad:
    """Amplitudes under a known load F (n_nodal,) on the nodal freedoms: p_j = |phi_j^T F| / omega_j^2."""

    nodal_load: np.ndarray

    def __post_init__(self):
        object.__setattr__(self, "nodal_load", read_only(self.nodal_load))

    def amplitudes(self, body: FlexibleBody, basis: LinearBasis) -> np.ndarray:
        """(m,); ModelError if the load does not fit the body, or does no work on any column."""
        n_nodal = body.n_nodal
        load = self.nodal_load
        if load.shape != (n_nodal,):
            raise ModelError(
                f"the load has shape {load.shape}, but body '{body.name}' has {n_nodal} nodal freedoms "
                f"({body.dofs_per_node} per node)"
            )
        amplitudes = np.abs(basis.vectors.T @ (body.expansion.T @ load)) / basis.frequencies**2
        if not amplitudes.any():
            raise ModelError(f"the load that weights the derivatives excites no mode of body '{body.name}'")
        return amplitudes


@dataclass(frozen=True)
class AmplitudeProduct:
    """Weight w_jk of the modal derivative theta_jk, from the expected amplitudes p_j of the columns.

        w_jk = p_j p_k for j = k,   2 p_j p_k for j < k

    It is the factor of theta_jk in the sum over all j and k of theta_jk p_j p_k, twice the second-order
    motion. With UnitLoad(), p_j p_k = 1/(omega_j^2 omega_k^2).
    """

    expected: ModalAmplitudes = UnitLoad()

    def weights(self, body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives) -> np.ndarray:
        """(n_pairs,) weights."""
        amplitudes = self.expected.amplitudes(body, basis)
        return derivatives.multiplicity * amplitudes[derivatives.pairs].prod(axis=1)

    def rank(self, body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives) -> np.ndarray:
        """The weights themselves."""
        return self.weights(body, basis, derivatives)


@dataclass(frozen=True)
class ModalVirtualWork:
    """Work of the second-order internal force of a pair on the modal derivative of this pair.

        W_jk = |(w_jk theta_jk)^T w_jk f''(X_j, X_k)| = w_jk^2 theta_jk^T K theta_jk

    w_jk is the weight of `AmplitudeProduct`. The multipliers do no work because D theta = 0. Hence W_jk is
    twice the linear strain energy of w_jk theta_jk.
    Source: after the modal virtual work of [Jain2017], here at static amplitudes instead of simulated ones.
    """

    expected: ModalAmplitudes = UnitLoad()

    def rank(self, body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives) -> np.ndarray:
        """(n_pairs,) virtual works."""
        weights = AmplitudeProduct(self.expected).weights(body, basis, derivatives)
        theta = derivatives.vectors
        return weights**2 * np.einsum("ij,ij->j", theta, body.stiffness @ theta)
