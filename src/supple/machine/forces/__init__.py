"""Forces and torques between two markers, one law per module."""

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

__all__ = [
    "DeadTorque",
    "FollowerForce",
    "FollowerTorque",
    "ForceElement",
    "SpringDamper",
    "TorsionSpringDamper",
]
