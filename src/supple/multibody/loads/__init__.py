"""Forces and torques on bodies, one law per module."""

from supple.multibody.loads.dead_force import DeadForce
from supple.multibody.loads.force_element import ForceElement
from supple.multibody.loads.marker_force import DeadTorque, FollowerForce, FollowerTorque
from supple.multibody.loads.spring_damper import SpringDamper
from supple.multibody.loads.torsion_spring_damper import TorsionSpringDamper

__all__ = [
    "DeadForce",
    "DeadTorque",
    "FollowerForce",
    "FollowerTorque",
    "ForceElement",
    "SpringDamper",
    "TorsionSpringDamper",
]
