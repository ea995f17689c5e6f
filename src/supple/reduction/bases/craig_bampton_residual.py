"""Craig-Bampton basis with residual modes: static response of the vibrations outside the basis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, Frame
from supple.reduction.bases.guyan import Guyan, interface_shapes
from supple.reduction.bases.interface_columns import column_labels, motion_rows
from supple.reduction.bases.linear_basis import LinearBasis, ModeCount, static_columns
from supple.reduction.components.deflation import residual_response
from supple.reduction.components.fixed_interface_component import fixed_interface_modes

__all__ = ["CraigBamptonResidual"]


@dataclass(frozen=True)
class CraigBamptonResidual(ModeCount):
    """Constraint modes Psi, residual modes Y, and the lowest vibrations Phi with every interface fixed.

        Y = F_rs A,   F_rs = K_s^-1 - Phi Lambda^-1 Phi^T,   A = M Psi

    K_s is the stiffness with fixed interfaces, and Lambda are the eigenvalues of Phi. A unit acceleration of
    an interface loads the interior by A; Y is the part of the static response that Phi does not contain.
    [Han2020] (26) adds omega^2 Y to the constraint modes, and [KimLee2015] estimate the unknown omega^2.
    Here, the residual modes have their own coordinates, six for each interface. This larger space contains
    the columns of both methods and needs no estimate of omega^2. Give either n_modes or n_columns.

    n_modes : number of fixed-interface modes, besides the constraint and residual modes
    n_columns : number of all columns
    """

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Constraint and residual modes, vibrations; ModelError without interface or for too many modes."""
        static = Guyan().build(body, frame)
        interfaces = body.independent_interfaces
        modes = fixed_interface_modes(body, self.modes_besides(len(static.labels) + 6 * len(interfaces)))
        clamped = body.constrained(motion_rows(interfaces))
        residual = residual_response(clamped, body.mass, modes, body.mass @ interface_shapes(body)).columns
        own = static_columns(residual, column_labels("residual", interfaces), static.static_solver)
        labels = tuple(f"fixed-interface mode {i + 1}" for i in range(modes.values.size))
        vibrations = LinearBasis(modes.vectors, np.sqrt(modes.values), labels, static.static_solver)
        return static.followed_by(own).followed_by(vibrations)
