"""Offline work on the 61.5 m blade (8394 triangles): assembly, factor, basis, derivatives, tensors.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/offline.py
Beside ours: the targets of the project and the seconds of [Wu2019] (8-core Xeon, MATLAB).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from measure import keep, peak_megabytes, timed

from supple.algebra import factorize_symmetric
from supple.algebra.sparse_factor import Rslab, SuperLU
from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import HomogeneousWall, Isotropic, assemble, shell_model
from supple.importers import read_abaqus
from supple.reduction import CompressedDerivatives, Rubin, modal_derivatives, reduce, vibrating_basis
from supple.reduction.tensors import internal_force_tensors

BLADE = Path(__file__).parents[1] / "examples" / "blade.inp"


def main() -> None:
    rows = []

    def note(step: str, seconds: float, **beside: object) -> None:
        rows.append({"step": step, "seconds": seconds, "peak MB": peak_megabytes(), **beside})

    mesh = read_abaqus(BLADE)
    wall = HomogeneousWall(Isotropic(61.13e9, 0.3, 1474.9), 0.02)
    seconds, model = timed(lambda: shell_model(mesh, wall))
    note("K and M", seconds, target=0.5)
    assembly = assemble(model)
    q = np.zeros(assembly.n)
    note("tangent", timed(lambda: assembly.tangent(q))[0], target=0.2)
    note("internal force", timed(lambda: assembly.internal_force(q))[0])
    seconds, body = timed(lambda: flexible_body("blade", model, [RigidInterface("root", "ROOT")]), 1)
    note("body with all checks", seconds)
    shifted = (
        body.stiffness + 1e-3 * body.stiffness.diagonal().mean() * body.mass / body.mass.diagonal().mean()
    )
    for solver in (Rslab(), SuperLU()):
        name = type(solver).__name__
        note(f"factor, {name}", timed(lambda solver=solver: factorize_symmetric(shifted, solver=solver))[0])
    published = {
        "nodal-fixed": (NodalFixedFrame("root"), 13.25, 241.0),
        "mean-axis": (MeanAxisFrame(), 2053.0, 230.0),
    }
    for name, (frame, basis_seconds, tensor_seconds) in published.items():
        seconds, linear = timed(
            lambda frame=frame: vibrating_basis(body, frame, Rubin(n_columns=10).build(body, frame)), 1
        )
        note(f"10 columns, {name}", seconds, Wu2019=basis_seconds)
        note(
            f"55 derivatives, {name}",
            timed(lambda frame=frame, linear=linear: modal_derivatives(body, frame, linear), 1)[0],
        )
        reduced = reduce(body, frame, Rubin(n_columns=10), derivatives=CompressedDerivatives(15))
        basis = np.asarray(body.expansion.T @ reduced.nodal_basis)
        seconds, _ = timed(lambda basis=basis: internal_force_tensors(body, basis), 1)
        note(f"tensors r = {reduced.r}, {name}", seconds, Wu2019=tensor_seconds, target=3.0)
    keep("offline", rows)


if __name__ == "__main__":
    main()
