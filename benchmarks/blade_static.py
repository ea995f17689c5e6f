"""The blade at rest under the mean wind load of its benchmark: both frames, and a deck for a second opinion.

    OMP_NUM_THREADS=1 python benchmarks/blade_static.py [blade-static.inp]

The root is clamped in space and the load is dead: 125 forces on the leading edge, the mean over 100 s of the
rated case. Either frame must come to the same shape; what they are apart is the error of the kinematics.

CalculiX runs the deck: ccx blade-static. The mean of U over the node set `tip` stands beside ours.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from measure import keep

from supple.body import FullBody
from supple.export import resultant, write_static_deck
from supple.fem import shell_model
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System
from supple.multibody import StaticSearch
from supple.simulation import equilibrium
from supple_benchmarks.nrel5mw_blade import BODY, FRAMES, RATED, ROOT, SECTION, Blade

RESIDUAL = 1e-7


def main(deck: Path) -> None:
    blade = Blade()
    body = blade.body()
    load = blade.steady_load(body, RATED)[:, 0].reshape(len(body.nodes), -1)
    root = np.asarray(body.interface(ROOT).node_ids)
    model = shell_model(blade.mesh, SECTION)
    write_static_deck(deck, model, load, root, title="61.5 m blade, mean wind load of the rated case")
    total = resultant(model, load)
    print("sum of forces, N", total[:3], "moment about the root's centre, N m", total[3:], flush=True)
    force = DeadForce(body=BODY, at=blade.leading_edge, force=load[blade.leading_edge, :3])
    clamp = Fixed(first=GROUND, second=At(BODY, ROOT))
    rows = []
    for name, frame in FRAMES.items():
        system = System(bodies=(Placed(FullBody(body, frame)),), joints=(clamp,), loads=(force,))
        found = equilibrium(system, search=StaticSearch(residual=RESIDUAL))
        moved = _tip(blade, found.system.bodies[0]) - _tip(blade, system.bodies[0])
        rows.append({"frame": name, "tip, m": moved.tolist(), "iterations": found.iterations})
        print(rows[-1], flush=True)
    keep("blade_static", rows, forces=total[:3].tolist(), moments=total[3:].tolist())


def _tip(blade: Blade, placed: Placed) -> np.ndarray:
    """Mean place in space of the tip's nodes."""
    full = placed.body
    assert isinstance(full, FullBody)
    coordinates = placed.coordinates if placed.coordinates.size else np.zeros(full.n_coordinates)
    local = (full.nodes + full.expand(coordinates))[blade.mesh.nodes_of("tip")].mean(axis=0)
    return placed.position + placed.rotation @ local


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "blade-static.inp"))
