"""A linear reduction basis: columns, their frequencies, and the solver for their modal derivatives."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from supple.algebra import ConstrainedFactor, ReadOnlyArrays, mass_orthonormalize
from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame, frame_projector
from supple.errors import AccuracyError, ModelError
from supple.reduction.eigenvalues.eigenvalue_certificate import EigenvalueCertificate

__all__ = ["LinearBasis", "LinearBasisRecipe", "rayleigh_ritz"]


@dataclass(frozen=True, eq=False)
class LinearBasis(ReadOnlyArrays):
    """Columns of a linear basis: static columns and modes.

    vectors : (n, m)
    frequencies : (m,)       rad/s; nan for static columns, which have no natural frequency
    labels : (m,) str        such as "constraint tip rz" or "fixed-interface mode 3"
    static_solver : solves K x = f under the constraints of this basis (interfaces or frame fixed), as the
                        modal derivatives of the columns require
    dropped : labels of columns left out because they are zero in the frame, or depend on other columns
    certificate : proven bounds of the eigenvalues of the modes; None without a proof
    """

    vectors: np.ndarray
    frequencies: np.ndarray
    labels: tuple[str, ...]
    static_solver: ConstrainedFactor
    dropped: tuple[str, ...] = ()
    certificate: EigenvalueCertificate | None = None

    def followed_by(self, other: LinearBasis) -> LinearBasis:
        """The columns of both, with the static solver of this basis.

        More columns lower the eigenvalues, but not below the exact ones: a stated error bound remains valid.
        """
        return replace(
            self,
            vectors=np.hstack([self.vectors, other.vectors]),
            frequencies=np.concatenate([self.frequencies, other.frequencies]),
            labels=self.labels + other.labels,
            dropped=self.dropped + other.dropped,
            certificate=self.certificate or other.certificate,
        )


def static_columns(
    vectors: np.ndarray, labels: tuple[str, ...], solver: ConstrainedFactor, dropped: tuple[str, ...] = ()
) -> LinearBasis:
    """A basis of static columns, which have no natural frequency."""
    return LinearBasis(vectors, np.full(vectors.shape[1], np.nan), labels, solver, dropped)


class LinearBasisRecipe(Protocol):
    """A rule that builds a linear basis: CraigBampton, Rubin, Herting, NormalModes, ErrorControlled ..."""

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """The basis of a body whose motion is relative to a frame."""
        ...


def rayleigh_ritz(body: FlexibleBody, frame: Frame, raw: LinearBasis) -> LinearBasis:
    """Columns X that span the motions of `raw` relative to the frame, each with a natural frequency.

        X = P raw Q,   X^T M X = I,   X^T K X = diag(omega^2),   D X = 0

    P is the projector of the frame; Q follows from the Rayleigh-Ritz method. Each column has a frequency
    omega, also in a basis of static columns; it weights the modal derivatives. Vibration modes under D q = 0
    keep their frequencies. Columns that depend on others are dropped.

    Returns LinearBasis: vectors and frequencies in ascending order of frequency. `labels` are the labels of
        the kept columns of `raw`, in the order of `raw`: label i does not belong to vector i. `dropped` also
        contains the labels of the dropped columns of `raw`.
    Raises AccuracyError if a column stores no energy, ModelError if no column is left.
    """
    # Norms before projection, because the projection of a rigid motion leaves only round-off.
    norms = np.sqrt(np.sum(raw.vectors * (body.mass @ raw.vectors), axis=0))
    without_frame = frame_projector(body, frame)
    columns, kept, dropped = mass_orthonormalize(without_frame(raw.vectors), body.mass, reference_norms=norms)
    # Projected again: scaling a column that was nearly a rigid motion amplifies its round-off.
    columns = mass_orthonormalize(without_frame(columns), body.mass).vectors
    if columns.shape[1] == 0:
        raise ModelError(
            f"the linear basis of body '{body.name}' is empty: its {raw.vectors.shape[1]} columns are zero "
            "relative to the frame; add modes, or use a basis with free interfaces"
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
    """Base of recipes of static columns and modes: n_modes modes, or as many as give n_columns in total.

    Raises ModelError if both or none of n_modes and n_columns are given, or a number is negative.
    """

    n_modes: int | None = None
    n_columns: int | None = None

    def __post_init__(self):
        check_fields(self)
        if (self.n_modes is None) == (self.n_columns is None):
            raise ModelError("give either n_modes (besides the static columns) or n_columns (in total)")
        if (self.n_modes or 0) < 0 or (self.n_columns or 0) < 0:
            raise ModelError(f"a basis cannot have a negative number of columns: {self}")

    def modes_besides(self, n_static: int) -> int:
        """Number of modes besides n_static static columns; ModelError if these exceed n_columns."""
        if self.n_columns is None:
            return self.n_modes or 0
        if self.n_columns < n_static:
            raise ModelError(
                f"n_columns = {self.n_columns} is too few: "
                f"the interfaces alone need {n_static} static columns"
            )
        return self.n_columns - n_static


def check_mode_count(body: FlexibleBody, n_modes: int, n_fixed: int) -> None:
    """Raise ModelError if n_modes is negative, or above the number of modes.

    n_fixed : number of fixed motions; the body has n - n_fixed modes
    """
    available = body.n - n_fixed
    if not 0 <= n_modes <= available:
        raise ModelError(
            f"n_modes = {n_modes}, but body '{body.name}' has {available} modes "
            f"({body.n} freedoms, {n_fixed} of them fixed); keep at most {available}"
            + ("" if available else ', or use the basis "guyan", which has static columns alone')
        )
