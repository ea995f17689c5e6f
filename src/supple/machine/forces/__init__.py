"""Forces and torques between two markers, one law per module."""

from supple.machine.forces.actuators import *
from supple.machine.forces.bushing import *
from supple.machine.forces.characteristic import *
from supple.machine.forces.force_element import *
from supple.machine.forces.friction import *
from supple.machine.forces.gear import *
from supple.machine.forces.joint_friction import *
from supple.machine.forces.journal_bearing import *
from supple.machine.forces.marker_force import *
from supple.machine.forces.motor_curve import *
from supple.machine.forces.penalty import *
from supple.machine.forces.screw import *
from supple.machine.forces.servo import *
from supple.machine.forces.sphere_contact import *
from supple.machine.forces.spring_damper import *
from supple.machine.forces.stops import *
from supple.machine.forces.tabled_forces import *
from supple.machine.forces.torsion_spring_damper import *
from supple.machine.forces.unbalance import *
