"""Flexible bodies: a finite-element model with interfaces, a floating frame and its inertia Gram matrix."""

from supple.body.damping import ModalDamping, RayleighDamping, rayleigh_from_ratios
from supple.body.finite_element_body import flexible_body
from supple.body.flexible_body import FlexibleBody
from supple.body.frame import Frame, MeanAxisFrame, NodalFixedFrame, frame_projector
from supple.body.inertia_gram import inertia_gram
from supple.body.interface import AveragingInterface, BodyInterface, RigidInterface
from supple.body.rigid_body import RigidBody
from supple.body.superelement import read_superelement, superelement

__all__ = [
    "AveragingInterface",
    "BodyInterface",
    "FlexibleBody",
    "Frame",
    "MeanAxisFrame",
    "ModalDamping",
    "NodalFixedFrame",
    "RayleighDamping",
    "RigidBody",
    "RigidInterface",
    "flexible_body",
    "frame_projector",
    "inertia_gram",
    "rayleigh_from_ratios",
    "read_superelement",
    "superelement",
]
