"""Reduction bases, modal derivatives, their selection, online tensors, and the reduced body."""

from supple.reduction.attachment_modes import AttachmentModes
from supple.reduction.component_model import ComponentModel, ReducedMatrices, RitzComponent
from supple.reduction.compression import CompressedDerivatives, compress
from supple.reduction.coupling_moment import CouplingMoment, coupling_moments
from supple.reduction.craig_bampton import CraigBampton
from supple.reduction.craig_bampton_family import CraigBamptonFamily
from supple.reduction.craig_bampton_residual import CraigBamptonResidual
from supple.reduction.derivative_columns import DerivativeChoice, DerivativeColumns, NoDerivatives
from supple.reduction.dual_craig_bampton import DualCraigBampton
from supple.reduction.effective_interface_mass import (
    EffectiveInterfaceMass,
    effective_interface_masses,
    interior_interface_mass,
)
from supple.reduction.eigenvalue_certificate import EigenvalueCertificate
from supple.reduction.eigenvalue_count import CountedGroup, count_eigenvalues
from supple.reduction.eigenvalue_enclosure import EigenvalueEnclosure, enclose_eigenvalues
from supple.reduction.eigenvalue_error import (
    EarlierEstimate,
    ErrorEstimator,
    ErrorTerms,
    KnownEigenvalues,
    PublishedBound,
    SharperBound,
    TwoTermEstimate,
    error_terms,
)
from supple.reduction.enrichment import Enrichment, enrich
from supple.reduction.error_controlled import ErrorControlled, ErrorControlledModes, error_controlled_modes
from supple.reduction.fixed_interface_component import (
    FixedInterfaceComponent,
    craig_bampton_component,
    enhanced_component,
    fixed_interface_component,
    fixed_interface_modes,
    residual_component,
)
from supple.reduction.free_interface_component import (
    FreeInterfaceComponent,
    free_interface_component,
    free_interface_modes,
    rubin_component,
)
from supple.reduction.free_vibration import FreeVibrations, free_vibrations
from supple.reduction.guyan import Guyan, constraint_modes, interface_shapes
from supple.reduction.held_modes import HeldModes, held_modes
from supple.reduction.herting import Herting, inertia_relief_modes
from supple.reduction.leading_directions import LeadingDirections, leading_directions
from supple.reduction.linear_basis import LinearBasis, LinearBasisRecipe, vibrating_basis
from supple.reduction.macneal import MacNealComponent
from supple.reduction.modal_derivatives import ModalDerivatives, modal_derivatives
from supple.reduction.mode_search import Bisection, ModeSearch, OneByOne, SearchStep
from supple.reduction.mode_selection import ChosenModes, LowestFrequency, ModeSelection
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
from supple.reduction.static_correction import StaticCorrection
from supple.reduction.tensors import InternalForceTensors, internal_force_tensors, unpack_symmetric

__all__ = [
    "AmplitudeProduct",
    "AttachmentModes",
    "Bisection",
    "ChosenModes",
    "CompleteBasis",
    "ComponentModel",
    "CompressedDerivatives",
    "CountedGroup",
    "CouplingMoment",
    "CraigBampton",
    "CraigBamptonFamily",
    "CraigBamptonResidual",
    "DerivativeChoice",
    "DerivativeColumns",
    "DualCraigBampton",
    "EarlierEstimate",
    "EffectiveInterfaceMass",
    "EigenvalueCertificate",
    "EigenvalueEnclosure",
    "Enrichment",
    "ErrorControlled",
    "ErrorControlledModes",
    "ErrorEstimator",
    "ErrorTerms",
    "FixedInterfaceComponent",
    "FreeInterfaceComponent",
    "FreeVibrations",
    "Guyan",
    "HeldModes",
    "Herting",
    "InternalForceTensors",
    "KnownEigenvalues",
    "LeadingDirections",
    "LinearBasis",
    "LinearBasisRecipe",
    "LowestFrequency",
    "MacNealComponent",
    "ModalAmplitudes",
    "ModalDerivatives",
    "ModalVirtualWork",
    "ModeSearch",
    "ModeSelection",
    "NoDerivatives",
    "NormalModes",
    "OneByOne",
    "PairCriterion",
    "PickedDerivatives",
    "PublishedBound",
    "ReducedBody",
    "ReducedInterface",
    "ReducedMatrices",
    "ReductionBasis",
    "ReductionReport",
    "RitzComponent",
    "Rubin",
    "SearchStep",
    "SharperBound",
    "StaticCorrection",
    "StaticLoad",
    "TwoTermEstimate",
    "UnitLoad",
    "compress",
    "constraint_modes",
    "count_eigenvalues",
    "coupling_moments",
    "craig_bampton_component",
    "effective_interface_masses",
    "enclose_eigenvalues",
    "enhanced_component",
    "enrich",
    "error_controlled_modes",
    "error_terms",
    "fixed_interface_component",
    "fixed_interface_modes",
    "free_interface_component",
    "free_interface_modes",
    "free_vibrations",
    "held_modes",
    "inertia_relief_modes",
    "interface_shapes",
    "interior_interface_mass",
    "internal_force_tensors",
    "leading_directions",
    "modal_derivatives",
    "pick",
    "project",
    "reduce",
    "reduction_basis",
    "residual_component",
    "rubin_component",
    "unpack_symmetric",
    "vibrating_basis",
]
