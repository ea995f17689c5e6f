"""The Herting basis: constraint modes, inertia relief modes and free-interface modes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from supple.body import FlexibleBody, Frame, MeanAxisFrame
from supple.body.checks import FREEDOM_NAMES
from supple.reduction.bases.guyan import Guyan
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple.reduction.bases.linear_basis import LinearBasis, ModeCount, static_columns
from supple.reduction.bases.normal_modes import NormalModes

__all__ = ["Herting", "inertia_relief_modes"]


@dataclass(frozen=True)
class Herting(ModeCount):
    """Static shapes due to interface motion and to rigid acceleration, and the lowest free vibrations.

        K Psi + B^T mu = 0,        B Psi = (columns of) I       constraint modes
        K Upsilon + B^T mu = M R,  B Upsilon = 0                inertia relief modes
        K Phi = M Phi diag(omega^2),  Phi^T M R = 0             free-interface modes

    R are the rigid modes. The static response to interface motions is exact, as in Craig-Bampton, and the
    modes of the free body are exact, as in Rubin. [Herting1985] uses Phi - Psi B Phi in place of Phi, so that
    the interface motions are coordinates; the span of all columns is the same. Psi, Upsilon and the rigid
    motions span the static responses to all balanced loads of interface forces and rigid inertia. In a
    mean-axis frame, Rubin's attachment modes and the rigid motions span the same space, so that Herting and
    Rubin give the same reduced body. Give either n_modes or n_columns.

    n_modes : number of free-interface modes, besides the static columns
    n_columns : number of all columns
    Source: [Herting1985].
    """

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Constraint, inertia relief and free modes; ModelError without interface, or for too many modes."""
        constraint = Guyan().build(body, frame)
        solver = body.constrained(frame.constraint(body))
        labels = tuple(f"inertia relief {motion}" for motion in FREEDOM_NAMES)
        relief = static_columns(inertia_relief_modes(body), labels, solver)
        static = replace(constraint, static_solver=solver).followed_by(relief)
        modes = NormalModes(self.modes_besides(len(static.labels))).build(body, MeanAxisFrame())
        labels = tuple(f"free-interface {label}" for label in modes.labels)
        return static.followed_by(replace(modes, labels=labels))


def inertia_relief_modes(body: FlexibleBody) -> np.ndarray:
    """Static shapes (n, 6) under the inertia of the six rigid accelerations, with every interface fixed.

        K Upsilon + B^T mu = M R,   B Upsilon = 0

    Raises ModelError if the body has no interface.
    """
    require_interfaces(body, "an inertia relief mode")
    clamped = body.constrained(motion_rows(body.independent_interfaces))
    return clamped.solve(body.mass @ body.rigid_modes)
