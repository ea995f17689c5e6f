"""Static large-deflection equilibrium of the geometrically exact planar beam under an end load."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_banded

from supple.errors import ConvergenceError, ModelError
from supple_benchmarks.planar_beam import BANDWIDTH, NODE_SIZE, Array, BeamElements

MAX_ITERATIONS = 50


def bend_beam(
    elements: BeamElements, end_load: Array, *, n_load_steps: int = 10, tolerance: float = 1e-10
) -> Array:
    """Configuration (N, 3) of a cantilever, clamped at the origin along x, under a dead end load.

    Solves grad U(q) = F with the load raised in equal steps.

    Parameters
    ----------
    end_load : array (3,)     force along x and y (they keep their direction), moment
    n_load_steps : int        with more load steps, Newton's method converges at larger rotations
    tolerance : float         on the residual, relative to the internal force

    Raises
    ------
    ModelError          end load not three finite numbers, or fewer than one load step
    ConvergenceError    Newton's method failed at a load step
    """
    load = np.asarray(end_load, dtype=float)
    if load.shape != (NODE_SIZE,) or not np.isfinite(load).all():
        raise ModelError(f"planar beam: the end load is {end_load}; give two force components and a moment")
    if n_load_steps < 1:
        raise ModelError(f"planar beam: n_load_steps is {n_load_steps}; give at least one")
    configuration = elements.straight(0.0)
    at_rest = np.zeros_like(configuration)
    floor = 1e-13 * elements.beam.axial_stiffness
    error = np.inf
    for i in range(1, n_load_steps + 1):
        for _ in range(MAX_ITERATIONS):
            residual, internal, tangent = elements.residual_and_tangent(configuration, at_rest, 0.0)
            residual[-NODE_SIZE:] -= load * (i / n_load_steps)
            error = float(np.linalg.norm(residual[NODE_SIZE:]))
            if error <= tolerance * float(np.linalg.norm(internal)) + floor:
                break
            free = tangent[:, NODE_SIZE:]
            correction = solve_banded((BANDWIDTH, BANDWIDTH), free, -residual[NODE_SIZE:])
            configuration[1:] += correction.reshape(-1, NODE_SIZE)
        else:
            raise ConvergenceError(
                f"planar beam: no equilibrium at load step {i} of {n_load_steps} "
                f"(residual {error:.2e}): take more load steps"
            )
    return configuration
