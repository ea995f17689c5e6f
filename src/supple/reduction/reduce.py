"""From a flexible body to a reduced one."""

from __future__ import annotations

from collections.abc import Callable

from supple.arguments import checked_arguments
from supple.body import Damping, FlexibleBody, Frame
from supple.reduction.bases.linear_basis import LinearBasisRecipe
from supple.reduction.bases.steady_loads import SteadyLoads
from supple.reduction.derivatives.compression import CompressedDerivatives
from supple.reduction.derivatives.derivative_columns import DerivativeChoice
from supple.reduction.projection import project
from supple.reduction.quartic_choice import CondensedQuartic, QuarticChoice
from supple.reduction.reduced_body import ReducedBody
from supple.reduction.reduction_basis import reduction_basis

__all__ = ["reduce"]


@checked_arguments
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

    The linear columns come first, by frequency (X^T K X = diag(omega^2)), then the derivatives chosen.

    body : FlexibleBody
    frame : NodalFixedFrame(interface) or MeanAxisFrame()   the motion gamma is relative to
    basis : Rubin(...), CraigBampton(...), CraigBamptonResidual(...), Herting(...), NormalModes(...), Guyan()
            or CompleteBasis()
    loads : SteadyLoads: the static answers to the accelerations and spins that the frame can have are columns
        too, up to twelve, without which a bar that spins is off by three quarters of its stretch; NoLoads:
        the basis alone, as in published work
    derivatives : CompressedDerivatives(n), PickedDerivatives(n) or NoDerivatives()
    damping : RayleighDamping(...), LinearRayleighDamping(...) or ModalDamping(...); None: undamped
    quartic : CondensedQuartic(): stiff motion that the columns lack follows them, so that they do not lock;
        PlainQuartic(): they do, as in published work
    Raises
    ------
    ModelError      too many modes or derivatives; a basis that needs interfaces; derivatives of a linear body
    AccuracyError   the basis or the Gram matrix misses its own identities
    Warns LockingWarning when the body answers too little because its columns lack stiff motion.
    Source: [Wu2019] section 5.
    """
    recipe = basis if isinstance(basis, SteadyLoads) else loads(basis)
    columns = reduction_basis(body, frame, recipe, derivatives=derivatives)
    return project(body, columns, damping=damping, quartic=quartic)
