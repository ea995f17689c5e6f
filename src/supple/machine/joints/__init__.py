"""Joints, one per module."""

from supple.machine.joints.ball import *
from supple.machine.joints.cylindrical import *
from supple.machine.joints.fixed import *
from supple.machine.joints.joint import *
from supple.machine.joints.point_on_line import *
from supple.machine.joints.prescribed_rotation import *
from supple.machine.joints.prescribed_translation import *
from supple.machine.joints.prismatic import *
from supple.machine.joints.revolute import *
from supple.machine.joints.universal import *
