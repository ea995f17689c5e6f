"""Selection of modal derivatives: the pairs of highest rank, in order."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from supple.algebra import mass_orthonormalize
from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame
from supple.reduction.bases.linear_basis import LinearBasis
from supple.reduction.derivatives.derivative_columns import DerivativeColumns, check_derivative_count
from supple.reduction.derivatives.modal_derivatives import ModalDerivatives, modal_derivatives
from supple.reduction.derivatives.pair_weights import AmplitudeProduct, PairCriterion

__all__ = ["PickedDerivatives", "pick"]


@dataclass(frozen=True)
class PickedDerivatives:
    """Add the n modal derivatives that a criterion ranks highest.

    A derivative that depends linearly on the basis and on derivatives of higher rank is skipped, and the
    next one is taken. Fewer than n columns result only if there are fewer independent derivatives.

    n : number of columns to add
    criterion : AmplitudeProduct(...) or ModalVirtualWork(...)
    Source: [Wu2019] section 5.1; [Jain2017].
    """

    n: int
    criterion: PairCriterion = field(default_factory=AmplitudeProduct)

    def __post_init__(self) -> None:
        check_fields(self)

    def columns(self, body: FlexibleBody, frame: Frame, basis: LinearBasis) -> DerivativeColumns:
        """Selected columns, highest rank first; ModelError: fewer than n pairs, or a linear body."""
        check_derivative_count(self.n, len(basis.frequencies))
        derivatives = modal_derivatives(body, frame, basis)
        return pick(body, basis, derivatives, self.n, self.criterion.rank(body, basis, derivatives))


def pick(
    body: FlexibleBody, basis: LinearBasis, derivatives: ModalDerivatives, n: int, rank: np.ndarray
) -> DerivativeColumns:
    """The n independent derivatives of highest rank, M-orthonormal to each other and to the basis."""
    order = np.argsort(-rank, kind="stable")
    n_linear = len(basis.frequencies)
    references = np.concatenate([np.ones(n_linear), derivatives.reference_norms(body)[order]])
    n_tried = n
    while True:
        tried = order[:n_tried]
        together = np.hstack([basis.vectors, derivatives.vectors[:, tried]])
        vectors, kept, dropped = mass_orthonormalize(
            together, body.mass, reference_norms=references[: n_linear + n_tried]
        )
        missing = n_linear + n - len(kept)
        if missing == 0 or n_tried == len(order):
            break
        n_tried = min(n_tried + missing, len(order))
    labels = derivatives.labels
    return DerivativeColumns(
        vectors[:, n_linear:],
        labels=tuple(labels[tried[i - n_linear]] for i in kept[n_linear:]),
        dropped=tuple(labels[tried[i - n_linear]] for i in dropped),
    )
