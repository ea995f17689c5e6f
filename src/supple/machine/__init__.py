"""What a machine is made of, without any equation of motion: bodies placed, joints, forces, laws of time."""

from supple.machine.contacts import Contact, Support, SurfaceContact
from supple.machine.control import Controller, EndReading, JointReading, SampledController
from supple.machine.ends import (
    GROUND,
    At,
    as_end,
)
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
from supple.machine.forces.joint_friction import HingeFriction, JointFriction, SlideFriction
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
from supple.machine.laws import (
    Constant,
    ConstantRate,
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
from supple.machine.obstacles import RigidCylinder, RigidPlane, RigidSphere
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
from supple.machine.ties import Collocated, EveryNode, MeanMotion, Mortar, Tie

__all__ = [
    "GROUND",
    "AngleServo",
    "AngleStop",
    "At",
    "Ball",
    "BaseAcceleration",
    "Bushing",
    "Collocated",
    "Constant",
    "ConstantRate",
    "Contact",
    "Controller",
    "Coulomb",
    "Curve",
    "Cylindrical",
    "DeadForce",
    "DeadTorque",
    "DistanceStop",
    "EndReading",
    "EveryNode",
    "Fixed",
    "FollowerForce",
    "FollowerPressure",
    "FollowerTorque",
    "ForceBetween",
    "ForceElement",
    "Gear",
    "HingeFriction",
    "Joint",
    "JointFriction",
    "JointReading",
    "JournalBearing",
    "MeanMotion",
    "Mortar",
    "MotorCurve",
    "NodalLoad",
    "Penalty",
    "Placed",
    "PointOnLine",
    "Pose",
    "PrescribedRotation",
    "PrescribedTranslation",
    "Prismatic",
    "PrismaticFriction",
    "RackAndPinion",
    "Ramp",
    "Revolute",
    "RevoluteFriction",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "SampledController",
    "Scaled",
    "Screw",
    "Sine",
    "SlideFriction",
    "SlideServo",
    "SlideStop",
    "SphereContact",
    "SphereInCylinder",
    "SphereOnCylinder",
    "SphereOnPlane",
    "Spin",
    "SpinUp",
    "Spline",
    "SplitBody",
    "SpringDamper",
    "Support",
    "Surface",
    "SurfaceContact",
    "System",
    "Table",
    "TabledForce",
    "TabledTorque",
    "Tie",
    "TimeFunction",
    "TimeLaw",
    "TorqueBetween",
    "TorsionSpringDamper",
    "Turning",
    "Unbalance",
    "Universal",
    "Wrench",
    "as_end",
    "split_body",
]
