"""The bodies that [Han2020] reduces: the cylinder of section 5.1, the connecting rod of section 5.2."""

from __future__ import annotations

from supple.fem import Isotropic
from supple.mesh import Eye, RodOutline

__all__ = ["ALUMINIUM", "LENGTH", "RADIUS", "ROD", "STEEL_LIKE"]

LENGTH, RADIUS = 0.3, 0.015
"""Length and radius of the cylinder, m."""
STEEL_LIKE = Isotropic(youngs_modulus=100e9, poissons_ratio=0.285, density=7850.0)
"""The cylinder's material, softer than steel."""
ROD = RodOutline(length=0.14, thickness=0.012, big=Eye(0.015, 0.022, 0.018), small=Eye(0.008, 0.013, 0.014))
"""m. The paper gives no dimensions; these fit its number and size of tetrahedra."""
ALUMINIUM = Isotropic(youngs_modulus=70e9, poissons_ratio=0.33, density=2710.0)
"""The rod's material."""
