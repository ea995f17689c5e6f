"""Joints, one per module."""

from supple.machine.joints.ball import (
    Ball,
)
from supple.machine.joints.cylindrical import (
    Cylindrical,
)
from supple.machine.joints.fixed import (
    Fixed,
)
from supple.machine.joints.joint import (
    Joint,
)
from supple.machine.joints.point_on_line import (
    PointOnLine,
)
from supple.machine.joints.prescribed_rotation import (
    PrescribedRotation,
)
from supple.machine.joints.prescribed_translation import (
    PrescribedTranslation,
)
from supple.machine.joints.prismatic import (
    Prismatic,
)
from supple.machine.joints.revolute import (
    Revolute,
)
from supple.machine.joints.universal import (
    Universal,
)

__all__ = [
    "Ball",
    "Cylindrical",
    "Fixed",
    "Joint",
    "PointOnLine",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "Revolute",
    "Universal",
]
