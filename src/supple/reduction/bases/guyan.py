"""Constraint modes, the static basis of Guyan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, Frame
from supple.reduction.bases.interface_columns import (
    column_labels,
    fixed_interfaces,
    motion_rows,
    require_interfaces,
)
from supple.reduction.bases.linear_basis import LinearBasis, static_columns

__all__ = ["Guyan", "constraint_modes", "interface_shapes"]


@dataclass(frozen=True)
class Guyan:
    """Constraint modes: the body follows its interfaces statically. Exact for static interface loads."""

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Constraint modes in a frame; see `constraint_modes`."""
        return constraint_modes(body, frame)


def constraint_modes(body: FlexibleBody, frame: Frame) -> LinearBasis:
    """Static shapes due to a unit motion of one interface freedom, with all other interface freedoms fixed.

        K Psi + B^T mu = 0,   B Psi = (columns of) I

    If B selects the freedoms b, and i are all others, this is Psi_i = -K_ii^-1 K_ib. The reference interface
    is the one to which the frame is fixed, otherwise the first. Its six shapes are left out, because they are
    combinations of the other shapes and rigid motions.

    Returns LinearBasis of 6 (n - 1) columns for n independent interfaces, not yet projected on the
    frame; frequencies nan.
    Raises ModelError if the body has no interface.
    Source: [Guyan1965], [Han2020] (13).
    """
    require_interfaces(body, "a basis of constraint modes")
    reference = (fixed_interfaces(body, frame) or body.interfaces)[0]
    moving = [each for each in body.independent_interfaces if each is not reference]
    clamped = motion_rows([reference, *moving])
    solver = body.constrained(clamped)
    n_moving = 6 * len(moving)
    unit_motions = np.vstack([np.zeros((6, n_moving)), np.eye(n_moving)])
    n = body.n
    vectors = solver.solve(np.zeros((n, n_moving)), unit_motions) if moving else np.empty((n, 0))
    dropped = column_labels("constraint", [each for each in body.interfaces if each not in moving])
    return static_columns(vectors, column_labels("constraint", moving), solver, dropped)


def interface_shapes(body: FlexibleBody) -> np.ndarray:
    """Static shapes (n, 6 p) due to a unit motion of each freedom of the p independent interfaces.

        K Psi + B^T mu = 0,   B Psi = I

    Their span contains the rigid motions. They have the order of `independent_interfaces`.
    Raises ModelError if the body has no interface.
    Source: [Han2020] (13).
    """
    require_interfaces(body, "a set of constraint modes")
    clamped = motion_rows(body.independent_interfaces)
    return body.constrained(clamped).solve(values=np.eye(len(clamped)))
