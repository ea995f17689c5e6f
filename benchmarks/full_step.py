"""A nonlinear step of the full blade: frozen symmetric factor or exact tangent of every iterate.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/full_step.py [--quick] [--json FILE]
The 61.5 m blade of the published benchmark, Green-Lagrange, in a mean-axis frame, at the start of its spin-up
and at the rated speed, which it reaches in two seconds here; `--quick` uses a coarse mesh.
Two iterations start from the same state and are measured in one run, in processor time: Newton's method, with
an LU factor of the unsymmetric tangent at every iterate, and the modified Newton method. The states of both
are compared with those for a thousandth of the tolerance. Target: a third of the time, differences below
1e-6.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from measure import RESULTS, measured

from supple.body import FullBody
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Solution, StepRule, Tolerances
from supple.integrate.run import run as march_through
from supple.machine import System
from supple.methods.floating import FullEngine
from supple.methods.floating.full.implicit_step import ImplicitStep
from supple.methods.floating.full.newton import NewtonIteration, exact_newton, modified_newton
from supple.storage import write_json
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.computer import describe_computer
from supple_benchmarks.nrel5mw_blade import (
    BODY,
    COARSE_GRID,
    RATED,
    Blade,
    blade_damping,
    root_clamped_frequencies,
)

STEP, RESIDUAL, N_STEPS, RUN_UP = 0.02, 1e-6, 10, 2.0
ITERATIONS: dict[str, NewtonIteration] = {"exact": exact_newton, "kept": modified_newton}
COMPARED = ("position", "rotation", "coordinates")


def run_options(start: float, steps: int, residual: float = RESIDUAL) -> Run:
    """A run with steps of the published size."""
    tolerances = Tolerances(residual=residual)
    return Run(steps * STEP, STEP, step=FixedStep(STEP), tolerances=tolerances, start=start)


def timed(system: System, run: Run, iteration: NewtonIteration, last: Solution) -> tuple[float, Solution]:
    """Processor seconds of a march from a state, and its motion."""
    engine = FullEngine(system, run, iteration)
    state = engine.resumed(last)
    began = process_time()
    leg = engine.march(state, run.times[1:])
    return process_time() - began, engine.solution(leg)


def apart(one: Solution, other: Solution) -> float:
    """Largest difference of positions, rotations and coordinates, each relative to its largest value."""
    first, second = one.bodies[BODY], other.bodies[BODY]
    pairs = [(getattr(first, name), getattr(second, name)) for name in COMPARED]
    return max(float(np.abs(own - others).max() / np.abs(others).max()) for own, others in pairs)


def rows_of(name: str, system: System, last: Solution) -> list[dict[str, Any]]:
    """Rows of both iterations from one state, without the first step, which includes compilation."""
    start = float(last.times[-1])
    fresh = replace(last, engine_state={k: v for k, v in last.engine_state.items() if k != "kept_tangent"})
    for iteration in ITERATIONS.values():
        timed(system, run_options(start, 1), iteration, fresh)
    found = {
        label: timed(system, run_options(start, N_STEPS), iteration, fresh)
        for label, iteration in ITERATIONS.items()
    }
    _, tight = timed(system, run_options(start, N_STEPS, 1e-3 * RESIDUAL), exact_newton, fresh)
    rows = []
    for label, (seconds, solution) in found.items():
        cost = solution.statistics
        rows.append(
            {
                "case": name,
                "tangent": label,
                "cpu s / step": seconds / N_STEPS,
                "iterations / step": cost.iterations / N_STEPS,
                "factors / step": cost.factorizations / N_STEPS,
                "residual left by an iteration": cost.contraction,
                "times faster": found["exact"][0] / seconds,
                "states from those of a tight tolerance, of the largest": apart(solution, tight),
            }
        )
    return rows


def parts_of(system: System, last: Solution) -> list[dict[str, Any]]:
    """Cost of the parts of a step, measured separately."""
    run = run_options(float(last.times[-1]), 1)
    engine = FullEngine(system, run)
    state = engine.resumed(last).state
    rule = StepRule(GeneralizedAlpha().coefficients, STEP)
    step = ImplicitStep(engine.machine, state, STEP, rule, run.tolerances)
    at = step.at(state.unknowns)
    kept = step.tangent(at, symmetric=True)
    work = {
        "evaluation of the equations": lambda: step.at(state.unknowns),
        "symmetric tangent, assembled and factored": lambda: step.tangent(at, symmetric=True),
        "iteration with a kept tangent": lambda: step.corrected(at, kept, trusted=True),
        "iteration with the exact tangent": lambda: step.corrected(at, None, trusted=True),
    }
    return [{"part": part, **measured(each, repeats=3)[0]} for part, each in work.items()]


def main() -> None:
    arguments = argparse.ArgumentParser(description="A nonlinear step of the blade in full.")
    arguments.add_argument("--quick", action="store_true", help="a coarse mesh")
    arguments.add_argument("--json", type=Path, default=RESULTS / "full_step.json", help="file to write")
    given = arguments.parse_args()
    blade = Blade(COARSE_GRID) if given.quick else Blade()
    case = replace(RATED, start=RUN_UP)
    body = blade.body()
    full = FullBody(body, FRAMES["mean-axis"], blade_damping(root_clamped_frequencies(body)))
    system = blade.system(full, case, blade.loads(case, case.start + 2 * N_STEPS * STEP))
    rest = run_options(0.0, N_STEPS)
    began = march_through(FullEngine(system, rest), rest.times)
    rows = rows_of("spin-up", system, began)
    up = run_options(0.0, round(case.start / STEP))
    at_speed = march_through(FullEngine(system, up), up.times)
    rows += rows_of("rated speed", system, at_speed)
    parts = parts_of(system, at_speed)
    for row in rows + parts:
        print(*(f"{key}: {value:.3g}" if isinstance(value, float) else value for key, value in row.items()))
    machine = describe_computer() | {"freedoms": body.n}
    print(f"written to {write_json(given.json, {'rows': rows, 'parts': parts, 'machine': machine})}")


if __name__ == "__main__":
    main()
