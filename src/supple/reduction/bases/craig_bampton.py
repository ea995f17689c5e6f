"""The Craig-Bampton basis: constraint modes and fixed-interface modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, Frame
from supple.reduction.bases.guyan import constraint_modes
from supple.reduction.bases.linear_basis import LinearBasis, ModeCount
from supple.reduction.bases.mode_selection import LowestFrequency, ModeSelection

__all__ = ["CraigBampton"]


@dataclass(frozen=True)
class CraigBampton(ModeCount):
    """Constraint modes, and fixed-interface modes Phi of lowest frequency or chosen by another rule.

        K Phi + B^T mu = M Phi diag(omega^2),   B Phi = 0

    B Phi is the motion of the interfaces. Give either n_modes or n_columns.

    n_modes : number of fixed-interface modes, besides the constraint modes
    n_columns : number of all columns
    selection : rule that chooses the fixed-interface modes: LowestFrequency(),
        EffectiveInterfaceMass(candidates) or CouplingMoment(candidates)
    Source: [CraigBampton1968]; [Han2020] (11)-(17); NFR-CB of [Wu2019].
    """

    selection: ModeSelection = LowestFrequency()  # noqa: RUF009 (it is immutable)

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Constraint modes, then fixed-interface modes; ModelError: no interface, or too many modes."""
        static = constraint_modes(body, frame)
        n_modes = self.modes_besides(static.vectors.shape[1])
        modes = self.selection.choose(body, n_modes)
        labels = tuple(f"fixed-interface mode {i}" for i in modes.numbers)
        return static.followed_by(
            LinearBasis(modes.vectors, np.sqrt(modes.values), labels, static.static_solver)
        )
