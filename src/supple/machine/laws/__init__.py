"""Laws of time, one kind per module."""

from supple.machine.laws.constant import Constant
from supple.machine.laws.constant_rate import ConstantRate
from supple.machine.laws.ramp import Ramp
from supple.machine.laws.scaled import Scaled
from supple.machine.laws.sine import Sine
from supple.machine.laws.spin_up import SpinUp
from supple.machine.laws.spline import Spline
from supple.machine.laws.table import Table
from supple.machine.laws.time_function import TimeFunction
from supple.machine.laws.time_law import TimeLaw
from supple.machine.laws.turning import Turning

__all__ = [
    "Constant",
    "ConstantRate",
    "Ramp",
    "Scaled",
    "Sine",
    "SpinUp",
    "Spline",
    "Table",
    "TimeFunction",
    "TimeLaw",
    "Turning",
]
