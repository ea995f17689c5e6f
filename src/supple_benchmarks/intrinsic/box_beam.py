"""The box beam of [Wang2015] 5.1: a shell model on stations, its frequencies and a large free vibration.

The table of its section is lost in the text that we have. Chosen: length 20, walls 1.0 by 0.1 between
mid-surfaces, 0.01 thick, E = 1e6, Poisson's ratio 0.3, density 1, in consistent units.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from supple.algebra import lowest_modes
from supple.body import AveragingInterface, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, RungeKutta4
from supple.intrinsic import LoadPath, condense
from supple.machine import Fixed, Placed, System
from supple.mesh import box_beam as box_mesh
from supple.simulation import simulate

__all__ = ["box_beam"]

LENGTH = 20.0
N_FREQUENCIES = 10
KINDS = ("axial", "chordwise", "flapwise", "torsion")


def box_beam(quick: bool) -> dict[str, Any]:
    """Frequencies of stations and shells, rad/s, with their kind; the path of the tip in a free vibration."""
    mesh = box_mesh(LENGTH, 1.0, 0.1, 40 if quick else 120, 4, 1 if quick else 2)
    model = shell_model(mesh, HomogeneousSection(Isotropic(1e6, 0.3, 1.0), 0.01))
    ends = [RigidInterface("root", "root"), AveragingInterface("tip", "tip")]
    shells = flexible_body("box", model, ends)
    held = shells.interface("root").motion
    exact = np.sqrt(lowest_modes(shells.stiffness, shells.mass, N_FREQUENCIES, constraint=held).values)
    body = condense(shells, LoadPath("root", "tip", 21 if quick else 41), n_modes=20 if quick else 60)
    found = body.modes.omega[:N_FREQUENCIES]
    moved = np.abs(body.modes.velocities[-1, :, :N_FREQUENCIES])
    kinds = [KINDS[int(np.argmax(column))] for column in moved[:4].T]
    times, tip = _vibration(body, 0.5 if quick else 2.5)
    return {
        "frequencies": [
            {"kind": kind, "stations": float(a), "shells": float(b), "error": float(a / b - 1)}
            for kind, a, b in zip(kinds, found, exact, strict=True)
        ],
        "tip": {"t": times.tolist(), "u": tip.tolist()},
    }


def _vibration(body: Any, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Free vibration from the velocity (0, 3, 3) (s / L)^2: displacement of the tip (t, 3)."""
    modes = body.modes
    s = modes.line.tree.points[:, 0] / LENGTH
    velocity = np.zeros((modes.line.n, 6))
    velocity[:, 1:3] = 3 * s[:, None] ** 2
    rates = velocity.ravel() @ modes.momenta.reshape(-1, modes.n_modes)
    system = System([Placed(body, coordinate_rates=rates)], [Fixed(first="ground", second="box.root")])
    step = min(2.0 / modes.omega.max(), 0.01)
    run = Run(duration, duration / 25, step=FixedStep(step), method=RungeKutta4())
    solution = simulate(system, run)
    tip = body.places(solution.bodies["box"])[1][:, -1]
    return solution.times, tip - modes.line.tree.points[-1]
