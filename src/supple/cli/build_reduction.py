"""From the reduction table of a body to a basis of fixed size, or the start of one that corrects itself."""

from __future__ import annotations

from supple.body import FlexibleBody
from supple.cli import case_schema as schema
from supple.multibody import ReductionStart, SelfCorrection
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    Guyan,
    NoDerivatives,
    NormalModes,
    PickedDerivatives,
    Rubin,
)

DEFAULT_ACCURACY = 1e-3
"""Largest RMS error of the nodes over the largest displacement."""
FIRST_MODES = 5
FIRST_DERIVATIVES = 5


def corrects_itself(table: schema.Body) -> bool:
    """True unless the reduction of an elastic body has a fixed size, or there is none."""
    match table.reduction:
        case None:
            return table.rigid is None and table.reduced is None
        case schema.FullOrder():
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
    assert not isinstance(reduction, schema.FullOrder)  # it has no start
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


def build_basis(table: schema.ReducedOrder) -> Rubin | CraigBampton | NormalModes | Guyan:
    """The recipe of the linear columns; of those to start with, where no number is given."""
    match table:
        case schema.Rubin(modes=modes):
            return Rubin(n_modes=FIRST_MODES if modes is None else modes)
        case schema.CraigBampton(modes=modes):
            return CraigBampton(n_modes=FIRST_MODES if modes is None else modes)
        case schema.NormalModes(modes=modes):
            return NormalModes(FIRST_MODES if modes is None else modes)
        case schema.Guyan():
            return Guyan()


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
