"""Online cost of the compiled march: microseconds per Newton iteration and per step, one case and batches.

Run with one thread: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/online.py
Single cases are timed without Python (minimum processor time of several runs of thousands of steps), batches
with all overhead. With the tight tolerance a step has more iterations, so that its fixed cost counts less.
"""

from __future__ import annotations

from dataclasses import replace
from time import process_time
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from measure import keep

from supple.body import FlexibleBody, MeanAxisFrame, RayleighDamping
from supple.fem import GREEN_LAGRANGE
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    Ball,
    DeadForce,
    Placed,
    PrescribedRotation,
    System,
    Table,
)
from supple.machine.laws.spin_up import SpinUp
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.programs import COMPILED_MARCH
from supple.reduction import (
    CompressedDerivatives,
    NoDerivatives,
    NoLoads,
    NormalModes,
    ReducedBody,
    Rubin,
    reduce,
)
from supple.simulation import simulate_batch
from supple_benchmarks.rotating_beam.problem import BODY, ROOT, RotatingBeam

PROBLEM = RotatingBeam()
STEP, N_STEPS, REPEATS = 5e-3, 2000, 5
SIZES = {10: (6, 4), 25: (10, 15), 40: (15, 25), 60: (20, 40)}
"""Columns: linear and compressed derivatives."""
TARGETS = {25: 100.0}
"""us per iteration"""
DAMPING = RayleighDamping(alpha=0.0, beta=1e-4)


def spun_up(body: ReducedBody) -> System:
    hinge = PrescribedRotation(first=GROUND, second=At(BODY, ROOT), axis=(0.0, -1.0, 0.0), angle=SpinUp(6.0))
    return System(bodies=(Placed(body),), joints=(hinge,))


def hung(body: FlexibleBody) -> System:
    linear = reduce(
        body.linearized(), MeanAxisFrame(), NormalModes(12), derivatives=NoDerivatives(), loads=NoLoads
    )
    ball = Ball(first=GROUND, second=At(BODY, ROOT))
    return System(bodies=(Placed(linear),), joints=(ball,), gravity=(0.0, 0.0, -9.81))


def march_cost(name: str, system: System, *, step: float, tolerance: float = 1e-6) -> dict[str, Any]:
    began = process_time()
    model, state = initial_state(system, 0.0, step)
    started = process_time()
    settings = controls(
        Run(1.0, 1.0, step=FixedStep(step), method=GeneralizedAlpha(0.8), tolerances=Tolerances(tolerance))
    )
    arguments = jax.device_put((model, settings, state, jnp.asarray(step * np.arange(1, N_STEPS + 1))))
    program = COMPILED_MARCH.compiled(*arguments)
    compiled = process_time()
    seconds = []
    for _ in range(REPEATS):
        mark = process_time()
        final, _ = jax.block_until_ready(program(*arguments))
        seconds.append(process_time() - mark)
    steps, iterations = int(final.steps), int(final.iterations)
    return {
        "case": name,
        "tolerance": tolerance,
        "us / iteration": 1e6 * min(seconds) / iterations,
        "us / step": 1e6 * min(seconds) / steps,
        "iterations / step": iterations / steps,
        "start s": started - began,
        "compile s": compiled - started,
    }


def in_one_block(body: ReducedBody) -> ReducedBody:
    """The same body without use of symmetry planes: its quartic tensor is one block."""
    whole = replace(body)
    vars(whole)["quartic_blocks"] = whole.quartic
    return whole


def batch_cost(body: ReducedBody, n: int) -> dict[str, Any]:
    """A tip force of random history on the spun-up beam, different in every case."""
    tip = [int(node) for node in PROBLEM.mesh().nodes_of("tip_centre")]
    duration = 1.0
    times = np.linspace(0.0, duration, 21)
    random = np.random.default_rng(1)

    system = spun_up(body)

    def case() -> System:
        force = np.zeros((times.size, 3))
        force[:, 2] = 5.0 * random.standard_normal(times.size)
        return replace(system, loads=(DeadForce(body=BODY, at=tip, force=Table(times, force)),))

    cases = [case() for _ in range(n)]
    run = Run(duration=duration, output_step=0.05, step=FixedStep(STEP))
    done = min((simulate_batch(cases, run).check() for _ in range(3)), key=lambda batch: batch.seconds)
    brief = Run(duration=STEP, output_step=STEP, step=FixedStep(STEP))
    simulate_batch(cases, brief)
    began = process_time()
    simulate_batch(cases, brief)
    around = process_time() - began
    steps = sum(solution.statistics.steps for solution in done.solutions)
    iterations = sum(solution.statistics.iterations for solution in done.solutions)
    return {
        "case": f"batch of {n}, r = {body.r}",
        "tolerance": 1e-6,
        "us / iteration": 1e6 * done.seconds / iterations,
        "us / step": 1e6 * done.seconds / steps,
        "iterations / step": iterations / steps,
        "cases / s": n / done.seconds,
        "one step, start and results ms / case": 1e3 * around / n,
    }


def main() -> None:
    body = PROBLEM.body(GREEN_LAGRANGE)
    rows = []
    bodies = {}
    for r, (n_linear, n_added) in SIZES.items():
        bodies[r] = reduce(
            body,
            MeanAxisFrame(),
            Rubin(n_columns=n_linear),
            derivatives=CompressedDerivatives(n_added),
            loads=NoLoads,
        )
        system = spun_up(bodies[r])
        for tolerance in (1e-6, 1e-9):
            cost = march_cost(
                f"prescribed rotation, nonlinear, r = {bodies[r].r}", system, step=STEP, tolerance=tolerance
            )
            rows.append(cost | ({"target": TARGETS[r]} if r in TARGETS else {}))
        for words, damping in (("by strain rate", DAMPING), ("linearly", DAMPING.linearized())):
            damped = reduce(
                body,
                MeanAxisFrame(),
                Rubin(n_columns=n_linear),
                derivatives=CompressedDerivatives(n_added),
                damping=damping,
                loads=NoLoads,
            )
            rows.append(march_cost(f"the same, damped {words}, r = {damped.r}", spun_up(damped), step=STEP))
        whole = spun_up(in_one_block(bodies[r]))
        rows.append(march_cost(f"the same, no symmetry used, r = {bodies[r].r}", whole, step=STEP))
    for tolerance in (1e-6, 1e-9):
        cost = march_cost("ball joint, 12 linear modes", hung(body), step=1e-3, tolerance=tolerance)
        rows.append(cost | {"target": 20.0})
    rows += [batch_cost(bodies[25], n) for n in (1, 64)]
    keep("online", rows)


if __name__ == "__main__":
    main()
