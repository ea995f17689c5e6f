"""Large vibrations of the box beam on stations, compared with its full shell model: table 2 of [Wang2015].

Both models start with the same velocity, a sum of modes on stations. The shell model has one floating frame,
fixed to the clamp; its only damping is that of generalized-alpha with a spectral radius of 0.9. Its walls can
warp and buckle, unlike those of the paper.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from supple.body import FlexibleBody, FullBody, NodalFixedFrame
from supple.errors import SuppleError
from supple.integrate import FixedStep, GeneralizedAlpha, Run, RungeKutta4
from supple.machine import Fixed, Placed, System
from supple.methods.intrinsic import IntrinsicBody, LoadPath, condense
from supple.quantities import node_positions
from supple.simulation import simulate
from supple_benchmarks.table import Row

__all__ = ["box_against_shells", "parabolic_velocity"]

SPEEDS = (0.02, 0.5, 1.0, 2.0)
"""Initial velocity of the tip along y, and also along z."""
OUTPUT, STEP = 0.1, 0.01
N_STATIONS, N_MODES = 41, 100
CLAMP = Fixed(first="ground", second="box.root")


def parabolic_velocity(body: IntrinsicBody, speed: float) -> np.ndarray:
    """Modal velocities (e,) of the initial velocity (0, 1, 1) speed (s / L)^2, by projection."""
    modes = body.modes
    s = modes.line.tree.points[:, 0] / modes.line.tree.points[-1, 0]
    velocity = np.zeros((modes.line.n, 6))
    velocity[:, 1:3] = speed * s[:, None] ** 2
    return velocity.ravel() @ modes.momenta.reshape(-1, modes.n_modes)


def box_against_shells(shells: FlexibleBody, tip: np.ndarray, quick: bool) -> Iterator[Row]:
    """One row for each speed.

    largest : largest displacement of the tip on stations, over the length
    error : largest distance between the tips of both models, over the largest displacement on stations; None
        if the run of the shells fails
    """
    body = condense(shells, LoadPath("root", "tip", N_STATIONS), n_modes=N_MODES)
    duration = 0.5 if quick else 2.0
    for speed in SPEEDS[: 1 if quick else None]:
        rates = parabolic_velocity(body, speed)
        own = _on_stations(body, rates, duration, tip)
        try:
            exact = _of_shells(shells, body.nodal_fields(rates[None])[0][:, 0], duration, tip)
        except SuppleError:
            exact = None
        scale = np.linalg.norm(own, axis=1).max()
        yield {
            "speed": speed,
            "largest": float(scale / np.ptp(body.line.tree.points[:, 0])),
            "error": None if exact is None else float(np.linalg.norm(own - exact, axis=1).max() / scale),
        }


def _on_stations(body: IntrinsicBody, rates: np.ndarray, duration: float, tip: np.ndarray) -> np.ndarray:
    """Mean displacement (t, 3) of the tip nodes of the box on stations."""
    system = System([Placed(body, coordinate_rates=rates)], [CLAMP])
    step = FixedStep(2.0 / float(body.modes.omega.max()))
    solution = simulate(system, Run(duration, OUTPUT, step=step, method=RungeKutta4()))
    return _from_start(body.positions(solution.bodies["box"], tip))


def _of_shells(shells: FlexibleBody, nodal: np.ndarray, duration: float, tip: np.ndarray) -> np.ndarray:
    """Mean displacement (t, 3) of the tip nodes of the shells, for initial nodal velocities (6 N,)."""
    body = FullBody(shells, NodalFixedFrame("root"))
    to_nodes = sparse.csc_array(shells.expansion)
    rates = np.asarray(spsolve((to_nodes.T @ to_nodes).tocsc(), to_nodes.T @ nodal))
    run = Run(duration, OUTPUT, step=FixedStep(STEP), method=GeneralizedAlpha(0.9))
    solution = simulate(System([Placed(body, coordinate_rates=rates)], [CLAMP]), run)
    return _from_start(node_positions(body, solution.bodies["box"], tip))


def _from_start(positions: np.ndarray) -> np.ndarray:
    mean = positions.mean(axis=1)
    return mean - mean[0]
