"""A batch of intrinsic bodies compared with single runs of the same cases: time per step and case.

    JAX_NUM_CPU_DEVICES=2 OMP_NUM_THREADS=1 python benchmarks/batch_of_lines.py [repetitions]

The cantilever of `supple benchmark intrinsic` (24 stations) under follower forces at its tip, without and
with gravity, integrated by the Runge-Kutta rule: a batch of 256 cases and single runs of some of them,
alternating.
"""

from __future__ import annotations

import sys
from time import perf_counter, process_time
from typing import Any

import jax
import numpy as np
from measure import keep

from supple.integrate import FixedStep, Run, RungeKutta4
from supple.machine import Fixed, FollowerForce, Placed, System
from supple.methods.intrinsic import CLAMPED, IntrinsicBody, intrinsic_body
from supple.simulation import simulate, simulate_batch
from supple_benchmarks.intrinsic.beams import beam_line

N_CASES, ALONE = 256, 4
N_STEPS = 1000


def main(repetitions: int) -> None:
    rows = [
        row(body(n_modes), gravity, chunk, repetitions)
        for n_modes, gravity, chunk in (
            (50, 0.0, 128),
            (50, 0.0, 64),
            (100, 0.0, 128),
            (50, 9.81, 128),
        )
    ]
    print(*rows, sep="\n", flush=True)
    keep("batch_of_lines", rows, devices=len(jax.devices()))


def body(n_modes: int) -> IntrinsicBody:
    """The clamped beam."""
    points = np.linspace(0, 1, 24)[:, None] * np.eye(3)[0]
    line = beam_line("beam", points, axial=1e5, bending=1.0, torsion=1.0, mass=1.0, radius=0.03)
    return intrinsic_body(line, CLAMPED, n_modes)


def machine(beam: IntrinsicBody, force: float, gravity: float) -> System:
    """The beam clamped at its root, under a tip force and gravity."""
    clamp = Fixed(first="ground", second="beam.root")
    push = FollowerForce(first="beam.tip", force=(0.0, 0.1 * force, force))
    return System([Placed(beam)], [clamp], [push], gravity=(0.0, 0.0, -gravity))


def row(beam: IntrinsicBody, gravity: float, chunk: int, repetitions: int) -> dict[str, Any]:
    """Microseconds per step and case, the minimum over the repetitions, and the ratio in each repetition."""
    step = 2.0 / beam.modes.omega.max()
    run = Run(N_STEPS * step, N_STEPS * step, step=FixedStep(step), method=RungeKutta4())
    cases = [machine(beam, force, gravity) for force in np.linspace(0.1, 2.0, N_CASES)]
    alone = [measured(lambda: [simulate(each, run) for each in cases[:ALONE]], ALONE)]  # compiles
    together = [measured(lambda: simulate_batch(cases, run, chunk=chunk), N_CASES)]
    marching = [np.inf]
    for _ in range(repetitions):
        alone.append(measured(lambda: [simulate(each, run) for each in cases[:ALONE]], ALONE))
        together.append(measured(lambda: simulate_batch(cases, run, chunk=chunk), N_CASES))
        marching.append(simulate_batch(cases, run, chunk=chunk).seconds / N_CASES / N_STEPS * 1e6)
    one, many = np.array(alone[1:]), np.array(together[1:])
    return {
        "modes": beam.n_coordinates,
        "gravity": gravity,
        "chunk": chunk,
        "alone, us wall": one[:, 0].min(),
        "batch, us wall": many[:, 0].min(),
        "batch, us wall of the march": min(marching),
        "alone, us processor": one[:, 1].min(),
        "batch, us processor": many[:, 1].min(),
        "ratio of wall times": (one[:, 0] / many[:, 0]).tolist(),
    }


def measured(work: Any, n: int) -> tuple[float, float]:
    """Wall and processor time, microseconds per step, of n cases."""
    wall, processor = perf_counter(), process_time()
    work()
    scale = 1e6 / n / N_STEPS
    return scale * (perf_counter() - wall), scale * (process_time() - processor)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
