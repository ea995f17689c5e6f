"""Intrinsic modal reduction: slender bodies at any rotation, from a linear model alone."""

from supple.intrinsic.chosen_step import *
from supple.intrinsic.condensation_error import *
from supple.intrinsic.condense import *
from supple.intrinsic.condensed_line import *
from supple.intrinsic.engine import *
from supple.intrinsic.enough_modes import *
from supple.intrinsic.imported_line import *
from supple.intrinsic.intrinsic_body import *
from supple.intrinsic.intrinsic_modes import *
from supple.intrinsic.intrinsic_motion import *
from supple.intrinsic.line_balances import *
from supple.intrinsic.load_path import *
from supple.intrinsic.load_path_tree import *
from supple.intrinsic.released import *
from supple.intrinsic.root_support import *
from supple.intrinsic.truncation_error import *
from supple.intrinsic.velocity_integration import *
