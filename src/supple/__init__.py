"""Reduced-order flexible multibody dynamics: finite-element bodies made small, fast and trustworthy.

The public names stand in the sub-packages, in the order of the flow:

    mesh, importers -> fem -> body -> reduction -> multibody (with integrate) -> results -> viz
"""

__version__ = "0.1.0"
