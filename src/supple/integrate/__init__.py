"""Time integrators and the integration of a run; independent of the kinds of bodies.

`run` is the time loop of all methods. An `Engine` is the part of the integration that differs between
methods.
"""

from supple.integrate.engine import *
from supple.integrate.error_statement import *
from supple.integrate.generalized_alpha import *
from supple.integrate.motion import *
from supple.integrate.other_methods import *
from supple.integrate.run import *
from supple.integrate.run_options import *
from supple.integrate.solution import *
from supple.integrate.step_control import *
