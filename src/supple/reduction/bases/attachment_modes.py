"""Attachment modes: a basis with the static response to every interface force and moment."""

from __future__ import annotations

from dataclasses import dataclass

from supple.arguments import check_fields
from supple.body import FlexibleBody, Frame, MeanAxisFrame
from supple.reduction.bases.interface_columns import column_labels, motion_rows, require_interfaces
from supple.reduction.bases.linear_basis import LinearBasis, LinearBasisRecipe, static_columns

__all__ = ["AttachmentModes"]


@dataclass(frozen=True)
class AttachmentModes:
    """The basis of `recipe`, and attachment modes Psi with inertia relief for every interface.

        K Psi + M R mu = B^T,   R^T M Psi = 0

    B^T are unit forces and moments at the interfaces, six per interface; the inertia M R mu of a rigid
    acceleration balances them, in every frame, so that the reduced body does not depend on the frame. R are
    the rigid modes. Joints load a body by forces at its interfaces, and modes outside the basis respond to
    them nearly statically. Psi contains this static response. The error due to a mode outside the basis then
    falls with the fourth power of the frequency of this mode, instead of the second. In a mean-axis frame,
    AttachmentModes(NormalModes(n)) has the same columns as Rubin(n).

    recipe : ErrorControlled(...), NormalModes(n) or another basis of modes of the free body
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
        labels = column_labels("attachment", body.interfaces)
        return static_columns(attachment, labels, basis.static_solver).followed_by(basis)
