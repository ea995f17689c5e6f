"""Equations of motion of a system of bodies: the terms shared by the methods, and the checks of a run."""

from supple.equations.checks.energy import *
from supple.equations.checks.joint_residuals import *
from supple.equations.checks.load_spectrum import *
from supple.equations.static_search import *
