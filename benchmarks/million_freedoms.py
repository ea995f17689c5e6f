"""A body of a million DOF, ten-node tetrahedra, and its basis of thirty modes: time and memory.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/million_freedoms.py [--layers N]
A steel shaft of 3.2 m, clamped at one end. Its discs have only 288 elements each, so that factors have a
small bandwidth; factors of a compact block with as many DOF would be several times as large. The target is
24 GB: `process MB` is the peak memory of the process. Fewer layers give a shorter shaft of the same elements,
for a trial.
"""

from __future__ import annotations

import argparse
from functools import partial

from measure import Steps, keep

from supple.body import NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, cylinder
from supple.reduction import CraigBampton, NoDerivatives, reduction_basis

STEEL = Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7850.0)
RADIUS, LAYER, LAYERS, N_MODES = 0.015, 4e-3, 800, 30


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--layers", type=int, default=LAYERS, help="discs along the shaft")
    layers = parser.parse_args().layers
    steps = Steps(repeats=1, announce=partial(print, flush=True))
    mesh = cylinder(RADIUS, LAYER * layers, 4, 2, layers, CellType.TETRA10)
    root = RigidInterface("root", "root")
    # Linear: the arrays of the elements are not needed after the assembly of K and M.
    body = steps.measure(
        "K, M and body, with its checks",
        lambda: flexible_body("shaft", solid_model(mesh, STEEL), [root]).linearized(),
    )
    basis = steps.measure(
        "basis of 30 modes",
        lambda: reduction_basis(
            body, NodalFixedFrame("root"), CraigBampton(N_MODES), derivatives=NoDerivatives()
        ),
    )
    assert basis.vectors.shape[0] == body.n
    if layers == LAYERS:
        keep("million_freedoms", steps.rows, freedoms=body.n, cells=len(mesh.cells[CellType.TETRA10]))


if __name__ == "__main__":
    main()
