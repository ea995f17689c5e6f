"""Intrinsic modal reduction: slender bodies with arbitrary rotations, from a linear model alone."""

from supple.methods.intrinsic.chosen_step import *
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
from supple.methods.intrinsic.truncation_error import *
