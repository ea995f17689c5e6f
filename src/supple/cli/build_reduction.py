"""From the reduction table of a body to a basis of fixed size, or the start of one that corrects itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from supple.body import FlexibleBody
from supple.cases import case_tables as schema
from supple.correction import ReductionStart, SelfCorrection
from supple.reduction import (
    AttachmentModes,
    CompressedDerivatives,
    CouplingMoment,
    CraigBampton,
    CraigBamptonResidual,
    EffectiveInterfaceMass,
    ErrorControlled,
    Guyan,
    Herting,
    LinearBasisRecipe,
    LowestFrequency,
    ModeSelection,
    NoDerivatives,
    NormalModes,
    PickedDerivatives,
    Rubin,
    SearchStep,
)

DEFAULT_ACCURACY = 1e-3
"""Largest RMS error of the nodes over the largest displacement."""
FIRST_MODES = 5
FIRST_DERIVATIVES = 5
CANDIDATES_PER_MODE = 5
"""Modes to select among, for each one kept."""


def corrects_itself(table: schema.Body) -> bool:
    """True unless the reduction of an elastic body has a fixed size, or there is none."""
    match table.reduction:
        case None:
            return table.rigid is None and table.reduced is None
        case schema.FullOrder() | schema.ErrorControlled():
            return False
        case schema.Guyan(accuracy=accuracy):  # whose size is that of the interfaces
            return accuracy is not None
        case sized:
            return sized.accuracy is not None or sized.modes is None


def build_start(table: schema.Body, body: FlexibleBody) -> ReductionStart:
    """Where the reduction of a body starts that corrects itself, and where it may stop."""
    reduction = table.reduction
    if reduction is None:
        basis = {"basis": "craig-bampton" if body.interfaces else "normal-modes"}
        reduction = (schema.CraigBampton if body.interfaces else schema.NormalModes).model_validate(basis)
    assert isinstance(reduction, schema.CorrectableOrder)  # the others have no start
    accuracy = reduction.accuracy or schema.Accuracy.model_validate({})
    derivatives = build_derivatives(reduction.derivatives)
    if reduction.derivatives is None and body.model is not None:
        derivatives = CompressedDerivatives(FIRST_DERIVATIVES)
    return ReductionStart(_target(accuracy), build_basis(reduction), derivatives)


def _target(accuracy: schema.Accuracy) -> SelfCorrection:
    relative = DEFAULT_ACCURACY if accuracy.absolute is None else None
    return SelfCorrection(
        absolute=accuracy.absolute,
        relative=accuracy.relative or relative,
        instants=accuracy.instants,
        directions=accuracy.directions,
        largest_size=accuracy.largest_size,
        max_rounds=accuracy.max_rounds,
    )


def build_basis(
    table: schema.ReducedOrder, progress: Callable[[str], None] | None = None
) -> LinearBasisRecipe:
    """The recipe of the linear columns; of those to start with, where no number is given.

    progress : hears in words how far a search for the number of modes has come
    """
    match table:
        case schema.Guyan():
            return Guyan()
        case schema.ErrorControlled():
            return _error_controlled(table, progress)
        case schema.CraigBampton():
            n_modes = _number_of_modes(table)
            return CraigBampton(n_modes, selection=_selection(table, n_modes))
        case _:
            return _BESIDE_STATIC_COLUMNS[table.basis](_number_of_modes(table))


_BESIDE_STATIC_COLUMNS = {
    "rubin": Rubin,
    "craig-bampton-residual": CraigBamptonResidual,
    "herting": Herting,
    "normal-modes": NormalModes,
}


def _number_of_modes(table: schema.CountedOrder) -> int:
    return FIRST_MODES if table.modes is None else table.modes


def _selection(table: schema.CraigBampton, n_modes: int) -> ModeSelection:
    candidates = table.candidates or max(CANDIDATES_PER_MODE * n_modes, 1)
    match table.select:
        case "lowest-frequency":
            return LowestFrequency()
        case "effective-interface-mass":
            return EffectiveInterfaceMass(candidates)
        case "coupling-moment":
            return CouplingMoment(candidates)


def _error_controlled(
    table: schema.ErrorControlled, progress: Callable[[str], None] | None
) -> ErrorControlled | AttachmentModes:
    def tell(step: SearchStep) -> None:
        if progress is not None:
            progress(search_words(step.n_modes, step.largest))

    vibrations = ErrorControlled(table.tolerance, table.modes, progress=tell)
    return AttachmentModes(vibrations) if table.attachment_modes else vibrations


def search_words(n_modes: int, largest_error: float) -> str:
    """So many fixed-interface modes, and the largest error; infinite with too few for all vibrations."""
    error = f"error {100 * largest_error:.2g} %" if np.isfinite(largest_error) else "too few"
    return f"{n_modes} modes, {error}"


def build_derivatives(
    table: schema.Derivatives | None,
) -> CompressedDerivatives | PickedDerivatives | NoDerivatives:
    """The choice of modal derivatives; none unless they are asked for."""
    match table:
        case schema.AllPairsCompressed(number=number):
            return CompressedDerivatives(number)
        case schema.Picked(number=number):
            return PickedDerivatives(number)
        case schema.NoDerivatives() | None:
            return NoDerivatives()
