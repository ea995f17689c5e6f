"""Reduction of a flexible body."""

from __future__ import annotations

import warnings
from collections.abc import Callable

from supple.arguments import checked_arguments
from supple.body import Damping, FlexibleBody, Frame
from supple.errors import ValidityWarning
from supple.fem import shear_share
from supple.progress import with_progress_bar
from supple.reduction.bases.linear_basis import LinearBasisRecipe
from supple.reduction.bases.steady_loads import SteadyLoads
from supple.reduction.condensation import CondensedQuartic, QuarticChoice
from supple.reduction.derivatives.compression import CompressedDerivatives
from supple.reduction.derivatives.derivative_columns import DerivativeChoice
from supple.reduction.projection import project
from supple.reduction.reduced_body import ReducedBody
from supple.reduction.reduction_basis import ReductionBasis, reduction_basis

__all__ = ["reduce"]

LARGEST_SHEAR = 0.01
"""Largest ratio of neglected shear energy to strain energy, in the lowest mode, without a warning."""


@checked_arguments
@with_progress_bar("reducing")
def reduce(
    body: FlexibleBody,
    frame: Frame,
    basis: LinearBasisRecipe,
    *,
    loads: Callable[[LinearBasisRecipe], LinearBasisRecipe] = SteadyLoads,
    derivatives: DerivativeChoice = CompressedDerivatives(10),  # noqa: B008 (it is immutable)
    damping: Damping | None = None,
    quartic: QuarticChoice = CondensedQuartic(),  # noqa: B008 (it is immutable)
) -> ReducedBody:
    """Reduce a body to the coordinates of a linear basis enriched with modal derivatives.

        q = V gamma,   V = [X Theta],   V^T M V = I,   D V = 0

    The linear columns come first, in ascending order of frequency (X^T K X = diag(omega^2)), then the
    selected derivatives.

    body : FlexibleBody
    frame : NodalFixedFrame(interface) or MeanAxisFrame()   the frame that gamma is relative to
    basis : Rubin(...), CraigBampton(...), CraigBamptonResidual(...), Herting(...), NormalModes(...), Guyan(),
            CompleteBasis(), ErrorControlled(...), AttachmentModes(recipe) or StaticCorrection(recipe, loads)
    loads : SteadyLoads: adds up to twelve columns, the static responses to the accelerations and rotations of
        the frame; without them the elongation of a rotating bar is three quarters too small. NoLoads: the
        basis alone, as in published work
    derivatives : CompressedDerivatives(n), PickedDerivatives(n) or NoDerivatives()
    damping : RayleighDamping(...), LinearRayleighDamping(...) or ModalDamping(...); None: undamped
    quartic : CondensedQuartic(): motion outside the columns follows them statically, so that the body does
        not lock if the basis contains the static shapes of its interfaces; PlainQuartic(): the columns alone,
        as in published work; the body may lock

    Raises
    ------
    ModelError           too many modes or derivatives; no interface; a linear body with derivatives
    AccuracyError        V^T M V = I or D V = 0 is violated by the basis, or by the Gram matrix of the inertia
    MemoryShortageError  the tensors would exceed the available memory
    Warns LockingWarning when the static response is too small because the columns lack stiff motion;
    ValidityWarning when the walls are rigid in transverse shear, although shear would contribute more than a
    hundredth of the energy of the lowest mode.
    Source: [Wu2019] section 5.
    """
    recipe = basis if isinstance(basis, SteadyLoads) else loads(basis)
    columns = reduction_basis(body, frame, recipe, derivatives=derivatives)
    _warn_of_rigid_shear(body, columns)
    return project(body, columns, damping=damping, quartic=quartic)


def _warn_of_rigid_shear(body: FlexibleBody, columns: ReductionBasis) -> None:
    if body.model is None or not columns.r:
        return
    share = shear_share(body.model, body.expansion @ columns.vectors[:, :1])[0]
    if share > LARGEST_SHEAR:
        warnings.warn(
            f"body '{body.name}': its walls are rigid in transverse shear; shear would have {share:.1%} of "
            f"the energy of the lowest mode and lower its frequency by {share / 2:.1%}; give the walls a "
            "shear factor (5/6 where they are solid)",
            ValidityWarning,
            stacklevel=4,
        )
