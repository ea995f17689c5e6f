"""Static modal derivatives: the second-order motion due to each pair of linear columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import ReadOnlyArrays
from supple.body import FlexibleBody, Frame, frame_projector
from supple.errors import ModelError
from supple.reduction.bases.linear_basis import LinearBasis

__all__ = ["ModalDerivatives", "modal_derivatives"]


@dataclass(frozen=True, eq=False)
class ModalDerivatives(ReadOnlyArrays):
    """Modal derivatives theta_jk of all pairs of columns.

    vectors : (n, n_pairs)
    pairs : (n_pairs, 2) int     columns j <= k of each pair, from 0, in the order of numpy.triu_indices
    """

    vectors: np.ndarray
    pairs: np.ndarray

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels such as 'derivative 1-3', with columns counted from 1."""
        return tuple(f"derivative {j + 1}-{k + 1}" for j, k in self.pairs)

    @property
    def multiplicity(self) -> np.ndarray:
        """Number of occurrences of each pair in the double sum over j and k: 1 for j = k, otherwise 2."""
        return np.where(self.pairs[:, 0] == self.pairs[:, 1], 1.0, 2.0)

    def reference_norms(self, body: FlexibleBody) -> np.ndarray:
        """M-norm of each derivative, or 1/100 of the largest norm if this is larger.

        The part of a derivative outside other columns is compared with this norm. A derivative that is zero
        by symmetry has only rounding errors, so its own norm would be no reference.
        """
        lengths = np.sqrt(np.sum(self.vectors * (body.mass @ self.vectors), axis=0))
        return np.maximum(lengths, 0.01 * lengths.max(initial=0.0))


def modal_derivatives(body: FlexibleBody, frame: Frame, basis: LinearBasis) -> ModalDerivatives:
    """Modal derivatives theta_jk: second derivatives of the static motion q at loads K X zeta.

        f(q) + D^T mu = K X zeta,  D q = 0   gives   d2q/dzeta_j dzeta_k = theta_jk at zeta = 0:
        K theta_jk + D^T mu = -f''(X_j, X_k),  D theta_jk = 0

    X are the m columns of the linear basis, f is the nonlinear internal force. f'' is exact, from the
    quadratic strains. All m(m+1)/2 pairs need one factorisation and one block of solves. If the basis fixes
    interfaces, they are fixed here, too: all of them in a Craig-Bampton basis, only that of the frame in a
    Rubin basis. A rigid motion, which stores no energy, is then added, so that the result satisfies the
    conditions of the frame, D theta_jk = 0.

    Returns ModalDerivatives, with j <= k because theta_jk = theta_kj.
    Raises ModelError if the body has no quadratic strains (a superelement, or a linearised body).
    Source: [Wu2019] (39)-(43).
    """
    if body.is_linear:
        raise ModelError(
            f"body '{body.name}' has no quadratic strains (a superelement, or linearised), "
            "so it has no modal derivatives; reduce it with derivatives=NoDerivatives()"
        )
    forces = body.assembly.pair_forces(basis.vectors)
    vectors = frame_projector(body, frame)(basis.static_solver.solve(-forces))
    return ModalDerivatives(vectors, np.column_stack(np.triu_indices(basis.vectors.shape[1])))
