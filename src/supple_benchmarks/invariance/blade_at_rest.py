"""The 61.5 m blade at rest under the mean wind load of its benchmark, in both frames."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from supple.body import FullBody, MeanAxisFrame, NodalFixedFrame
from supple.machine import GROUND, At, Constant, DeadForce, Fixed, Placed, Scaled, System
from supple.mesh import BladeGrid
from supple.simulation import equilibrium
from supple_benchmarks.nrel5mw_blade import BODY, RATED, ROOT, Blade

__all__ = ["blade_at_rest"]


def blade_at_rest(grid: BladeGrid | None, progress: Any = lambda *_: None) -> Mapping[str, list[float]]:
    """Displacement of the tip section against the clamped root, m, in the axes of the mesh."""
    blade = Blade() if grid is None else Blade(grid)
    body = blade.body()
    wind = blade.steady_load(body, RATED)[:, 0].reshape(len(body.nodes), -1)[blade.leading_edge, :3]
    tip = blade.mesh.nodes_of("tip")
    found = {}
    for name, frame in (("nodal-fixed", NodalFixedFrame(ROOT)), ("mean-axis", MeanAxisFrame())):
        clamp = Fixed(first=GROUND, second=At(BODY, ROOT), name="clamp")
        load = DeadForce(body=BODY, at=blade.leading_edge, force=Scaled(wind, Constant(1.0)))
        # The ground's end of the clamp is where the interface stands.
        system = System((Placed(FullBody(body, frame)),), (clamp,), (load,))
        rest = equilibrium(system, progress=lambda iteration, _: progress(iteration / 100)).system.bodies[0]
        local = body.nodes[tip] + rest.body.expand(rest.coordinates)[tip]
        moved = rest.position + local @ rest.rotation.T - body.nodes[tip]
        found[name] = moved.mean(axis=0).tolist()
    return found
