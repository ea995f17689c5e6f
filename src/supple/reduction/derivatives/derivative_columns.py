"""The columns of modal derivatives that are added to a linear basis."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from supple.algebra import ReadOnlyArrays
from supple.body import FlexibleBody, Frame
from supple.errors import ModelError
from supple.reduction.bases.linear_basis import LinearBasis

__all__ = ["DerivativeChoice", "DerivativeColumns", "NoDerivatives"]


@dataclass(frozen=True, eq=False)
class DerivativeColumns(ReadOnlyArrays):
    """Columns from modal derivatives, M-orthonormal to each other and to the linear basis.

    vectors : (n, k)
    labels : (k,) str
    dropped : labels of the columns left out because they depend on others
    singular_values_kept, singular_values_dropped : ratios to the first singular value; empty for columns that
        are not compressed
    """

    vectors: np.ndarray
    labels: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    singular_values_kept: np.ndarray = field(default_factory=lambda: np.empty(0))
    singular_values_dropped: np.ndarray = field(default_factory=lambda: np.empty(0))


class DerivativeChoice(Protocol):
    """Choice of derivatives to add: PickedDerivatives, CompressedDerivatives or NoDerivatives."""

    def columns(self, body: FlexibleBody, frame: Frame, basis: LinearBasis) -> DerivativeColumns:
        """Columns to append to a basis that `rayleigh_ritz` returned."""
        ...


@dataclass(frozen=True)
class NoDerivatives:
    """No derivatives: for linear bodies, or to compare with a body that has derivatives."""

    def columns(self, body: FlexibleBody, frame: Frame, basis: LinearBasis) -> DerivativeColumns:  # noqa: ARG002
        """No columns."""
        return DerivativeColumns(np.empty((basis.vectors.shape[0], 0)))


def check_derivative_count(n: int, n_linear: int) -> None:
    """Raise ModelError if n_linear columns have fewer than n pairs, or n is negative."""
    n_pairs = n_linear * (n_linear + 1) // 2
    if not 0 <= n <= n_pairs:
        raise ModelError(f"requested {n} derivatives, but {n_linear} linear columns have {n_pairs} pairs")
