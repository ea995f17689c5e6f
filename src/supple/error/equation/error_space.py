"""The space in which the error of a reduced run is sought: some hundred columns beside those of the run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.algebra import read_only
from supple.body import FlexibleBody, Frame, frame_projector

__all__ = ["ErrorSpace", "ModesInFrame", "error_space", "modes_in_frame", "small_space"]

Array = NDArray[np.float64]

N_MODES = 40
N_CORRECTIONS = 30
N_COUPLINGS = 30
N_COMBINATIONS = 48
"""Of all couplings, at random: their answers have the leading directions of all, for fewer solutions."""
SMALLEST_REMAINDER = 1e-6
"""Of the largest column of a block: what is left of it outside the others and smaller is round-off."""

HALF = 0.5
"""Of the unit length of a remainder that was scaled up: shorter ones outside the others are round-off."""


@dataclass(frozen=True, eq=False)
class ErrorSpace:
    """Columns Z of a body's error, M-orthonormal, D Z = 0; those of the run's own motion lead.

    vectors : (n, k)
    n_motion : int      number of columns in which the run moves
    """

    vectors: Array
    n_motion: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "vectors", read_only(self.vectors))

    @property
    def size(self) -> int:
        """Number of columns."""
        return self.vectors.shape[1]


@dataclass(frozen=True, eq=False)
class ModesInFrame:
    """The lowest modes of a body seen from its frame, (n, m), and the frame's projector."""

    body: FlexibleBody
    frame: Frame
    vectors: Array


def modes_in_frame(body: FlexibleBody, frame: Frame, number: int = N_MODES) -> ModesInFrame:
    """The lowest modes of the undeformed body on D q = 0; all of them where there are fewer."""
    constraint = frame.constraint(body)
    number = min(number, body.n - len(constraint))
    found = body.lowest_modes(number, constraint)
    return ModesInFrame(body, frame, found.vectors)


def error_space(modes: ModesInFrame, motion: Array, corrections: Array, deformed: Array) -> ErrorSpace:
    """Z = orth_M [ V | modes | corrections | couplings ], on D q = 0.

    The modes vibrate, the corrections are what the run's residual asks for at rest, and the couplings
    are the static answer to what the deformed body's tangent makes of the modes,

        - K^+ (K_t(q_i) - K) Phi

    which stiff motion, such as that of a shell's membrane, follows at once.

    Parameters
    ----------
    modes : ModesInFrame
    motion : (n, s)         columns in which the run moves, M-orthonormal
    corrections : (n, c)    motion outside the basis, at some instants
    deformed : (n, i)       coordinates of the body at some instants of the run

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


def small_space(modes: ModesInFrame, motion: Array, fields: Array, number: int) -> ErrorSpace:
    """Z = orth_M [ V | fields | modes ], on D q = 0, of `number` columns besides V.

    motion : (n, s) V;  fields : (n, m), whose leading directions are half of these at most
    """
    space = _Growing(modes.body, modes.frame, motion)
    space.add(fields, number // 2)
    space.add(modes.vectors[:, : number - (space.columns.shape[1] - motion.shape[1])])
    return ErrorSpace(space.columns, motion.shape[1])


def _couplings(modes: ModesInFrame, deformed: Array) -> Array:
    body, shapes = modes.body, modes.vectors
    at_rest = body.stiffness @ shapes
    pushes = np.hstack([body.assembly.tangent(q) @ shapes - at_rest for q in deformed.T])
    if pushes.shape[1] > N_COMBINATIONS:
        size = pushes.shape[1], N_COMBINATIONS
        pushes = pushes @ (np.random.default_rng(0).standard_normal(size) / np.sqrt(N_COMBINATIONS))
    return -body.constrained(modes.frame.constraint(body)).solve(pushes)


class _Growing:
    """M-orthonormal columns on D q = 0, block after block."""

    def __init__(self, body: FlexibleBody, frame: Frame, first: Array) -> None:
        self._mass = body.mass
        self._seen = frame_projector(body, frame)
        self.columns = np.asarray(first)

    def add(self, fields: Array, most: int | None = None) -> None:
        """Append the leading directions of what the columns leave of some fields, at most so many."""
        if not fields.size:
            return
        size = _lengths(fields, self._mass)[1][-1]
        left = self._outside(self._outside(fields))
        directions, lengths = _lengths(left, self._mass)
        kept = np.flatnonzero(lengths > SMALLEST_REMAINDER * size)[::-1][:most]
        if not kept.size:
            return
        # Once more after scaling: round-off that has grown with a small remainder would move the frame.
        new = self._outside(self._seen(left @ (directions[:, kept] / lengths[kept])))
        weights, lengths = _lengths(new, self._mass)
        whole = lengths > HALF  # the others lie within the columns: where these are nearly all there is
        self.columns = np.hstack([self.columns, new @ (weights[:, whole] / lengths[whole])])

    def _outside(self, fields: Array) -> Array:
        return fields - self.columns @ (self.columns.T @ (self._mass @ fields))


def _lengths(fields: Array, mass: Any) -> tuple[Array, Array]:
    """Weights (m, m) of the principal directions of fields (n, m) in the M-norm, and their lengths (m,)."""
    gram = fields.T @ (mass @ fields)
    squares, weights = np.linalg.eigh((gram + gram.T) / 2)
    return weights, np.sqrt(np.maximum(squares, 0.0))
