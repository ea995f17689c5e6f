"""Reduction bases, modal derivatives, their selection, online tensors, and the reduced body."""

from supple.reduction.bases.attachment_modes import AttachmentModes
from supple.reduction.bases.coupling_moment import CouplingMoment, coupling_moments
from supple.reduction.bases.craig_bampton import CraigBampton
from supple.reduction.bases.craig_bampton_family import CraigBamptonFamily
from supple.reduction.bases.craig_bampton_residual import CraigBamptonResidual
from supple.reduction.bases.dual_craig_bampton import DualCraigBampton
from supple.reduction.bases.effective_interface_mass import (
    EffectiveInterfaceMass,
    effective_interface_masses,
    interior_interface_mass,
)
from supple.reduction.bases.error_controlled import (
    ErrorControlled,
    ErrorControlledModes,
    error_controlled_modes,
)
from supple.reduction.bases.guyan import Guyan, constraint_modes, interface_shapes
from supple.reduction.bases.herting import Herting, inertia_relief_modes
from supple.reduction.bases.linear_basis import LinearBasis, LinearBasisRecipe, rayleigh_ritz
from supple.reduction.bases.macneal import MacNealComponent
from supple.reduction.bases.mode_selection import ChosenModes, LowestFrequency, ModeSelection
from supple.reduction.bases.normal_modes import CompleteBasis, NormalModes
from supple.reduction.bases.rubin import Rubin
from supple.reduction.bases.static_correction import StaticCorrection
from supple.reduction.bases.steady_loads import NoLoads, SteadyLoads
from supple.reduction.clamped_modes import BodyModes, ClampedModes, body_modes, clamped_modes
from supple.reduction.components.component_model import ComponentModel, ReducedMatrices, RitzComponent
from supple.reduction.components.fixed_interface_component import (
    FixedInterfaceComponent,
    craig_bampton_component,
    enhanced_component,
    fixed_interface_component,
    fixed_interface_modes,
    residual_component,
)
from supple.reduction.components.free_interface_component import (
    FreeInterfaceComponent,
    free_interface_component,
    free_interface_modes,
    rubin_component,
)
from supple.reduction.components.free_vibration import FreeVibrations, free_vibrations
from supple.reduction.condensation import Condensation
from supple.reduction.condensed_motion import CondensedMotion
from supple.reduction.derivatives.compression import CompressedDerivatives, compress
from supple.reduction.derivatives.derivative_columns import DerivativeChoice, DerivativeColumns, NoDerivatives
from supple.reduction.derivatives.leading_directions import LeadingDirections, leading_directions
from supple.reduction.derivatives.modal_derivatives import ModalDerivatives, modal_derivatives
from supple.reduction.derivatives.pair_weights import (
    AmplitudeProduct,
    ModalAmplitudes,
    ModalVirtualWork,
    PairCriterion,
    StaticLoad,
    UnitLoad,
)
from supple.reduction.derivatives.picking import PickedDerivatives, pick
from supple.reduction.eigenvalues.eigenvalue_certificate import EigenvalueCertificate
from supple.reduction.eigenvalues.eigenvalue_count import CountedGroup, count_eigenvalues
from supple.reduction.eigenvalues.eigenvalue_enclosure import EigenvalueEnclosure, enclose_eigenvalues
from supple.reduction.eigenvalues.eigenvalue_error import (
    ErrorEstimator,
    ErrorTerms,
    FirstOrderEstimate,
    Han2020Bound,
    KnownEigenvalues,
    SharperBound,
    TwoTermEstimate,
    error_terms,
)
from supple.reduction.eigenvalues.mode_search import Bisection, ModeSearch, OneByOne, SearchStep
from supple.reduction.enrichment import Enrichment, enrich
from supple.reduction.inert_coordinates import filled_up, with_room, with_zeros_behind
from supple.reduction.projection import project
from supple.reduction.quartic_choice import CondensedQuartic, PlainQuartic, QuarticChoice
from supple.reduction.reduce import reduce
from supple.reduction.reduced_body import ReducedBody, ReducedInterface
from supple.reduction.reduction_basis import ReductionBasis, reduction_basis
from supple.reduction.reduction_report import Locking, ReductionReport
from supple.reduction.tensors import InternalForceTensors, internal_force_tensors, unpack_symmetric

__all__ = [
    "AmplitudeProduct",
    "AttachmentModes",
    "Bisection",
    "BodyModes",
    "ChosenModes",
    "ClampedModes",
    "CompleteBasis",
    "ComponentModel",
    "CompressedDerivatives",
    "Condensation",
    "CondensedMotion",
    "CondensedQuartic",
    "CountedGroup",
    "CouplingMoment",
    "CraigBampton",
    "CraigBamptonFamily",
    "CraigBamptonResidual",
    "DerivativeChoice",
    "DerivativeColumns",
    "DualCraigBampton",
    "EffectiveInterfaceMass",
    "EigenvalueCertificate",
    "EigenvalueEnclosure",
    "Enrichment",
    "ErrorControlled",
    "ErrorControlledModes",
    "ErrorEstimator",
    "ErrorTerms",
    "FirstOrderEstimate",
    "FixedInterfaceComponent",
    "FreeInterfaceComponent",
    "FreeVibrations",
    "Guyan",
    "Han2020Bound",
    "Herting",
    "InternalForceTensors",
    "KnownEigenvalues",
    "LeadingDirections",
    "LinearBasis",
    "LinearBasisRecipe",
    "Locking",
    "LowestFrequency",
    "MacNealComponent",
    "ModalAmplitudes",
    "ModalDerivatives",
    "ModalVirtualWork",
    "ModeSearch",
    "ModeSelection",
    "NoDerivatives",
    "NoLoads",
    "NormalModes",
    "OneByOne",
    "PairCriterion",
    "PickedDerivatives",
    "PlainQuartic",
    "QuarticChoice",
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
    "SteadyLoads",
    "TwoTermEstimate",
    "UnitLoad",
    "body_modes",
    "clamped_modes",
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
    "filled_up",
    "fixed_interface_component",
    "fixed_interface_modes",
    "free_interface_component",
    "free_interface_modes",
    "free_vibrations",
    "inertia_relief_modes",
    "interface_shapes",
    "interior_interface_mass",
    "internal_force_tensors",
    "leading_directions",
    "modal_derivatives",
    "pick",
    "project",
    "rayleigh_ritz",
    "reduce",
    "reduction_basis",
    "residual_component",
    "rubin_component",
    "unpack_symmetric",
    "with_room",
    "with_zeros_behind",
]
