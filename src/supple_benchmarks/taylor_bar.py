"""Taylor's bar: a copper cylinder hits a rigid wall at 227 m/s.

Length 32.4 mm, radius 3.2 mm, E = 117 GPa, nu = 0.35, rho = 8930 kg/m^3, sigma_y = 400 MPa, linear
hardening of 100 MPa, 80 us, no friction. Published final length 21.26 to 21.66 mm, mushroom radius 6.89 to
7.24 mm: A. M. Kamoulakos, Bench Mark (1990), 21.47-21.66, 7.02-7.12; Y. Y. Zhu, S. Cescotto, Int. J. Numer.
Methods Eng. 38 (1995), 21.26-21.49, 6.89-7.18; G. T. Camacho, M. Ortiz, Comput. Methods Appl. Mech. Eng.
142 (1997) 269-301, 21.42-21.44, 7.21-7.24.
"""

from __future__ import annotations

import numpy as np

from supple.fem import Isotropic, solid_model
from supple.integrate import Run
from supple.machine import (
    At,
    Contact,
    Placed,
    RigidPlane,
    System,
)
from supple.mesh import CellType, cylinder
from supple.methods.explicit import (
    J2Plasticity,
    LinearHardening,
    NodalMotion,
    explicit_subdomain,
)
from supple.simulation import simulate

__all__ = ["COPPER", "taylor_bar", "taylor_bar_end"]

COPPER = Isotropic(117e9, 0.35, 8930.0)
RADIUS, LENGTH, SPEED, DURATION = 3.2e-3, 32.4e-3, 227.0, 80e-6


def taylor_bar_end(n_core: int, n_ring: int, n_length: int) -> tuple[float, float, float]:
    """Final length and mushroom radius, m, and largest plastic strain."""
    mesh = cylinder(RADIUS, LENGTH, n_core, n_ring, n_length, CellType.HEXA8)
    law = J2Plasticity(COPPER, LinearHardening(400e6, 100e6))
    bar = explicit_subdomain(solid_model(mesh, COPPER), law, name="bar")
    system = System(
        [Placed(bar, velocity=np.array([-SPEED, 0.0, 0.0]))],
        contacts=[Contact(At("bar", "root"), RigidPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))],
    )
    motion = simulate(system, Run(DURATION, DURATION / 10)).motion("bar", NodalMotion)
    x = motion.nodes[-1]
    radius = float(np.hypot(x[:, 1], x[:, 2]).max())
    return float(x[mesh.node_sets["tip"], 0].mean()), radius, float(motion.plastic_strain[-1].max())


def taylor_bar(quick: bool) -> dict[str, float]:
    """Final length and mushroom radius, m."""
    length, radius, _ = taylor_bar_end(*((3, 2, 27) if quick else (4, 3, 36)))
    return {"length": length, "radius": radius}
