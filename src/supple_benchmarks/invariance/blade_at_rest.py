"""The 61.5 m blade in equilibrium under the mean wind load of its benchmark, in each of two frames."""

from __future__ import annotations

from supple.body import FullBody
from supple.equations import StaticSearch
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System
from supple.simulation import equilibrium
from supple_benchmarks.compared_models import FRAMES, ROOT
from supple_benchmarks.nrel5mw_blade import BODY, COARSE_GRID, RATED, Blade

__all__ = ["blade_at_rest"]

RESIDUAL = 1e-7


def blade_at_rest(quick: bool) -> dict[str, list[float]]:
    """Mean displacement of the tip of the full clamped blade, m, in mesh axes, by the name of the frame.

    quick : on a coarse mesh
    """
    blade = Blade(COARSE_GRID) if quick else Blade()
    body = blade.body()
    clamp = Fixed(first=GROUND, second=At(BODY, ROOT), name="clamp")
    load = DeadForce(body=BODY, at=blade.leading_edge, force=blade.mean_wind(RATED))
    tip = blade.mesh.nodes_of("tip")
    found = {}
    for name, frame in FRAMES.items():
        system = System((Placed(FullBody(body, frame)),), (clamp,), (load,))
        rest = equilibrium(system, search=StaticSearch(residual=RESIDUAL), fulls=())
        (placed,) = rest.system.bodies
        found[name] = (placed.positions(tip) - body.nodes[tip]).mean(axis=0).tolist()
    return found
