"""Truncated normal modes: the lowest vibrations of the body in its frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, Frame
from supple.reduction.bases.linear_basis import LinearBasis, check_mode_count

__all__ = ["CompleteBasis", "NormalModes"]


@dataclass(frozen=True)
class NormalModes:
    """The n_modes lowest vibration modes Phi, constrained by the frame alone.

        K Phi + D^T mu = M Phi diag(omega^2),   D Phi = 0

    In a mean-axis frame (D = R^T M) these are the elastic modes of the free body.
    """

    n_modes: int

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Modes in ascending order of frequency; ModelError if the body has fewer than n_modes."""
        constraint = frame.constraint(body)
        check_mode_count(body, self.n_modes, len(constraint))
        modes = body.lowest_modes(self.n_modes, constraint)
        return LinearBasis(
            vectors=modes.vectors,
            frequencies=np.sqrt(modes.values),
            labels=tuple(f"mode {i + 1}" for i in range(self.n_modes)),
            static_solver=body.constrained(constraint),
        )


@dataclass(frozen=True)
class CompleteBasis:
    """All modes: the reduced body is the full body in other coordinates. For small bodies and tests."""

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """All n - 6 modes of the body in its frame."""
        return NormalModes(body.n - len(frame.constraint(body))).build(body, frame)
