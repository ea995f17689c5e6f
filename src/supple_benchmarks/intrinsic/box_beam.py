"""The box beam of [Wang2015] 5.1: a shell model on stations, its frequencies and a large free vibration.

The table of its section is lost in the text that we have. Chosen: length 20, walls 1.0 by 0.1 between
mid-surfaces, 0.01 thick, E = 1e6, Poisson's ratio 0.3, density 1, in consistent units. The first axial mode
lies among those of the walls, and is looked for there.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from scipy.sparse.linalg import eigsh

from supple.algebra import lowest_modes
from supple.body import AveragingInterface, FlexibleBody, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, RungeKutta4
from supple.intrinsic import IntrinsicBody, LoadPath, condense
from supple.machine import Fixed, Placed, System
from supple.mesh import box_beam as box_mesh
from supple.simulation import simulate
from supple_benchmarks.intrinsic.box_against_shells import box_against_shells, parabolic_velocity

__all__ = ["box_beam"]

LENGTH, WIDTH, HEIGHT, WALL = 20.0, 1.0, 0.1, 0.01
E, NU, DENSITY = 1e6, 0.3, 1.0
N_FREQUENCIES = 10
KINDS = ("axial", "chordwise", "flapwise", "torsion")
CANTILEVER = (1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349)
"""Roots of cos x cosh x = -1; the next lie at odd multiples of pi / 2."""
NEAR = 8
"""Frequencies looked at about the axial one, which lies among those of the walls."""


def box_beam(quick: bool) -> dict[str, Any]:
    """Frequencies of stations, shells and slender beams, rad/s, with their kind; free vibrations."""
    coarse, tip_nodes = meshed(40, 1)
    shells = coarse if quick else meshed(120, 2)[0]
    held = shells.interface("root").motion
    exact = np.sqrt(lowest_modes(shells.stiffness, shells.mass, N_FREQUENCIES, constraint=held).values)
    body = condense(shells, LoadPath("root", "tip", 21 if quick else 41), n_modes=35 if quick else 60)
    found = body.modes.omega[:N_FREQUENCIES]
    kinds = [KINDS[int(np.argmax(column))] for column in np.abs(body.modes.velocities[-1, :4]).T]
    axial = kinds.index("axial")
    times, tip, _ = _vibration(body, 3.0, 0.5 if quick else 2.5)
    pairs = [*zip(kinds, found, exact, strict=False), _axial(shells, body.modes.omega[axial])]
    ranks = Counter()
    rows = []
    for kind, own, of_shells in pairs:
        beam = slender_beam(kind, ranks[kind])
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
        "tip": {"t": times.tolist(), "u": tip.tolist()},
        "against_shells": list(box_against_shells(coarse, tip_nodes, quick)),
        "small_from_linear": _from_linear(body, 0.5 if quick else 2.5),
    }


def meshed(n_along: int, n_high: int) -> tuple[FlexibleBody, np.ndarray]:
    """The box of shells, and the nodes of its tip."""
    mesh = box_mesh(LENGTH, WIDTH, HEIGHT, n_along, 4, n_high)
    model = shell_model(mesh, HomogeneousSection(Isotropic(E, NU, DENSITY), WALL))
    ends = [RigidInterface("root", "root"), AveragingInterface("tip", "tip")]
    return flexible_body("box", model, ends), mesh.nodes_of("tip")


def slender_beam(kind: str, rank: int) -> float:
    """A frequency of the clamped beam, its walls thin: Euler and Bernoulli's, Bredt's in torsion, rad/s."""
    area = 2 * (WIDTH + HEIGHT) * WALL
    flap = WALL * (WIDTH * HEIGHT**2 / 2 + HEIGHT**3 / 6)
    chord = WALL * (HEIGHT * WIDTH**2 / 2 + WIDTH**3 / 6)
    if kind in ("axial", "torsion"):
        twist = 2 * (WIDTH * HEIGHT) ** 2 * WALL / (WIDTH + HEIGHT) / (2 * (1 + NU) * (flap + chord))
        speed = np.sqrt(E / DENSITY * (1 if kind == "axial" else twist))
        return float((2 * rank + 1) * np.pi / 2 / LENGTH * speed)
    root = CANTILEVER[rank] if rank < len(CANTILEVER) else (2 * rank + 1) * np.pi / 2
    inertia = flap if kind == "flapwise" else chord
    return float((root / LENGTH) ** 2 * np.sqrt(E * inertia / (DENSITY * area)))


def _axial(shells: FlexibleBody, stations: float) -> tuple[str, float, float]:
    """The first axial frequency on stations and of the shells: of those nearby the one that moves the tip."""
    held = shells.interface("root").motion.tocsr().indices  # the six freedoms of the tie
    free = np.setdiff1d(np.arange(shells.n), held)
    K, M = (matrix.tocsc()[free][:, free] for matrix in (shells.stiffness, shells.mass))
    values, shapes = eigsh(K, NEAR, M, sigma=stations**2)
    along = np.abs(shells.interface("tip").motion.tocsc()[0, free] @ shapes)
    return "axial", stations, float(np.sqrt(values[np.argmax(along)]))


def _from_linear(body: IntrinsicBody, duration: float) -> float:
    """How far a vibration of a thousandth of the velocity is from the linear one, of its largest."""
    times, tip, rates = _vibration(body, 3e-3, duration)
    omega = body.modes.omega
    linear = (rates / omega * np.sin(np.outer(times, omega))) @ body.modes.velocities[-1, :3].T
    return float(np.abs(tip - linear).max() / np.abs(linear).max())


def _vibration(
    body: IntrinsicBody, speed: float, duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Free vibration from the velocity (0, 1, 1) speed (s / L)^2: displacement of the tip (t, 3), and what
    amplitudes it starts with."""
    rates = parabolic_velocity(body, speed)
    system = System([Placed(body, coordinate_rates=rates)], [Fixed(first="ground", second="box.root")])
    step = min(2.0 / body.modes.omega.max(), 0.01)
    run = Run(duration, duration / 25, step=FixedStep(step), method=RungeKutta4())
    solution = simulate(system, run)
    tip = body.places(solution.bodies["box"])[1][:, -1]
    return solution.times, tip - body.line.tree.points[-1], rates
