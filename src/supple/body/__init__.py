"""Flexible bodies: a finite-element model with interfaces, a floating frame and its inertia Gram matrix."""

from supple.body.body_form import BodyForm
from supple.body.body_source import (
    BodySource,
    elements_source,
    labelled_matrices_source,
    matrices_source,
    nastran_source,
)
from supple.body.connection_interfaces import check_rigid_connections, connection_interface, connection_named
from supple.body.damping import (
    Damping,
    LinearRayleighDamping,
    ModalDamping,
    RayleighDamping,
    rayleigh_at_modes,
    rayleigh_from_ratios,
)
from supple.body.finite_element_body import flexible_body
from supple.body.flexible_body import FlexibleBody
from supple.body.floating_kinematics import floating_positions, in_space, node_displacements
from supple.body.frame import Frame, MeanAxisFrame, NodalFixedFrame, frame_projector, smaller_rotations
from supple.body.full_body import FullBody
from supple.body.inertia_gram import inertia_gram
from supple.body.interface import (
    AveragingInterface,
    BodyInterface,
    Interface,
    PointInterface,
    RigidInterface,
    place_in_frame,
)
from supple.body.internal_force import LinearForce, QuadraticStrainForce
from supple.body.labelled_superelement import (
    NodalMatrices,
    labelled_superelement,
    nodal_matrices,
    read_labelled_superelement,
    read_nodal_matrices,
)
from supple.body.mass_properties import MassProperties, mesh_mass_properties, rigid_mass_properties
from supple.body.model_check import (
    Finding,
    ModelCheck,
    Verdict,
    check_elements,
    check_model,
    check_nodal_matrices,
)
from supple.body.nastran_body import nastran_model, read_nastran_body
from supple.body.point_motion import InterfaceMotion, NodeMotion
from supple.body.rigid_body import RigidBody
from supple.body.superelement import read_superelement, superelement

__all__ = [
    "AveragingInterface",
    "BodyForm",
    "BodyInterface",
    "BodySource",
    "Damping",
    "Finding",
    "FlexibleBody",
    "Frame",
    "FullBody",
    "Interface",
    "InterfaceMotion",
    "LinearForce",
    "LinearRayleighDamping",
    "MassProperties",
    "MeanAxisFrame",
    "ModalDamping",
    "ModelCheck",
    "NodalFixedFrame",
    "NodalMatrices",
    "NodeMotion",
    "PointInterface",
    "QuadraticStrainForce",
    "RayleighDamping",
    "RigidBody",
    "RigidInterface",
    "Verdict",
    "check_elements",
    "check_model",
    "check_nodal_matrices",
    "check_rigid_connections",
    "connection_interface",
    "connection_named",
    "elements_source",
    "flexible_body",
    "floating_positions",
    "frame_projector",
    "in_space",
    "inertia_gram",
    "labelled_matrices_source",
    "labelled_superelement",
    "matrices_source",
    "mesh_mass_properties",
    "nastran_model",
    "nastran_source",
    "nodal_matrices",
    "node_displacements",
    "place_in_frame",
    "rayleigh_at_modes",
    "rayleigh_from_ratios",
    "read_labelled_superelement",
    "read_nastran_body",
    "read_nodal_matrices",
    "read_superelement",
    "rigid_mass_properties",
    "smaller_rotations",
    "superelement",
]
