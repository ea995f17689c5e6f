"""The box beam of [Wang2015] 5.1: a shell model condensed on stations, its frequencies, a large vibration.

The first axial frequency of the shells lies among those of wall modes; a separate search finds it.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import eigsh

from supple.body import AveragingInterface, FlexibleBody, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, RungeKutta4
from supple.machine import Fixed, Placed, System
from supple.mesh import box_beam as box_mesh
from supple.methods.intrinsic import IntrinsicBody, IntrinsicMotion, LoadPath, condense
from supple.simulation import simulate
from supple_benchmarks.intrinsic.box_against_shells import box_against_shells, parabolic_velocity
from supple_benchmarks.intrinsic.box_modes import box_modes, kinds_of
from supple_benchmarks.intrinsic.slender_box import (
    DENSITY,
    HEIGHT,
    LENGTH,
    NU,
    WALL,
    WIDTH,
    E,
    slender_frequency,
)
from supple_benchmarks.table import Row

__all__ = ["box_beam"]

N_FREQUENCIES = 10
SPEED = 3.0
"""Initial velocity of the tip along y, and also along z; it causes a large vibration."""
N_AMPLITUDES = 6
N_OUTPUTS = 100
NEAR = 8
"""Number of shell frequencies computed near the first axial frequency on stations."""


def box_beam(quick: bool) -> Row:
    """Results of the box beam.

    frequencies : by kind, rad/s: on stations, of the shells, of a slender beam; error : stations / shells - 1
    modes : `box_modes`;   tip, amplitudes : `large_vibration`;   against_shells : `box_against_shells`
    small_from_linear : `_from_linear`
    """
    coarse, tip_nodes = meshed(40, 1)
    shells = coarse if quick else meshed(120, 2)[0]
    held = shells.interface("root").motion
    exact = np.sqrt(shells.lowest_modes(N_FREQUENCIES, held).values)
    body = box_on_stations(shells, quick)
    found = body.modes.omega[:N_FREQUENCIES]
    kinds = kinds_of(body)
    axial = kinds.index("axial")
    pairs = [*zip(kinds, found, exact, strict=False), _axial(shells, body.modes.omega[axial])]
    ranks = Counter()
    rows = []
    for kind, own, of_shells in pairs:
        beam = slender_frequency(kind, ranks[kind])
        ranks[kind] += 1
        rows.append(
            {
                "kind": kind,
                "stations": float(own),
                "shells": float(of_shells),
                "error": float(own / of_shells - 1),
                "beam": beam,
            }
        )
    return {
        "frequencies": rows,
        "modes": box_modes(body),
        **large_vibration(body, quick),
        "against_shells": list(box_against_shells(coarse, tip_nodes, quick)),
        "small_from_linear": _from_linear(body, 0.5 if quick else 2.5),
    }


def meshed(n_along: int, n_high: int) -> tuple[FlexibleBody, np.ndarray]:
    """The shell model of the box, and the node numbers of its tip."""
    mesh = box_mesh(LENGTH, WIDTH, HEIGHT, n_along, 4, n_high)
    model = shell_model(mesh, HomogeneousSection(Isotropic(E, NU, DENSITY), WALL))
    ends = [RigidInterface("root", "root"), AveragingInterface("tip", "tip")]
    return flexible_body("box", model, ends), mesh.nodes_of("tip")


def box_on_stations(shells: FlexibleBody, quick: bool) -> IntrinsicBody:
    """The box condensed on its stations, clamped at its root."""
    return condense(shells, LoadPath("root", "tip", 21 if quick else 41), n_modes=35 if quick else 60)


def large_vibration(body: IntrinsicBody, quick: bool) -> Row:
    """Displacement of the tip, and amplitudes q_2 of the modes with the largest q_2, over time."""
    vibration = _vibration(body, SPEED, 0.5 if quick else 2.5)
    q2 = body.forces_of(vibration.coordinates)
    highest = np.sort(np.argsort(-np.abs(q2).max(axis=0))[:N_AMPLITUDES])
    kinds = kinds_of(body)
    amplitudes = [{"mode": int(j) + 1, "kind": kinds[j], "q2": q2[:, j].round(5).tolist()} for j in highest]
    tip = {"t": vibration.times.round(9).tolist(), "u": vibration.tip.round(6).tolist()}
    return {"tip": tip, "amplitudes": amplitudes}


def _axial(shells: FlexibleBody, stations: float) -> tuple[str, float, float]:
    """Kind, first axial frequency on stations, and that of the shells, rad/s.

    Of the `NEAR` shell modes next to the frequency on stations, the mode with the largest axial motion of the
    tip is taken.
    """
    held = shells.interface("root").motion.tocsr().indices  # the six degrees of freedom of the root
    free = np.setdiff1d(np.arange(shells.n), held)
    K, M = (matrix.tocsc()[free][:, free] for matrix in (shells.stiffness, shells.mass))
    values, shapes = eigsh(K, NEAR, M, sigma=stations**2)
    along = np.abs(shells.interface("tip").motion.tocsc()[0, free] @ shapes)
    return "axial", stations, float(np.sqrt(values[np.argmax(along)]))


def _from_linear(body: IntrinsicBody, duration: float) -> float:
    """Largest difference between a small vibration and the linear one, over the largest linear displacement.

    The initial velocity is 1e-3 of `SPEED`.
    """
    speed = 1e-3 * SPEED
    vibration, omega = _vibration(body, speed, duration), body.modes.omega
    amplitudes = parabolic_velocity(body, speed) / omega * np.sin(np.outer(vibration.times, omega))
    linear = amplitudes @ body.modes.velocities[-1, :3].T
    return float(np.abs(vibration.tip - linear).max() / np.abs(linear).max())


class Vibration(NamedTuple):
    """Times (t,), displacement of the tip (t, 3), elastic amplitudes (t, e)."""

    times: np.ndarray
    tip: np.ndarray
    coordinates: np.ndarray


def _vibration(body: IntrinsicBody, speed: float, duration: float) -> Vibration:
    """Free vibration after the initial velocity (0, 1, 1) speed (s / L)^2."""
    rates = parabolic_velocity(body, speed)
    system = System([Placed(body, coordinate_rates=rates)], [Fixed(first="ground", second="box.root")])
    step = min(2.0 / body.modes.omega.max(), 0.01)
    run = Run(duration, duration / N_OUTPUTS, step=FixedStep(step), method=RungeKutta4())
    solution = simulate(system, run)
    motion = solution.motion("box", IntrinsicMotion)
    tip = body.places(motion)[1][:, -1] - body.line.tree.points[-1]
    return Vibration(solution.times, tip, motion.coordinates)
