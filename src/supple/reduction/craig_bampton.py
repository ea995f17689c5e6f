"""The Craig-Bampton basis: constraint modes and fixed-interface modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import lowest_modes
from supple.body import FlexibleBody, Frame
from supple.reduction.guyan import constraint_modes
from supple.reduction.interface_columns import motion_rows
from supple.reduction.linear_basis import LinearBasis, ModeCount, check_mode_count


@dataclass(frozen=True)
class CraigBampton:
    """Constraint modes and the lowest vibrations with every interface held.

        K Phi + B^T mu = M Phi diag(omega^2),   B Phi = 0

    n_modes : number of fixed-interface modes, besides the constraint modes; or
    n_columns : number of all columns
    Raises ModelError when both or none are given, or a number is negative.
    Source: [CraigBampton1968]; [Han2020] (11)-(17); NFR-CB of [Wu2019].
    """

    n_modes: int | None = None
    n_columns: int | None = None

    def __post_init__(self):
        ModeCount(self.n_modes, self.n_columns)

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Constraint modes first, then fixed-interface modes; ModelError: no interface, too many modes."""
        static = constraint_modes(body, frame)
        n_modes = ModeCount(self.n_modes, self.n_columns).modes_besides(static.vectors.shape[1])
        held = motion_rows(body.interfaces)
        check_mode_count(body, n_modes, len(held))
        modes = lowest_modes(body.stiffness, body.mass, n_modes, constraint=held)
        return LinearBasis(
            vectors=np.hstack([static.vectors, modes.vectors]),
            frequencies=np.concatenate([static.frequencies, np.sqrt(modes.values)]),
            labels=static.labels + tuple(f"fixed-interface mode {i + 1}" for i in range(n_modes)),
            static_solver=static.static_solver,
            dropped=static.dropped,
        )
