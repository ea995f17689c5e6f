"""Laws of time, one kind per module."""

from supple.machine.laws.constant import *
from supple.machine.laws.constant_rate import *
from supple.machine.laws.ramp import *
from supple.machine.laws.scaled import *
from supple.machine.laws.sine import *
from supple.machine.laws.spin_up import *
from supple.machine.laws.spline import *
from supple.machine.laws.table import *
from supple.machine.laws.time_function import *
from supple.machine.laws.time_law import *
from supple.machine.laws.turning import *
