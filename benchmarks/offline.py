"""Offline work on the 61.5 m blade (8394 triangles): assembly, factor, basis, derivatives, tensors.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/offline.py
For comparison: the project's targets, and the times of [Wu2019] for its blade (8-core Xeon, MATLAB).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from measure import Steps, keep

from supple.algebra import factorize_symmetric, mass_orthonormalize
from supple.algebra.sparse_factor import Rslab, SuperLU
from supple.body import (
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
    inertia_gram,
)
from supple.fem import HomogeneousSection, Isotropic, assemble, shell_model
from supple.importers import read_abaqus
from supple.reduction import (
    AmplitudeProduct,
    CraigBampton,
    NormalModes,
    Rubin,
    compress,
    internal_force_tensors,
    modal_derivatives,
    rayleigh_ritz,
)

BLADE = Path(__file__).parents[1] / "examples" / "blade.inp"
WALL = HomogeneousSection(Isotropic(61.13e9, 0.3, 1474.9), 0.02)
N_LINEAR, N_ADDED = 10, 15


def main() -> None:
    steps = Steps()
    mesh = steps.measure("read the mesh", lambda: read_abaqus(BLADE), repeats=1)
    model = steps.measure("K and M", lambda: shell_model(mesh, WALL), target=0.5)
    assembly = steps.measure("pattern of the tangent", lambda: assemble(model), repeats=3)
    # Bent so that every term counts: a translation that grows with the square of the span.
    bent = np.zeros((len(mesh.nodes), 6))
    bent[:, 0] = 1e-3 * mesh.nodes[:, 2] ** 2
    steps.measure("tangent", lambda: assembly.tangent(bent.ravel()), target=0.2)
    steps.measure("internal force", lambda: assembly.internal_force(bent.ravel()))

    body = steps.measure(
        "body, with its checks",
        lambda: flexible_body("blade", model, [RigidInterface("root", "ROOT")]),
        repeats=1,
    )
    shift = 1e-3 * body.stiffness.diagonal().mean() / body.mass.diagonal().mean()
    shifted = body.stiffness + shift * body.mass
    for solver in (Rslab(), SuperLU()):
        steps.measure(
            f"factor, {type(solver).__name__}",
            lambda solver=solver: factorize_symmetric(shifted, solver=solver),
            repeats=3,
        )

    variants = (
        ("nodal-fixed Craig-Bampton", NodalFixedFrame("root"), CraigBampton(n_modes=N_LINEAR), 13.25, 241.0),
        ("mean-axis Rubin", MeanAxisFrame(), Rubin(n_columns=N_LINEAR), 2053.0, 230.0),
    )
    for name, frame, recipe, basis_seconds, tensor_seconds in variants:
        linear = steps.measure(
            f"{N_LINEAR} columns, {name}",
            lambda frame=frame, recipe=recipe: rayleigh_ritz(body, frame, recipe.build(body, frame)),
            repeats=3,
            Wu2019=basis_seconds,
        )
        derivatives = steps.measure(
            f"55 derivatives, {name}",
            lambda frame=frame, linear=linear: modal_derivatives(body, frame, linear),
            repeats=3,
        )
        weights = AmplitudeProduct().weights(body, linear, derivatives)
        added = steps.measure(
            f"compression to {N_ADDED}, {name}",
            lambda linear=linear, derivatives=derivatives, weights=weights: compress(
                body, linear, derivatives, N_ADDED, weights
            ),
        )
        basis, _, _ = mass_orthonormalize(np.hstack([linear.vectors, added.vectors]), body.mass)
        steps.measure(
            f"tensors r = {basis.shape[1]}, {name}",
            lambda basis=basis: internal_force_tensors(body, basis),
            repeats=3,
            target=3.0,
            Wu2019=tensor_seconds,
        )
        steps.measure(f"inertia r = {basis.shape[1]}, {name}", lambda basis=basis: inertia_gram(body, basis))

    frame = MeanAxisFrame()
    many = steps.measure("60 free modes", lambda: NormalModes(60).build(body, frame), repeats=1)
    steps.measure("tensors r = 60", lambda: internal_force_tensors(body, many.vectors), repeats=1)
    keep("offline", steps.rows)


if __name__ == "__main__":
    main()
