"""The blade at rest under the mean wind load of its benchmark: both frames, and a deck for a second opinion.

    OMP_NUM_THREADS=1 python benchmarks/blade_static.py [blade-static.inp]

The root is clamped in space and the load is dead: 125 forces on the leading edge, the mean over 100 s of the
rated case. Either frame must come to the same shape; what they are apart is the error of the kinematics. The
equilibrium is the end of a march with steps far longer than any period and a rule that forgets at once
(generalized-alpha, rho = 0), under a load that is raised on the way.

Runs with CalculiX: ccx blade-static; the mean of U over the node set tip is what stands in the table.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from measure import keep

from supple.body import FullBody
from supple.export import resultant, write_static_deck
from supple.fem import GREEN_LAGRANGE, shell_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, Scaled, System, Table
from supple.results import node_positions
from supple.simulation import simulate
from supple_benchmarks.blade.problem import BODY, FRAMES, RATED, ROOT, SECTION, Blade

STEP, RAISED, SETTLED = 100.0, 6, 6
"""s, and steps in which the load is raised, and then kept; the slowest period is 1.5 s."""


def main(deck: Path) -> None:
    blade = Blade()
    body = blade.body()
    model = shell_model(blade.mesh, SECTION, kinematics=GREEN_LAGRANGE)
    load = blade.steady_load(body, RATED)[:, 0].reshape(len(body.nodes), -1)
    root = np.asarray(body.interface(ROOT).node_ids)
    write_static_deck(deck, model, load, root, title="61.5 m blade, mean wind load of the rated case")
    total = resultant(model, load)
    print("sum of forces, N", total[:3], "moment about the root's centre, N m", total[3:], flush=True)
    tip = blade.mesh.nodes_of("tip")
    rows = []
    for name, frame in FRAMES.items():
        full = FullBody(body, frame)
        solution = simulate(
            _system(full, blade, load[blade.leading_edge, :3]),
            Run(
                (RAISED + SETTLED) * STEP,
                STEP,
                step=FixedStep(STEP),
                method=GeneralizedAlpha(0.0),
                tolerances=Tolerances(residual=1e-8),
            ),
        )
        places = node_positions(full, solution.bodies[BODY], tip).mean(axis=1)
        moved = places - body.nodes[tip].mean(axis=0)
        rows.append(
            {
                "frame": name,
                "tip, m": moved[-1].tolist(),
                "moved in the last step, m": float(np.linalg.norm(moved[-1] - moved[-2])),
            }
        )
        print(rows[-1], flush=True)
    keep("blade_static", rows, forces=total[:3].tolist(), moments=total[3:].tolist())


def _system(full: FullBody, blade: Blade, forces: np.ndarray) -> System:
    rise = Table(np.array([0.0, RAISED * STEP, (RAISED + SETTLED) * STEP]), np.array([0.0, 1.0, 1.0]))
    return System(
        bodies=(Placed(full),),
        joints=(Fixed(first=GROUND, second=At(BODY, ROOT)),),
        loads=(DeadForce(body=BODY, at=blade.leading_edge, force=Scaled(forces, rise)),),
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "blade-static.inp"))
