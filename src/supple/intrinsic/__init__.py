"""Intrinsic modal reduction: slender bodies at any rotation, from a linear model alone."""

from supple.intrinsic.condensed_line import CondensedLine, clamped_line, condensed_line
from supple.intrinsic.intrinsic_modes import IntrinsicModes, intrinsic_modes
from supple.intrinsic.load_path_tree import LoadPathTree, load_path_tree
from supple.intrinsic.root_support import BALL, CLAMPED, FREE, RootSupport, hinged, sliding

__all__ = [
    "BALL",
    "CLAMPED",
    "FREE",
    "CondensedLine",
    "IntrinsicModes",
    "LoadPathTree",
    "RootSupport",
    "clamped_line",
    "condensed_line",
    "hinged",
    "intrinsic_modes",
    "load_path_tree",
    "sliding",
]
