"""Attachment modes: a basis that also contains the static response to every interface force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame, MeanAxisFrame
from supple.reduction.bases.interface_columns import column_labels, motion_rows, require_interfaces
from supple.reduction.bases.linear_basis import LinearBasis, LinearBasisRecipe

__all__ = ["AttachmentModes"]


@dataclass(frozen=True)
class AttachmentModes:
    """The columns of a recipe, and the inertia-relief attachment modes of every interface.

        K Psi + M R mu = B^T,   R^T M Psi = 0

    Joints load a body by forces at its interfaces. The truncated modes respond to these forces nearly
    statically, and six columns per interface contain that response: the error of truncating a mode then falls
    with the fourth power of the frequency of the mode instead of the second. In every frame, rigid-body
    inertia balances the forces, so that the reduced body does not depend on the frame. In a mean-axis frame,
    AttachmentModes(NormalModes(n)) has the same columns as Rubin(n).

    recipe : ErrorControlled(...), NormalModes(n) or another recipe of modes of the free body
    Source: [Rubin1975]; [Wu2019] (33)-(38).
    """

    recipe: LinearBasisRecipe

    def __post_init__(self) -> None:
        check_fields(self)

    def build(self, body: FlexibleBody, frame: Frame) -> LinearBasis:
        """Attachment modes, then the recipe's columns; ModelError: no interface, or the recipe's errors."""
        require_interfaces(body, "an attachment mode")
        basis = self.recipe.build(body, frame)
        relief = body.constrained(MeanAxisFrame().constraint(body))
        attachment = relief.solve(motion_rows(body.interfaces).T)
        return LinearBasis(
            vectors=np.hstack([attachment, basis.vectors]),
            frequencies=np.concatenate([np.full(attachment.shape[1], np.nan), basis.frequencies]),
            labels=column_labels("attachment", body.interfaces) + basis.labels,
            static_solver=basis.static_solver,
            dropped=basis.dropped,
            # More columns lower Ritz values, never below the exact ones: the certificate remains valid.
            certificate=basis.certificate,
        )
