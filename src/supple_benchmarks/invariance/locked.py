"""Bodies on a basis of fixed size in equilibrium: errors due to locking, and the locking indicator."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from supple.body import FlexibleBody, FullBody
from supple.errors import LockingWarning
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    LinearBasisRecipe,
    PlainQuartic,
    ReducedBody,
    Rubin,
    StaticCorrection,
    project,
    reduction_basis,
)
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.box import BOX_LENGTH, box_of_walls, weak_bending
from supple_benchmarks.invariance.clamped import clamped_body, resting_tip
from supple_benchmarks.invariance.strip import BENDING, LENGTH, TORSION, WIDTH, strip_model
from supple_benchmarks.table import Row

__all__ = ["locked_bodies"]

ROTATION = 0.08
"""Rotation of the tip in linear theory, rad."""
SMALL = 1e-3
"""Fraction of the load at which locking is negligible: the error is that of the columns in linear theory."""
RECIPES = {"nodal-fixed": CraigBampton(10), "mean-axis": Rubin(10)}


def locked_bodies(quick: bool) -> Iterator[Row]:
    """Errors of the tip displacement of reduced bodies, relative to the full body in the same frame.

    error_before : error with plain tensors;   error : error with the default tensors
    error_linear : error with the default tensors under a thousandth of the load, due to motion outside the
        linear columns
    indicator : locking indicator of the plain tensors, for the load most similar to the load of the case

    The couple, two forces at the corners of the tip, is applied twice: with the default basis, and with the
    static response to the couple as an additional column.
    """
    bodies = [clamped_body("strip", strip_model(20))]
    if not quick:
        bodies.append(clamped_body("box", box_of_walls(16)))
    for body in bodies:
        for frame in FRAMES:
            for case, forces in _loads(body).items():
                yield _row(body, frame, case, forces, RECIPES[frame])
                if case == "torsion":
                    with_response = StaticCorrection(RECIPES[frame], _nodal(body, forces))
                    yield _row(body, frame, f"{case}, its static response a column", forces, with_response)


def _loads(body: FlexibleBody) -> dict[str, np.ndarray]:
    """Dead forces (N, 3) by case: equal forces on all nodes; for the strip also a couple at the tip."""
    x = body.nodes[:, 0]
    length, bending, torsion, width = (
        (LENGTH, BENDING, TORSION, WIDTH) if body.name == "strip" else (BOX_LENGTH, weak_bending(), None, 1.0)
    )
    spread = np.zeros((len(x), 3))
    # Under a uniform load p per length, the slope at the tip is p L^3 / (6 E I).
    spread[:, 2] = 6 * bending * ROTATION / length**2 / len(x)
    loads = {"uniform": spread}
    if torsion is not None:
        assert body.model is not None
        tip = body.model.mesh.nodes_of("tip")
        couple = np.zeros((len(x), 3))
        couple[tip[[0, -1]], 2] = np.array([-1, 1]) * torsion * ROTATION / length / width
        loads["torsion"] = couple
    return loads


def _nodal(body: FlexibleBody, forces: np.ndarray) -> np.ndarray:
    """Nodal forces (N, 3) as a load vector (n_nodal, 1)."""
    load = np.zeros((len(body.nodes), body.dofs_per_node))
    load[:, :3] = forces
    return load.reshape(-1, 1)


def _row(body: FlexibleBody, frame: str, case: str, forces: np.ndarray, recipe: LinearBasisRecipe) -> Row:
    assert body.model is not None
    tip = body.model.mesh.nodes_of("tip")
    watched = tip if case == "uniform" else tip[-1:]
    nodes = np.flatnonzero(forces.any(axis=1))

    def moved(form: FullBody | ReducedBody, share: float = 1.0) -> np.ndarray:
        return resting_tip([form], nodes, share * forces[nodes], watched) - body.nodes[watched].mean(axis=0)

    full = FullBody(body, FRAMES[frame])
    exact = {share: moved(full, share) for share in (1.0, SMALL)}

    def error(form: ReducedBody, share: float = 1.0) -> float:
        return float(np.linalg.norm(moved(form, share) - exact[share]) / np.linalg.norm(exact[share]))

    columns = reduction_basis(body, FRAMES[frame], recipe, derivatives=CompressedDerivatives(10))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)  # the study measures locking
        plain = project(body, columns, quartic=PlainQuartic())
    form = project(body, columns)
    locking = form.report.locking
    assert locking is not None
    like = "acceleration z" if case == "uniform" else "angular acceleration x"
    return {
        "body": body.name,
        "frame": frame,
        "case": case,
        "coordinates": form.n_coordinates,
        "error_before": error(plain),
        "error": error(form),
        "error_linear": error(form, SMALL),
        "indicator": float(locking.plain[list(locking.loads).index(like)]),
    }
