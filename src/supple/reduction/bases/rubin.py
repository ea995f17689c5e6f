"""The Rubin basis: attachment modes and free-interface modes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.body import FlexibleBody, Frame
from supple.reduction.bases.interface_columns import (
    column_labels,
    fixed_interfaces,
    motion_rows,
    require_interfaces,
)
from supple.reduction.bases.linear_basis import LinearBasis, ModeCount, static_columns
from supple.reduction.bases.normal_modes import NormalModes

__all__ = ["Rubin"]


@dataclass(frozen=True)
class Rubin(ModeCount):
    """Attachment modes Psi, and the lowest vibrations Phi of the body constrained by its frame alone.

        K Psi + D^T mu = B^T,   D Psi = 0
        K Phi + D^T mu = M Phi diag(omega^2),   D Phi = 0

    D q = 0 are the conditions of the frame. Psi are the static responses to a unit force or moment at each
    interface freedom, B^T. In a mean-axis frame (D = R^T M), the multipliers mu are inertia forces (inertia
    relief). An interface to which the frame is fixed has no attachment mode, because the frame supports a
    load there. Give either n_modes or n_columns.

    n_modes : number of vibrations, besides the attachment modes
    n_columns : number of all columns
    Source: [Wu2019] (33)-(38); [Rubin1975].
    """

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Attachment modes, then vibrations; ModelError without interface or for too many modes."""
        require_interfaces(body, "a Rubin basis")
        fixed = fixed_interfaces(body, frame)
        loaded = [interface for interface in body.independent_interfaces if interface not in fixed]
        modes = NormalModes(self.modes_besides(6 * len(loaded))).build(body, frame)
        attachment = np.empty((body.n, 0))
        if loaded:
            attachment = modes.static_solver.solve(motion_rows(loaded).T)
        dropped = column_labels("attachment", [each for each in body.interfaces if each not in loaded])
        labels = column_labels("attachment", loaded)
        return static_columns(attachment, labels, modes.static_solver, dropped).followed_by(
            replace(modes, labels=tuple(f"free-interface {label}" for label in modes.labels))
        )
