"""Online cost of the compiled step: microseconds per Newton iteration and per step, one case and batches.

Run with one thread: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/online.py
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from measure import keep

from supple.benchmark.rotating_beam import BODY, ROOT, RotatingBeam, spin_up_load
from supple.benchmark.spin_up import SpinUp
from supple.body import MeanAxisFrame, NodalFixedFrame
from supple.fem import GREEN_LAGRANGE
from supple.integrate import FixedStep
from supple.multibody import (
    GROUND,
    At,
    Ball,
    DeadForce,
    Placed,
    PrescribedRotation,
    System,
    Table,
    simulate,
    simulate_batch,
)
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    NoDerivatives,
    Rubin,
    StaticLoad,
    reduce,
)

PROBLEM = RotatingBeam()
DURATION, STEP = 20.0, 0.01


def spun_up(body) -> System:
    hinge = PrescribedRotation(first=GROUND, second=At(BODY, ROOT), axis=(0.0, -1.0, 0.0), angle=SpinUp(6.0))
    return System(bodies=(Placed(body),), joints=(hinge,))


def one_case(name: str, system: System) -> dict:
    solution = simulate(system, duration=DURATION, output_step=0.02, step=FixedStep(STEP))
    # The second run finds everything compiled.
    again = simulate(system, duration=DURATION, output_step=0.02, step=FixedStep(STEP)).statistics
    return {
        "case": name,
        "us per iteration": 1e6 * again.seconds / again.iterations,
        "us per step": 1e6 * again.seconds / again.steps,
        "iterations per step": again.iterations / again.steps,
        "compile s": solution.statistics.compile_seconds,
    }


def batch(body, n: int) -> dict:
    tip = [int(node) for node in PROBLEM.mesh().nodes_of("tip_centre")]
    times = np.linspace(0.0, DURATION, 201)
    random = np.random.default_rng(1)

    def case() -> System:
        force = np.zeros((times.size, 3))
        force[:, 2] = 5.0 * random.standard_normal(times.size)
        system = spun_up(body)
        return System(
            bodies=system.bodies,
            joints=system.joints,
            loads=(DeadForce(body=BODY, at=tip, force=Table(times, force)),),
        )

    done = simulate_batch(
        [case() for _ in range(n)], duration=DURATION, output_step=0.1, step=FixedStep(STEP), chunk=64
    ).check()
    iterations = sum(solution.statistics.iterations for solution in done.solutions)
    return {
        "case": f"batch of {n}, r = {body.r}",
        "us per iteration": 1e6 * done.seconds / iterations,
        "us per step": 1e6 * done.seconds / sum(s.statistics.steps for s in done.solutions),
        "compile s": done.compile_seconds,
        "cases per s": n / done.seconds,
    }


def main() -> None:
    body = PROBLEM.body(GREEN_LAGRANGE)
    weights = AmplitudeProduct(StaticLoad(spin_up_load(body)))
    nonlinear = [
        reduce(
            body,
            NodalFixedFrame(ROOT),
            CraigBampton(n_modes=n_linear),
            derivatives=CompressedDerivatives(n_added, weights=weights),
        )
        for n_linear, n_added in ((5, 5), (12, 13), (20, 20))
    ]
    rows = [one_case(f"nonlinear, prescribed rotation, r = {b.r}", spun_up(b)) for b in nonlinear]
    linear = reduce(body.linearized(), MeanAxisFrame(), Rubin(n_columns=12), derivatives=NoDerivatives())
    hung = System(
        bodies=(Placed(linear, rotation=(0.0, np.pi / 2, 0.0)),),
        joints=(Ball(first=GROUND, second=At(BODY, ROOT)),),
        gravity=(0.0, 0.0, -9.81),
    )
    rows.append(one_case("12 linear modes, ball joint", hung))
    rows += [batch(nonlinear[1], n) for n in (1, 64)]
    for before, after in pairwise(rows[-2:]):
        after["gain of batching"] = before["us per iteration"] / after["us per iteration"]
    keep("online", rows)


if __name__ == "__main__":
    main()
