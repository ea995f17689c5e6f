"""From a flexible body to a reduced one."""

from __future__ import annotations

from supple.body import Damping, FlexibleBody, Frame
from supple.reduction.bases.linear_basis import LinearBasisRecipe
from supple.reduction.derivatives.compression import CompressedDerivatives
from supple.reduction.derivatives.derivative_columns import DerivativeChoice
from supple.reduction.projection import project
from supple.reduction.reduced_body import ReducedBody
from supple.reduction.reduction_basis import reduction_basis


def reduce(
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    derivatives: DerivativeChoice = CompressedDerivatives(10),  # noqa: B008 (it is immutable)
    damping: Damping | None = None,
) -> ReducedBody:
    """Reduce a body to the coordinates of a linear basis enriched with modal derivatives.

        q = V gamma,   V = [X Theta],   V^T M V = I,   D V = 0

    The linear columns come first, by frequency (X^T K X = diag(omega^2)), then the derivatives chosen.

    body : FlexibleBody
    frame : NodalFixedFrame(interface) or MeanAxisFrame()   the motion gamma is relative to
    basis : Rubin(...), CraigBampton(...), CraigBamptonResidual(...), Herting(...), NormalModes(...), Guyan()
            or CompleteBasis()
    derivatives : CompressedDerivatives(n), PickedDerivatives(n) or NoDerivatives()
    damping : RayleighDamping(...), LinearRayleighDamping(...) or ModalDamping(...); None: undamped
    Raises
    ------
    ModelError      too many modes or derivatives; a basis that needs interfaces; derivatives of a linear body
    AccuracyError   the basis or the Gram matrix misses its own identities
    Source: [Wu2019] section 5.
    """
    return project(body, reduction_basis(body, frame, basis, derivatives=derivatives), damping=damping)
