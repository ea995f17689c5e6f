"""Intrinsic modal reduction: slender bodies with arbitrary rotations, from a linear model alone.

A line is a slender body condensed on stations along its load paths. A segment is the part of a line between a
station and its parent, which is nearer the root. The modes of a line belong to the support of its root; a
`released` body has a free root. `IntrinsicEngine` integrates machines whose lines are free or have their
roots on the ground, `JoinedEngine` machines in which joints connect lines to each other and to other bodies.
"""

from supple.methods.intrinsic.condensation_error import *
from supple.methods.intrinsic.condense import *
from supple.methods.intrinsic.condensed_line import *
from supple.methods.intrinsic.engine import *
from supple.methods.intrinsic.enough_modes import *
from supple.methods.intrinsic.imported_line import *
from supple.methods.intrinsic.intrinsic_body import *
from supple.methods.intrinsic.intrinsic_modes import *
from supple.methods.intrinsic.intrinsic_motion import *
from supple.methods.intrinsic.line_balances import *
from supple.methods.intrinsic.load_path import *
from supple.methods.intrinsic.load_path_tree import *
from supple.methods.intrinsic.released import *
from supple.methods.intrinsic.root_support import *
from supple.methods.intrinsic.section_line import *
from supple.methods.intrinsic.stable_step import *
from supple.methods.intrinsic.truncation_error import *
