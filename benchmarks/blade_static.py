"""The blade at rest under the mean wind load of its benchmark, in both frames, and a deck for CalculiX.

    OMP_NUM_THREADS=1 python benchmarks/blade_static.py [blade-static.inp]

The root is clamped in space and the load is dead: 125 forces on the leading edge, the mean over 100 s of the
rated case. The shapes in the two frames differ by the error of the kinematics.

`ccx blade-static` runs the deck in CalculiX. Compare the mean of U over the node set `tip`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from measure import keep

from supple.export import resultant, write_static_deck
from supple.fem import shell_model
from supple_benchmarks.invariance.blade_at_rest import blade_at_rest
from supple_benchmarks.nrel5mw_blade import RATED, ROOT, SECTION, Blade


def main(deck: Path) -> None:
    blade = Blade()
    body = blade.body()
    load = blade.steady_load(body, RATED)[:, 0].reshape(len(body.nodes), -1)
    root = np.asarray(body.interface(ROOT).node_ids)
    model = shell_model(blade.mesh, SECTION)
    write_static_deck(deck, model, load, root, title="61.5 m blade, mean wind load of the rated case")
    total = resultant(model, load)
    print("sum of forces, N", total[:3], "moment about the root's centre, N m", total[3:], flush=True)
    rows = [
        {"frame": frame, "tip, m": rest.tip, "iterations": rest.iterations}
        for frame, rest in blade_at_rest(blade).items()
    ]
    print(*rows, sep="\n", flush=True)
    keep("blade_static", rows, forces=total[:3].tolist(), moments=total[3:].tolist())


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "blade-static.inp"))
