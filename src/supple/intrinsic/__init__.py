"""Intrinsic modal reduction: slender bodies at any rotation, from a linear model alone."""

from supple.intrinsic.chosen_step import with_chosen_step
from supple.intrinsic.condensation_error import accurate_condensation, condensation_error
from supple.intrinsic.condense import condense
from supple.intrinsic.condensed_line import CondensedLine, clamped_line, condensed_line
from supple.intrinsic.engine import IntrinsicEngine, intrinsic_engine
from supple.intrinsic.enough_modes import enough_modes
from supple.intrinsic.imported_line import read_condensed_line
from supple.intrinsic.intrinsic_body import IntrinsicBody, intrinsic_body
from supple.intrinsic.intrinsic_modes import IntrinsicModes, intrinsic_modes
from supple.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.intrinsic.line_balances import line_balances
from supple.intrinsic.load_path import LoadPath, LoadPaths, NodeSetPath
from supple.intrinsic.load_path_tree import LoadPathTree, load_path_tree
from supple.intrinsic.released import released
from supple.intrinsic.root_support import BALL, CLAMPED, FREE, RootSupport, hinged, sliding
from supple.intrinsic.truncation_error import TruncationError, truncation_error
from supple.intrinsic.velocity_integration import integrated_places

__all__ = [
    "BALL",
    "CLAMPED",
    "FREE",
    "CondensedLine",
    "IntrinsicBody",
    "IntrinsicEngine",
    "IntrinsicModes",
    "IntrinsicMotion",
    "LoadPath",
    "LoadPathTree",
    "LoadPaths",
    "NodeSetPath",
    "RootSupport",
    "TruncationError",
    "accurate_condensation",
    "clamped_line",
    "condensation_error",
    "condense",
    "condensed_line",
    "enough_modes",
    "hinged",
    "integrated_places",
    "intrinsic_body",
    "intrinsic_engine",
    "intrinsic_modes",
    "line_balances",
    "load_path_tree",
    "read_condensed_line",
    "released",
    "sliding",
    "truncation_error",
    "with_chosen_step",
]
