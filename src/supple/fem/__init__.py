"""Finite elements as quadratic-strain arrays: materials, one element per module, mass, assembly, stress."""

from supple.fem.assembly import *
from supple.fem.attached import *
from supple.fem.beam_section import *
from supple.fem.mass import *
from supple.fem.material import *
from supple.fem.model import *
from supple.fem.nodal_rotation import *
from supple.fem.quadratic_strain import *
from supple.fem.section import *
from supple.fem.shear_share import *
from supple.fem.shell_kinematics import *
from supple.fem.shell_section import *
from supple.fem.stress import *
