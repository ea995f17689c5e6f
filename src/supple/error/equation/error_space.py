"""Error space of a body: about a hundred columns besides those of the run's motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.body import FlexibleBody, Frame, frame_projector

__all__ = ["ErrorSpace", "ModesInFrame", "error_space", "modes_in_frame", "small_space"]


N_MODES = 40
N_CORRECTIONS = 30
N_COUPLINGS = 30
N_COMBINATIONS = 48
"""Number of random combinations of the couplings: their static responses contain the leading directions."""
SMALLEST_REMAINDER = 1e-6
"""Ratio to the largest column of a block below which a remainder outside the other columns is round-off."""

HALF = 0.5
"""Remainders are scaled to unit length and projected again: one shorter than this is round-off."""


@dataclass(frozen=True, eq=False)
class ErrorSpace:
    """Columns Z of a body's error, M-orthonormal, D Z = 0; the first ones are those of the run's own motion.

    vectors : (n, k)
    n_motion : int      number of columns in which the run moves
    """

    vectors: FloatArray
    n_motion: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "vectors", read_only(self.vectors))

    @property
    def size(self) -> int:
        """Number of columns."""
        return self.vectors.shape[1]


@dataclass(frozen=True, eq=False)
class ModesInFrame:
    """The lowest modes of a body relative to its frame, (n, m), and the frame's projector."""

    body: FlexibleBody
    frame: Frame
    vectors: FloatArray


def modes_in_frame(body: FlexibleBody, frame: Frame, number: int = N_MODES) -> ModesInFrame:
    """The lowest modes of the undeformed body with D q = 0; all modes where there are fewer."""
    constraint = frame.constraint(body)
    number = min(number, body.n - len(constraint))
    found = body.lowest_modes(number, constraint)
    return ModesInFrame(body, frame, found.vectors)


def error_space(
    modes: ModesInFrame, motion: FloatArray, corrections: FloatArray, deformed: FloatArray
) -> ErrorSpace:
    """Z = orth_M [ V | modes | corrections | couplings ], on D q = 0.

    The modes represent vibrations, the corrections balance the run's residual at rest, and the couplings are
    the static response to the change of the tangent of the deformed body along the modes,

        - K^+ (K_t(q_i) - K) Phi

    Stiff motion, for example that of a shell's membrane, follows this change without delay.

    Parameters
    ----------
    modes : ModesInFrame
    motion : (n, s)         columns in which the run moves, M-orthonormal
    corrections : (n, c)    motion outside the basis, at some times
    deformed : (n, i)       coordinates of the body at some times of the run

    Returns
    -------
    ErrorSpace      of at most s + 40 + 30 + 30 columns
    """
    body = modes.body
    space = _Growing(body, modes.frame, motion)
    space.add(modes.vectors)
    space.add(corrections, N_CORRECTIONS)
    if not body.is_linear and deformed.size:
        space.add(_couplings(modes, deformed), N_COUPLINGS)
    return ErrorSpace(space.columns, motion.shape[1])


def small_space(modes: ModesInFrame, motion: FloatArray, fields: FloatArray, number: int) -> ErrorSpace:
    """Z = orth_M [ V | fields | modes ], on D q = 0, with `number` columns besides V.

    motion : (n, s) V;  fields : (n, m), whose leading directions are at most half of these columns
    """
    space = _Growing(modes.body, modes.frame, motion)
    space.add(fields, number // 2)
    space.add(modes.vectors[:, : number - (space.columns.shape[1] - motion.shape[1])])
    return ErrorSpace(space.columns, motion.shape[1])


def _couplings(modes: ModesInFrame, deformed: FloatArray) -> FloatArray:
    body, shapes = modes.body, modes.vectors
    at_rest = body.stiffness @ shapes
    pushes = np.hstack([body.assembly.tangent(q) @ shapes - at_rest for q in deformed.T])
    if pushes.shape[1] > N_COMBINATIONS:
        size = pushes.shape[1], N_COMBINATIONS
        pushes = pushes @ (np.random.default_rng(0).standard_normal(size) / np.sqrt(N_COMBINATIONS))
    return -body.constrained(modes.frame.constraint(body)).solve(pushes)


class _Growing:
    """M-orthonormal columns with D q = 0, extended block by block."""

    def __init__(self, body: FlexibleBody, frame: Frame, first: FloatArray) -> None:
        self._mass = body.mass
        self._seen = frame_projector(body, frame)
        self.columns = np.asarray(first)

    def add(self, fields: FloatArray, most: int | None = None) -> None:
        """Append the leading directions of fields outside the columns, at most `most` of them."""
        if not fields.size:
            return
        size = _lengths(fields, self._mass)[1][-1]
        left = self._outside(self._outside(fields))
        directions, lengths = _lengths(left, self._mass)
        kept = np.flatnonzero(lengths > SMALLEST_REMAINDER * size)[::-1][:most]
        if not kept.size:
            return
        # Orthogonalise again after scaling: round-off amplified with a small remainder would move the frame.
        new = self._outside(self._seen(left @ (directions[:, kept] / lengths[kept])))
        weights, lengths = _lengths(new, self._mass)
        whole = lengths > HALF  # the others lie within the columns, which are then nearly complete
        self.columns = np.hstack([self.columns, new @ (weights[:, whole] / lengths[whole])])

    def _outside(self, fields: FloatArray) -> FloatArray:
        return fields - self.columns @ (self.columns.T @ (self._mass @ fields))


def _lengths(fields: FloatArray, mass: csc_array) -> tuple[FloatArray, FloatArray]:
    """Weights (m, m) of the principal directions of fields (n, m) in the M-norm, and their lengths (m,)."""
    gram = fields.T @ (mass @ fields)
    squares, weights = np.linalg.eigh((gram + gram.T) / 2)
    return weights, np.sqrt(np.maximum(squares, 0.0))
