"""Joints, one per module."""

from supple.multibody.joints.ball import Ball
from supple.multibody.joints.cylindrical import Cylindrical
from supple.multibody.joints.fixed import Fixed
from supple.multibody.joints.joint import GROUND, At, Joint, JointFrame
from supple.multibody.joints.prescribed_rotation import PrescribedRotation
from supple.multibody.joints.prescribed_translation import PrescribedTranslation
from supple.multibody.joints.prismatic import Prismatic
from supple.multibody.joints.revolute import Revolute
from supple.multibody.joints.universal import Universal

__all__ = [
    "GROUND",
    "At",
    "Ball",
    "Cylindrical",
    "Fixed",
    "Joint",
    "JointFrame",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "Revolute",
    "Universal",
]
