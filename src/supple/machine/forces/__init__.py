"""Forces and torques between two markers, one law per module."""

from supple.machine.forces.actuators import (
    ForceBetween,
    TorqueBetween,
)
from supple.machine.forces.bushing import (
    Bushing,
)
from supple.machine.forces.characteristic import (
    Curve,
    Surface,
)
from supple.machine.forces.force_element import (
    ForceElement,
)
from supple.machine.forces.friction import (
    Coulomb,
    PrismaticFriction,
    RevoluteFriction,
)
from supple.machine.forces.gear import (
    Gear,
)
from supple.machine.forces.joint_friction import (
    HingeFriction,
    JointFriction,
    SlideFriction,
)
from supple.machine.forces.journal_bearing import (
    JournalBearing,
)
from supple.machine.forces.marker_force import (
    DeadTorque,
    FollowerForce,
    FollowerTorque,
)
from supple.machine.forces.motor_curve import (
    MotorCurve,
)
from supple.machine.forces.penalty import (
    Penalty,
)
from supple.machine.forces.screw import (
    RackAndPinion,
    Screw,
)
from supple.machine.forces.servo import (
    AngleServo,
    SlideServo,
)
from supple.machine.forces.sphere_contact import (
    SphereContact,
    SphereInCylinder,
    SphereOnCylinder,
    SphereOnPlane,
)
from supple.machine.forces.spring_damper import (
    SpringDamper,
)
from supple.machine.forces.stops import (
    AngleStop,
    DistanceStop,
    SlideStop,
)
from supple.machine.forces.tabled_forces import (
    TabledForce,
    TabledTorque,
)
from supple.machine.forces.torsion_spring_damper import (
    TorsionSpringDamper,
)
from supple.machine.forces.unbalance import (
    Unbalance,
)

__all__ = [
    "AngleServo",
    "AngleStop",
    "Bushing",
    "Coulomb",
    "Curve",
    "DeadTorque",
    "DistanceStop",
    "FollowerForce",
    "FollowerTorque",
    "ForceBetween",
    "ForceElement",
    "Gear",
    "HingeFriction",
    "JointFriction",
    "JournalBearing",
    "MotorCurve",
    "Penalty",
    "PrismaticFriction",
    "RackAndPinion",
    "RevoluteFriction",
    "Screw",
    "SlideFriction",
    "SlideServo",
    "SlideStop",
    "SphereContact",
    "SphereInCylinder",
    "SphereOnCylinder",
    "SphereOnPlane",
    "SpringDamper",
    "Surface",
    "TabledForce",
    "TabledTorque",
    "TorqueBetween",
    "TorsionSpringDamper",
    "Unbalance",
]
