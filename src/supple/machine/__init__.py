"""What a machine is made of, without any equation of motion: bodies placed, joints, forces, laws of time."""

from supple.machine.ends import (
    GROUND,
    At,
    as_end,
)
from supple.machine.forces.force_element import (
    ForceElement,
)
from supple.machine.forces.marker_force import (
    DeadTorque,
    FollowerForce,
    FollowerTorque,
)
from supple.machine.forces.spring_damper import (
    SpringDamper,
)
from supple.machine.forces.torsion_spring_damper import (
    TorsionSpringDamper,
)
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
from supple.machine.laws import (
    Constant,
    Ramp,
    Scaled,
    Sine,
    SpinUp,
    Spline,
    Table,
    TimeFunction,
    TimeLaw,
    Turning,
)
from supple.machine.nodal_loads import (
    BaseAcceleration,
    DeadForce,
    FollowerPressure,
    NodalLoad,
)
from supple.machine.pose import Pose, Wrench
from supple.machine.spin import Spin
from supple.machine.split_body import (
    SplitBody,
    split_body,
)
from supple.machine.system import (
    Placed,
    System,
)

__all__ = [
    "GROUND",
    "At",
    "Ball",
    "BaseAcceleration",
    "Constant",
    "Cylindrical",
    "DeadForce",
    "DeadTorque",
    "Fixed",
    "FollowerForce",
    "FollowerPressure",
    "FollowerTorque",
    "ForceElement",
    "Joint",
    "NodalLoad",
    "Placed",
    "Pose",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "Ramp",
    "Revolute",
    "Scaled",
    "Sine",
    "Spin",
    "SpinUp",
    "Spline",
    "SplitBody",
    "SpringDamper",
    "System",
    "Table",
    "TimeFunction",
    "TimeLaw",
    "TorsionSpringDamper",
    "Turning",
    "Universal",
    "Wrench",
    "as_end",
    "split_body",
]
