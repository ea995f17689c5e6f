"""Craig-Bampton basis with residual modes: static response of the vibrations outside the basis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.algebra import Eigenpairs, RitzModes
from supple.body import FlexibleBody, Frame
from supple.reduction.bases.craig_bampton import CraigBampton
from supple.reduction.bases.guyan import Guyan, interface_shapes
from supple.reduction.bases.interface_columns import column_labels, motion_rows
from supple.reduction.bases.linear_basis import LinearBasis, ModeCount
from supple.reduction.components.deflation import residual_response

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
        n_constraint = static.vectors.shape[1]
        n_residual = 6 * len(body.independent_interfaces)
        n_modes = self.modes_besides(n_constraint + n_residual)
        plain = CraigBampton(n_modes=n_modes).build(body, frame)
        constraint, modes = np.split(plain.vectors, [n_constraint], axis=1)
        known = RitzModes.of(Eigenpairs(plain.frequencies[n_constraint:] ** 2, modes))
        clamped = body.constrained(motion_rows(body.independent_interfaces))
        residual = residual_response(clamped, body.mass, known, body.mass @ interface_shapes(body)).columns
        return LinearBasis(
            vectors=np.hstack([constraint, residual, modes]),
            frequencies=np.insert(plain.frequencies, n_constraint, np.full(n_residual, np.nan)),
            labels=plain.labels[:n_constraint]
            + column_labels("residual", body.independent_interfaces)
            + plain.labels[n_constraint:],
            static_solver=plain.static_solver,
            dropped=plain.dropped,
        )
