"""A flexible U in free flight: path of its centre of mass, truncated and residual modes, snapshots.

The load history of [Wang2015] 5.2 is missing in our copy of the text. The load chosen here is a dead force on
one tip that increases linearly for 2 s and decreases linearly to zero in another 2 s. Its largest value is 60
along z and 30 along x, in consistent units.
"""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from supple.integrate import FixedStep, ResidualRungeKutta4, Run, RungeKutta4
from supple.machine import DeadForce, Placed, System
from supple.methods.intrinsic import IntrinsicBody, IntrinsicMotion
from supple.methods.intrinsic.stable_step import largest_stable_step
from supple.simulation import simulate
from supple_benchmarks.intrinsic.u_beam import of_beam_elements, on_stations, solid_u
from supple_benchmarks.intrinsic.u_spectrum import eigenvalue_differences, stiffness_pattern
from supple_benchmarks.table import Row

__all__ = ["energy_drift", "flying_u"]

Flight = tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]
"""Times (t,), and rotations and places of the stations."""
Rule = RungeKutta4 | ResidualRungeKutta4
FORCE = np.array([30.0, 0.0, 60.0])
DURATION = 4.0
N_OUTPUTS, N_SNAPSHOTS = 20, 5


def pushed(body: IntrinsicBody) -> System:
    """The system of the U under the force on its tip."""
    return System([body], loads=[DeadForce(at="u.tip", force=_load)])


def _load(time: jax.Array) -> jax.Array:
    return jnp.asarray(FORCE) * jnp.maximum(0.0, 1.0 - jnp.abs(time / (DURATION / 2) - 1.0))


def flying_u(quick: bool) -> Row:
    """Results of the U, by number of stations where it varies.

    com_error : `_centre_error`, m;   order : its order of convergence with the number of segments
    residualised : `_residual_rows`;   stable_steps : `_stable_steps`
    stiffness : `stiffness_pattern` of the line with the most stations, and of beam elements
    eigenvalues : `eigenvalue_differences`
    flight : `_shown` for the line with the most stations, and for beam elements
    """
    n_leg = 8 if quick else 12
    solid = solid_u(n_leg)
    bodies = {n: on_stations(solid, n) for n in ((7, 13) if quick else (7, 13, 19, 25, 31))}
    flights = {n: _flown(body, RungeKutta4()) for n, body in bodies.items()}
    errors = {str(n): _centre_error(body, flights[n]) for n, body in bodies.items()}
    order = float(-np.polyfit(np.log([n - 1 for n in bodies]), np.log(list(errors.values())), 1)[0])
    finest = list(bodies)[-1]
    beams = of_beam_elements(bodies[finest].line, n_leg)
    return {
        "com_error": errors,
        "order": order,
        "residualised": _residual_rows(bodies[13], flights[13], quick),
        "stable_steps": _stable_steps(bodies[13]),
        "stiffness": {
            "stations": stiffness_pattern(bodies[finest].line),
            "beam_elements": stiffness_pattern(beams.line),
        },
        "eigenvalues": eigenvalue_differences(solid, bodies, beams),
        "flight": {
            "stations": _shown(flights[finest]),
            "beam_elements": _shown(_flown(beams, RungeKutta4())),
        },
    }


def _shown(flight: Flight) -> Row:
    """Positions of the loaded tip (t, 3), and of all stations (k, n, 3) at the k times of the snapshots."""
    times, (_, places) = flight
    shown = slice(None, None, N_OUTPUTS // N_SNAPSHOTS)
    return {
        "t": times.round(9).tolist(),
        "tip": places[:, 0].round(4).tolist(),
        "snapshot_t": times[shown].round(9).tolist(),
        "snapshots": places[shown].round(3).tolist(),
    }


def _stable_steps(body: IntrinsicBody) -> list[dict[str, float]]:
    """Longest stable Runge-Kutta step, s, by the number of retained modes, rigid ones included."""
    return [
        {"kept": kept, "dt_max": _longest_step(body, kept)}
        for kept in range(12, len(body.modes.omega) + 1, 6)
    ]


def _longest_step(body: IntrinsicBody, kept: int | None = None) -> float:
    """Longest stable step, s, without damping, for the given number of lowest modes; None: all modes."""
    omega = body.modes.omega[:kept]
    return largest_stable_step(omega, 0 * omega, 0 * omega)


def _centre_error(body: IntrinsicBody, flight: Flight) -> float:
    """Distance of the centre of mass from its exact path under the force: root mean square over time, m."""
    times, (rotations, places) = flight
    masses = body.line.station_masses
    assert masses is not None
    # The mass of a station has an offset: M = [[m, -m c~], [m c~, ..]].
    offsets = np.stack([masses[:, 2, 4], masses[:, 0, 5], masses[:, 1, 3]], axis=1) * [-1, -1, -1]
    weighted = masses[:, 0, 0] @ places + np.einsum("tnij,nj->ti", rotations, offsets)
    centre = weighted / body.mass
    exact = centre[0] + _distance(times)[:, None] * FORCE / body.mass
    return float(np.sqrt(np.mean(np.sum((centre - exact) ** 2, axis=1))))


def _distance(times: np.ndarray) -> np.ndarray:
    """Unit triangle of the load, integrated twice over time, s^2."""
    half = DURATION / 2
    early = times**3 / (6 * half)
    t = times - half
    late = half**2 / 6 + half * t / 2 + t**2 / 2 - t**3 / (6 * half)
    return np.where(times <= half, early, late)


def _flown(body: IntrinsicBody, rule: Rule, *, kept: int | None = None) -> Flight:
    step = min(0.8 * _longest_step(body, kept), 0.02)
    run = Run(DURATION, DURATION / N_OUTPUTS, step=FixedStep(step), method=rule)
    solution = simulate(pushed(body), run)
    return solution.times, body.places(solution.bodies["u"])


def _lowest_alone(body: IntrinsicBody, kept: int) -> IntrinsicBody:
    """The body with its lowest modes, rigid ones included, without second-order modes, as in the paper."""
    e = kept - body.modes.n_rigid
    own = body.expansion
    expansion = replace(own, modes=own.modes[..., :e], warping=own.warping[..., :e])
    return replace(body, modes=body.modes.truncated(kept), expansion=expansion)


def _residual_rows(body: IntrinsicBody, flight: Flight, quick: bool) -> list[Row]:
    """Errors of the positions of all stations with truncated and with residual modes: root mean squares, m.

    flight : result of `_flown` with all modes, the reference
    """
    _, (_, whole) = flight
    rows = []
    for kept in (24,) if quick else (18, 30, 48):
        _, (_, truncated) = _flown(_lowest_alone(body, kept), RungeKutta4())
        _, (_, residual) = _flown(body, ResidualRungeKutta4(kept), kept=kept)
        rows.append(
            {
                "kept": kept,
                "truncated_error": _rms(truncated - whole),
                "residualised_error": _rms(residual - whole),
                "dt_max": _longest_step(body, kept),
            }
        )
    return rows


def _rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(difference**2, axis=-1))))


def energy_drift(quick: bool) -> float:
    """Largest relative change of the energy of an unloaded U that vibrates and rotates, by Runge-Kutta."""
    body = on_stations(solid_u(6), 7, 24)
    rates = np.zeros(body.n_coordinates)
    rates[:4] = 20.0
    placed = Placed(body, coordinate_rates=rates, angular_velocity=np.array([0.5, 0.2, 1.0]))
    step = 0.1 * _longest_step(body)
    duration = (100 if quick else 1000) * step
    run = Run(duration, duration / 20, step=FixedStep(step), method=RungeKutta4())
    motion = simulate(System([placed]), run).motion("u", IntrinsicMotion)
    energy = np.sum(motion.rates**2, axis=1) + np.sum(body.forces_of(motion.coordinates) ** 2, axis=1)
    return float(np.abs(energy / energy[0] - 1).max())
