"""Static modal derivatives: the quadratic motion that follows each pair of linear columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import read_only
from supple.body import FlexibleBody, Frame, frame_projector
from supple.errors import ModelError
from supple.reduction.bases.linear_basis import LinearBasis

__all__ = ["ModalDerivatives", "modal_derivatives"]


@dataclass(frozen=True, eq=False)
class ModalDerivatives:
    """Derivatives theta_jk of all pairs of columns.

    vectors : (n, n_pairs)
    pairs : (n_pairs, 2) int     the columns j <= k of each, in the order of numpy.triu_indices
    """

    vectors: np.ndarray
    pairs: np.ndarray

    def __post_init__(self):
        object.__setattr__(self, "vectors", read_only(self.vectors))
        object.__setattr__(self, "pairs", read_only(self.pairs, dtype=np.intp))

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels such as 'derivative 1-3', with columns counted from 1."""
        return tuple(f"derivative {j + 1}-{k + 1}" for j, k in self.pairs)

    @property
    def multiplicity(self) -> np.ndarray:
        """How often each pair occurs in the double sum over j and k: 1 on the diagonal, 2 elsewhere."""
        return np.where(self.pairs[:, 0] == self.pairs[:, 1], 1.0, 2.0)

    def reference_norms(self, body: FlexibleBody) -> np.ndarray:
        """M-norm of each derivative, but at least 1/100 of the largest: the reference for its remainder.

        Where symmetry makes a derivative vanish, the solve leaves round-off, whose length is meaningless.
        """
        lengths = np.sqrt(np.sum(self.vectors * (body.mass @ self.vectors), axis=0))
        return np.maximum(lengths, 0.01 * lengths.max(initial=0.0))


def modal_derivatives(body: FlexibleBody, frame: Frame, basis: LinearBasis) -> ModalDerivatives:
    """Second derivatives of the nonlinear static motion along the columns X of a linear basis.

        f(q) + D^T mu = K X zeta,  D q = 0   gives   d2q/dzeta_j dzeta_k = theta_jk at 0:
        K theta_jk + D^T mu = -f''(X_j, X_k),  D theta_jk = 0

    Exact: f'' comes from the quadratic strains, not from differences. All m(m+1)/2 pairs need one
    factorisation and one block of solves. The interfaces are fixed where the basis fixes them (all for
    Craig-Bampton, only that of the frame for Rubin). A rigid motion, which stores no energy, is then added so
    that the result satisfies the conditions of the frame.

    Returns ModalDerivatives, symmetric in j and k.
    Raises ModelError when the body has no quadratic strains (a superelement, or a linearised body).
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
