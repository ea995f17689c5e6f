"""The 61.5 m blade in equilibrium under the mean wind load of its benchmark, in each of two frames."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from supple.body import FullBody
from supple.equations import StaticSearch
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System
from supple.simulation import equilibrium
from supple_benchmarks.nrel5mw_blade import BODY, FRAMES, RATED, ROOT, Blade

__all__ = ["Rest", "blade_at_rest"]

RESIDUAL = 1e-7


class Rest(NamedTuple):
    """Mean displacement of the tip nodes of the clamped blade, m, in mesh axes; number of iterations."""

    tip: list[float]
    iterations: int


def blade_at_rest(blade: Blade, progress: Callable[[float], None] = lambda _: None) -> dict[str, Rest]:
    """Equilibrium of the full blade in each frame, by the name of the frame."""
    body = blade.body()
    wind = blade.steady_load(body, RATED)[:, 0].reshape(len(body.nodes), -1)[blade.leading_edge, :3]
    clamp = Fixed(first=GROUND, second=At(BODY, ROOT), name="clamp")
    load = DeadForce(body=BODY, at=blade.leading_edge, force=wind)
    tip = blade.mesh.nodes_of("tip")
    found = {}
    for name, frame in FRAMES.items():
        system = System((Placed(FullBody(body, frame)),), (clamp,), (load,))
        rest = equilibrium(system, search=StaticSearch(residual=RESIDUAL), fulls=())
        (placed,) = rest.system.bodies
        moved = placed.positions(tip) - body.nodes[tip]
        found[name] = Rest(moved.mean(axis=0).tolist(), rest.iterations)
        progress(len(found) / len(FRAMES))
    return found
