"""Radial growth of a rotating steel disc, from a mesh of solids.

A disc of 200 mm radius and 10 mm thickness rotates at 600 rad/s about its axis. Its support, the mean
motion of one face, does not affect the stress.

Expected: the rim moves outwards by `(1 - nu) rho omega^2 R^3 / (4 E)`, the plane stress solution of a disc
without a bore, within 1 % (thickness and mesh).
Run it: `python examples/spinning_disc.py` draws the radial displacement to spinning_disc.png.
"""

from pathlib import Path

import numpy as np

import supple as sp
from supple import machine as m

RADIUS, THICKNESS, SPEED = 0.2, 0.01, 600.0
STEEL = sp.Isotropic(2.1e11, 0.3, 7850.0)


def main(picture: Path = Path("spinning_disc.png")) -> float:
    """Increase of the radius, m."""
    mesh = sp.cylinder(RADIUS, THICKNESS, 4, 1, 1, sp.CellType.TETRA10)
    axis = np.array([1.0, 0, 0])
    model = sp.solid_model(mesh, STEEL)
    body = sp.flexible_body("disc", model, [sp.AveragingInterface("axle", "root")])
    disc = sp.FullBody(body, sp.MeanAxisFrame())
    driver = m.PrescribedRotation(
        first="ground", second="disc.axle", axis=tuple(axis), angle=m.ConstantRate(SPEED)
    )
    found = sp.equilibrium(sp.System([disc], [driver]), spin=m.Spin(SPEED, axis))

    placed = found.system.bodies[0]
    before = np.linalg.norm(mesh.nodes - np.outer(mesh.nodes @ axis, axis), axis=1)
    places = placed.positions()
    outwards = np.linalg.norm(places - np.outer(places @ axis, axis), axis=1) - before
    rim = before > RADIUS * (1 - 1e-9)
    exact = (1 - STEEL.poissons_ratio) * STEEL.density * SPEED**2 * RADIUS**3 / (4 * STEEL.youngs_modulus)
    growth = float(outwards[rim].mean())
    print(f"the radius grows by {1e6 * growth:.4g} um, in theory by {1e6 * exact:.4g}")
    assert np.isclose(growth, exact, rtol=1e-2)

    from supple.units import SI
    from supple.viz import NodalField

    field = NodalField("growth of the radius (um)", 1e6 * outwards)
    sp.plot_contour(picture, mesh.nodes, sp.skin_of(mesh), field, units=SI)
    return growth


if __name__ == "__main__":
    main()
