"""Lateral buckling of a narrow cantilever: load at which its bent state has a singular tangent stiffness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from supple.errors import ConvergenceError
from supple.fem import FiniteElementModel, assemble
from supple_benchmarks.invariance.strip import BENDING, LENGTH, TORSION, WARPING, beam_model, strip_model
from supple_benchmarks.references.lateral_buckling import lateral_buckling_load, warped_buckling_load

__all__ = ["lateral_buckling"]


def lateral_buckling(quick: bool) -> dict[str, float]:
    """Critical load over theory: shells over Vlasov (warping prevented at the root), beams over Timoshenko.

    Timoshenko's load and the beams are without warping stiffness.
    """
    beams = beam_model(10 if quick else 40)
    held = warped_buckling_load(BENDING, TORSION, WARPING, LENGTH)
    free = lateral_buckling_load(BENDING, 400 * BENDING, TORSION, LENGTH)
    return {
        "shell": critical_load(strip_model(20), np.array([0.25, 0.5, 0.25]), held) / held,
        "beam": float(critical_load(beams, np.ones(1), free) / free),
    }


def critical_load(model: FiniteElementModel, weights: NDArray[np.float64], expected: float) -> float:
    """Dead force along y, N, at which the tangent stiffness of the bent state is singular.

    weights : share of the force on each node of the tip
    expected : estimate of the force; the search is from 0.7 to 1.2 times this value
    Raises ConvergenceError without equilibrium under a force of this range; ValueError without a solution.
    """
    assembly = assemble(model)
    free = np.ones((model.mesh.n_nodes, 6), dtype=bool)
    free[model.mesh.nodes_of("root")] = False
    kept = np.flatnonzero(free)
    load = np.zeros((model.mesh.n_nodes, 6))
    load[model.mesh.nodes_of("tip"), 1] = weights

    def lowest(force: float) -> float:
        q = np.zeros(model.n_dofs)
        for _ in range(30):
            tangent = assembly.tangent(q).toarray()[np.ix_(kept, kept)]
            residual = (force * load.ravel() - assembly.internal_force(q))[kept]
            change = np.linalg.solve(tangent, residual)
            q[kept] += change
            if np.abs(change).max() < 1e-10:
                return float(np.linalg.eigvalsh(tangent)[0])
        raise ConvergenceError(f"no equilibrium of the strip under {force:.4g} N in its plane")

    found = brentq(lowest, 0.7 * expected, 1.2 * expected, xtol=1e-5 * expected)
    assert isinstance(found, float)
    return found
