"""Floating-frame equations of motion, compiled for reduced bodies and sparse for full ones."""

from supple.multibody.checks.energy import *
from supple.multibody.checks.joint_residuals import *
from supple.multibody.checks.load_spectrum import *
from supple.multibody.compiled.engine import *
from supple.multibody.compiled.kinematics import *
from supple.multibody.compiled.statics import *
from supple.multibody.equations.static_search import *
from supple.multibody.full.engine import *
from supple.multibody.full.statics import *
