"""Reduction bases, modal derivatives, their selection, online tensors, and the reduced body."""

from supple.reduction.compression import CompressedDerivatives, compress
from supple.reduction.craig_bampton import CraigBampton
from supple.reduction.derivative_columns import DerivativeChoice, DerivativeColumns, NoDerivatives
from supple.reduction.enrichment import Enrichment, enrich
from supple.reduction.guyan import Guyan, constraint_modes
from supple.reduction.held_modes import HeldModes, held_modes
from supple.reduction.leading_directions import LeadingDirections, leading_directions
from supple.reduction.linear_basis import LinearBasis, LinearBasisRecipe, vibrating_basis
from supple.reduction.modal_derivatives import ModalDerivatives, modal_derivatives
from supple.reduction.normal_modes import CompleteBasis, NormalModes
from supple.reduction.pair_weights import (
    AmplitudeProduct,
    ModalAmplitudes,
    ModalVirtualWork,
    PairCriterion,
    StaticLoad,
    UnitLoad,
)
from supple.reduction.picking import PickedDerivatives, pick
from supple.reduction.projection import project
from supple.reduction.reduce import reduce
from supple.reduction.reduced_body import ReducedBody, ReducedInterface, ReductionReport
from supple.reduction.reduction_basis import ReductionBasis, reduction_basis
from supple.reduction.rubin import Rubin
from supple.reduction.tensors import InternalForceTensors, internal_force_tensors, unpack_symmetric

__all__ = [
    "AmplitudeProduct",
    "CompleteBasis",
    "CompressedDerivatives",
    "CraigBampton",
    "DerivativeChoice",
    "DerivativeColumns",
    "Enrichment",
    "Guyan",
    "HeldModes",
    "InternalForceTensors",
    "LeadingDirections",
    "LinearBasis",
    "LinearBasisRecipe",
    "ModalAmplitudes",
    "ModalDerivatives",
    "ModalVirtualWork",
    "NoDerivatives",
    "NormalModes",
    "PairCriterion",
    "PickedDerivatives",
    "ReducedBody",
    "ReducedInterface",
    "ReductionBasis",
    "ReductionReport",
    "Rubin",
    "StaticLoad",
    "UnitLoad",
    "compress",
    "constraint_modes",
    "enrich",
    "held_modes",
    "internal_force_tensors",
    "leading_directions",
    "modal_derivatives",
    "pick",
    "project",
    "reduce",
    "reduction_basis",
    "unpack_symmetric",
    "vibrating_basis",
]
