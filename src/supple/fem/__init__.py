"""Finite elements as quadratic-strain arrays: materials, one element per module, mass, assembly, stress.

The strains of all elements are quadratic in the nodal freedoms. So energy, force, tangent and their
derivatives have one implementation (`quadratic_strain`); an element defines only its strain arrays.
"""

from supple.fem.assembly import *
from supple.fem.attached import *
from supple.fem.beam_section import *
from supple.fem.mass import *
from supple.fem.material import *
from supple.fem.model import *
from supple.fem.quadratic_strain import *
from supple.fem.section import *
from supple.fem.shear_share import *
from supple.fem.shell_kinematics import *
from supple.fem.shell_section import *
from supple.fem.stress import *
