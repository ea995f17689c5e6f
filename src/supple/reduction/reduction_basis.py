"""The basis of a reduction: orthonormal columns, and the report of their origin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import ReadOnlyArrays, mass_orthonormalize
from supple.body import FlexibleBody, Frame
from supple.errors import AccuracyError
from supple.reduction.bases.linear_basis import LinearBasisRecipe, rayleigh_ritz
from supple.reduction.derivatives.compression import CompressedDerivatives
from supple.reduction.derivatives.derivative_columns import DerivativeChoice
from supple.reduction.reduction_report import ReductionReport, timed

__all__ = ["ReductionBasis", "reduction_basis"]

LARGEST_FRAME_MOTION = 1e-8


@dataclass(frozen=True, eq=False)
class ReductionBasis(ReadOnlyArrays):
    """Columns V of q = V gamma: V^T M V = I, D V = 0.

    frame : the frame that gamma is relative to; D, (6, n): its constraint
    vectors : (n, r)
    report : ReductionReport     origin of the columns
    """

    frame: Frame
    vectors: np.ndarray
    report: ReductionReport

    @property
    def r(self) -> int:
        """Number of columns."""
        return self.vectors.shape[1]


def reduction_basis(
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice = CompressedDerivatives(10),  # noqa: B008 (it is immutable)
) -> ReductionBasis:
    """The basis that `reduce` projects on: linear columns, then derivatives.

    basis : recipe of the linear columns; SteadyLoads(recipe) for the columns that `reduce` adds by default
    Other arguments as for `reduce`.
    Raises ModelErrors of the recipe and derivatives; AccuracyError when V violates V^T M V = I or D V = 0.
    """
    seconds: dict[str, float] = {}
    with timed(seconds, "linear basis"):
        linear = rayleigh_ritz(body, frame, basis.build(body, frame))
    with timed(seconds, "derivatives"):
        added = derivatives.columns(body, frame, linear)
        V, _, _ = mass_orthonormalize(np.hstack([linear.vectors, added.vectors]), body.mass)
        check_frame_motion(body, frame, V)
    report = ReductionReport(
        linear=linear.labels,
        derivatives=added.labels,
        dropped=linear.dropped + added.dropped,
        singular_values_kept=added.singular_values_kept,
        singular_values_dropped=added.singular_values_dropped,
        seconds=seconds,
        certificate=linear.certificate,
    )
    return ReductionBasis(frame, V, report)


def check_frame_motion(body: FlexibleBody, frame: Frame, V: np.ndarray) -> None:
    """AccuracyError unless D V = 0, each entry relative to the lengths of its row of D and column of V."""
    D = frame.constraint(body)
    lengths = np.linalg.norm(D, axis=1)[:, None] * np.linalg.norm(V, axis=0)
    error = float(np.max(np.abs(D @ V) / lengths, initial=0.0))
    if not error < LARGEST_FRAME_MOTION:
        raise AccuracyError(
            f"the basis of body '{body.name}' moves relative to its frame by {error:.1e} "
            f"(allowed {LARGEST_FRAME_MOTION:.0e})"
        )
