"""A flexible U that flies: solid elements on stations, its centre of mass, truncated and residual modes.

The U-beam of [Wang2015] 5.2: three legs of 5 m of a solid section, free. The load history is lost in
the text that we have. Chosen: legs as wide and high as the cells of the mesh, E = 3e5, density 10, and on one
tip a dead force of 60 along z and 30 along x, a triangle over 4 s, in consistent units.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import jax.numpy as jnp
import numpy as np

from supple.body import AveragingInterface, FlexibleBody, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, ResidualRungeKutta4, Run, RungeKutta4
from supple.intrinsic import FREE, IntrinsicBody, LoadPath, LoadPaths, condense
from supple.intrinsic.stable_step import largest_stable_step
from supple.machine import DeadForce, Placed, System
from supple.mesh import CellType, Mesh
from supple.simulation import simulate

__all__ = ["energy_drift", "flying_u"]

LEG, MODULUS, DENSITY = 5.0, 3e5, 10.0
FORCE = np.array([30.0, 0.0, 60.0])
DURATION = 4.0


def solid_u(n_leg: int) -> FlexibleBody:
    """Three legs in the x-y plane: along x, along y, and back; n_leg cells of 20 nodes a leg."""
    h = LEG / n_leg
    # A grid of square cells of which those of the U are kept.
    cells = [(i, 0) for i in range(n_leg + 1)]
    cells += [(n_leg, j) for j in range(1, n_leg + 1)]
    cells += [(i, n_leg) for i in range(n_leg - 1, -1, -1)]
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    corners = np.array([[*corner, z] for z in (0, 1) for corner in square])
    middle = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    local = np.vstack([2 * corners, [corners[a] + corners[b] for a, b in middle]])
    numbers = 2 * np.array([(i, j, 0) for i, j in cells])[:, None] + local
    unique, inverse = np.unique(numbers.reshape(-1, 3), axis=0, return_inverse=True)
    nodes = unique / 2 * np.array([h, h, h])
    mesh = Mesh(nodes, {CellType.HEXA20: inverse.reshape(len(cells), 20)})
    return flexible_body("u", solid_model(mesh, Isotropic(MODULUS, 0.3, DENSITY)), _ends(nodes, h, n_leg))


def _ends(nodes: np.ndarray, h: float, n_leg: int) -> list[AveragingInterface]:
    x, y = nodes[:, 0] / h, nodes[:, 1] / h
    first, last = (y <= 1 + 1e-9), (y >= n_leg - 1e-9)
    near, far = x < 1e-9, x >= n_leg - 1e-9
    sets = {"tip": near & first, "corner": far & first, "other corner": far & last, "other tip": near & last}
    return [AveragingInterface(name, np.flatnonzero(inside)) for name, inside in sets.items()]


def on_stations(body: FlexibleBody, n_stations: int, n_modes: int | None = None) -> IntrinsicBody:
    """Free, with a third of the stations on each leg; n_stations = 3 k + 1."""
    k = (n_stations - 1) // 3 + 1
    names = ("tip", "corner", "other corner", "other tip")
    legs = [LoadPath(a, b, k) for a, b in pairwise(names)]
    return condense(body, LoadPaths(legs), support=FREE, n_modes=n_modes)


def pushed(body: IntrinsicBody) -> System:
    """The U under its triangular load."""
    return System([body], loads=[DeadForce(at="u.tip", force=_load)])


def _load(time: Any) -> Any:
    return jnp.asarray(FORCE) * jnp.maximum(0.0, 1.0 - jnp.abs(time / (DURATION / 2) - 1.0))


def flying_u(quick: bool) -> dict[str, Any]:
    """Error of the centre of mass by the number of stations; truncated beside residual modes."""
    body = solid_u(8 if quick else 12)
    stations = (7, 13) if quick else (7, 13, 19, 25, 31)
    errors = {str(n): _centre_error(on_stations(body, n)) for n in stations}
    segments = np.log([n - 1 for n in stations])
    order = float(-np.polyfit(segments, np.log(list(errors.values())), 1)[0])
    return {"com_error": errors, "order": order, "residualised": _residual_rows(on_stations(body, 13), quick)}


def _centre_error(body: IntrinsicBody) -> float:
    """Root mean square over time, m: against twice the integrated force over the mass."""
    times, positions = _flown(body, RungeKutta4())
    masses = body.line.station_masses
    assert masses is not None
    # Stations carry their mass beside them: M = [[m, -m c~], [m c~, ..]].
    offsets = np.stack([masses[:, 2, 4], masses[:, 0, 5], masses[:, 1, 3]], axis=1) * [-1, -1, -1]
    rotations, places = positions
    weighted = masses[:, 0, 0] @ places + np.einsum("tnij,nj->ti", rotations, offsets)
    centre = weighted / body.mass
    exact = centre[0] + _distance(times)[:, None] * FORCE / body.mass
    return float(np.sqrt(np.mean(np.sum((centre - exact) ** 2, axis=1))))


def _distance(times: np.ndarray) -> np.ndarray:
    """Twice integrated triangle, of unit height."""
    half = DURATION / 2
    early = times**3 / (6 * half)
    t = times - half
    late = half**2 / 6 + half * t / 2 + t**2 / 2 - t**3 / (6 * half)
    return np.where(times <= half, early, late)


def _flown(body: IntrinsicBody, rule: Any, *, kept: int | None = None) -> tuple[np.ndarray, Any]:
    omega = body.modes.omega[: None if kept is None else kept]
    step = min(0.8 * largest_stable_step(omega, 0 * omega, 0.0), 0.02)
    run = Run(DURATION, DURATION / 20, step=FixedStep(step), method=rule)
    solution = simulate(pushed(body), run)
    return solution.times, body.places(solution.bodies["u"])


def _residual_rows(body: IntrinsicBody, quick: bool) -> list[dict[str, Any]]:
    """Position of all stations against that of all modes, root mean square over time, m."""
    _, (_, whole) = _flown(body, RungeKutta4())
    rows = []
    for kept in (24,) if quick else (18, 30, 48):
        fewer = IntrinsicBody(body.modes.truncated(kept), body.expansion, body.stations)
        _, (_, truncated) = _flown(fewer, RungeKutta4())
        _, (_, residual) = _flown(body, ResidualRungeKutta4(kept), kept=kept)
        omega = body.modes.omega[:kept]
        rows.append(
            {
                "kept": kept,
                "truncated_error": _rms(truncated - whole),
                "residualised_error": _rms(residual - whole),
                "dt_max": largest_stable_step(omega, 0 * omega, 0.0),
            }
        )
    return rows


def _rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=-1))))


def energy_drift(quick: bool) -> float:
    """Largest relative change of the energy of a U that vibrates and turns without a load, by Runge-Kutta."""
    body = on_stations(solid_u(6), 7, 24)
    rates = np.zeros(body.n_coordinates)
    rates[:4] = 20.0
    placed = Placed(body, coordinate_rates=rates, angular_velocity=np.array([0.5, 0.2, 1.0]))
    step = 0.1 * largest_stable_step(body.modes.omega, 0 * body.modes.omega, 0.0)
    duration = (100 if quick else 1000) * step
    run = Run(duration, duration / 20, step=FixedStep(step), method=RungeKutta4())
    motion = simulate(System([placed]), run).bodies["u"]
    energy = np.sum(motion.rates**2, axis=1) + np.sum(body.forces_of(motion.coordinates) ** 2, axis=1)
    return float(np.abs(energy / energy[0] - 1).max())
