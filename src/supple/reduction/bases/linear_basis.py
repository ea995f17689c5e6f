"""A linear reduction basis: columns, their frequencies, and the static problem of their derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from supple.algebra import ConstrainedFactor, mass_orthonormalize, read_only
from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame, frame_projector
from supple.errors import AccuracyError, ModelError
from supple.reduction.eigenvalues.eigenvalue_certificate import EigenvalueCertificate

__all__ = ["LinearBasis", "LinearBasisRecipe", "rayleigh_ritz"]


@dataclass(frozen=True, eq=False)
class LinearBasis:
    """Columns of a linear basis, static columns and modes, with the static problem of their derivatives.

    vectors : (n, m)
    frequencies : (m,)       rad/s; nan for static columns, which have no natural frequency
    labels : (m,) str        such as "constraint tip rz" or "fixed-interface mode 3"
    static_solver : solves K x = f under the constraints of this basis (interfaces or frame fixed); the
                        derivatives of the columns are solutions of this static problem
    dropped : labels of columns left out because the frame or other columns contain their motion
    certificate : proven bounds of the modes' eigenvalues; None without a proof
    """

    vectors: np.ndarray
    frequencies: np.ndarray
    labels: tuple[str, ...]
    static_solver: ConstrainedFactor
    dropped: tuple[str, ...] = ()
    certificate: EigenvalueCertificate | None = None

    def __post_init__(self):
        object.__setattr__(self, "vectors", read_only(self.vectors))
        object.__setattr__(self, "frequencies", read_only(self.frequencies))


class LinearBasisRecipe(Protocol):
    """How to build a linear basis: CraigBampton, CraigBamptonResidual, Rubin, Herting, NormalModes ..."""

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The basis of a body whose motion is measured in a frame."""
        ...


def rayleigh_ritz(body: FlexibleBody, frame: Frame, raw: LinearBasis) -> LinearBasis:
    """Columns that span the motions of `raw` relative to the frame, each with a natural frequency.

        X = P raw Q,   X^T M X = I,   X^T K X = diag(omega^2),   D X = 0

    P is the frame's projector; Q follows from the Rayleigh-Ritz method. Every column, also of a static basis,
    thus has a frequency, which weights its modal derivatives; vibration modes under D q = 0 keep their
    frequencies. Dependent columns are dropped.

    Returns LinearBasis: `labels` are those of the kept raw columns (in the raw order, not in the ascending
        order of the frequencies); `dropped` also has those of the dropped raw columns.
    Raises AccuracyError when a column stores no energy, ModelError when no column is left.
    """
    # Norms before projection, because the projection of a rigid motion leaves only round-off.
    norms = np.sqrt(np.sum(raw.vectors * (body.mass @ raw.vectors), axis=0))
    without_frame = frame_projector(body, frame)
    columns, kept, dropped = mass_orthonormalize(without_frame(raw.vectors), body.mass, reference_norms=norms)
    # Projected again: scaling a column that was nearly a rigid motion amplifies its round-off.
    columns = mass_orthonormalize(without_frame(columns), body.mass).vectors
    if columns.shape[1] == 0:
        raise ModelError(
            f"the linear basis of body '{body.name}' is empty: the frame contains the motion of "
            f"all its {raw.vectors.shape[1]} columns; add modes, or use a basis with free interfaces"
        )
    squares, rotation = np.linalg.eigh(columns.T @ (body.stiffness @ columns))
    if squares[0] <= 0.0:
        raise AccuracyError(
            f"a linear column of body '{body.name}' stores no energy (omega^2 = {squares[0]:.3g} of largest "
            f"{squares[-1]:.3g}): fix the frame to the body, and check that no part of it is a mechanism"
        )
    return LinearBasis(
        vectors=columns @ rotation,
        frequencies=np.sqrt(squares),
        labels=tuple(raw.labels[i] for i in kept),
        static_solver=raw.static_solver,
        dropped=raw.dropped + tuple(raw.labels[i] for i in dropped),
        certificate=raw.certificate,
    )


@dataclass(frozen=True)
class ModeCount:
    """Number of modes in addition to static columns: n_modes, or the number that gives n_columns in total."""

    n_modes: int | None
    n_columns: int | None

    def __post_init__(self):
        check_fields(self)
        if (self.n_modes is None) == (self.n_columns is None):
            raise ModelError("give either n_modes (besides the static columns) or n_columns (in total)")
        if (self.n_modes or 0) < 0 or (self.n_columns or 0) < 0:
            raise ModelError(f"a basis cannot have a negative number of columns: {self}")

    def modes_besides(self, n_static: int) -> int:
        """Number of modes; ModelError when the static columns alone exceed n_columns."""
        if self.n_columns is None:
            return self.n_modes or 0
        if self.n_columns < n_static:
            raise ModelError(
                f"n_columns = {self.n_columns} is too few: "
                f"the interfaces alone need {n_static} static columns"
            )
        return self.n_columns - n_static


def check_mode_count(body: FlexibleBody, n_modes: int, n_fixed: int) -> None:
    """ModelError when n_modes is negative, or more than a body with n_fixed motions fixed has modes."""
    available = body.n - n_fixed
    if not 0 <= n_modes <= available:
        raise ModelError(
            f"n_modes = {n_modes}, but body '{body.name}' has {available} modes "
            f"({body.n} freedoms, {n_fixed} of them fixed)"
        )
