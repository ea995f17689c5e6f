"""Flexible bodies: finite-element models with interfaces and floating frames, and their inertia."""

from supple.body.body_form import *
from supple.body.body_source import *
from supple.body.damping import *
from supple.body.deck_body import *
from supple.body.deck_modes import *
from supple.body.deck_parts import *
from supple.body.flexible_body import *
from supple.body.floating_kinematics import *
from supple.body.frame import *
from supple.body.full_body import *
from supple.body.inertia_gram import *
from supple.body.interface import *
from supple.body.internal_force import *
from supple.body.labelled_superelement import *
from supple.body.mass_properties import *
from supple.body.model_check import *
from supple.body.point_motion import *
from supple.body.recovery import *
from supple.body.rigid_body import *
from supple.body.section_beams import *
from supple.body.superelement import *

# isort: split
# Last, because the function `flexible_body` has the name of a module above.
from supple.body.finite_element_body import *
