"""A slender box in its intrinsic modes, in supple and in FENIAX, alternating on one core.

The box beam of [Wang2015] 5.1 in shells is condensed on 25 stations, clamped, and pushed by a follower force
at its tip. Both codes have the same stiffness, mass, stations, number of modes and steps of the classical
Runge-Kutta rule. The results are the processor time per step of the march (median of several runs, without
compilation, modes and recovery of positions), and the largest distance between the two tips.

FENIAX (GPL-3.0; github.com/ACea15/FENIAX) is not a dependency. It needs another version of JAX, and therefore
another environment:

    git clone https://github.com/ACea15/FENIAX
    python -m venv feniax-env && feniax-env/bin/pip install ./FENIAX
    OMP_NUM_THREADS=1 python benchmarks/against_feniax.py --feniax-python feniax-env/bin/python
"""

from __future__ import annotations

import os
import sys
from argparse import ArgumentParser
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from measure import keep
from peer_process import PeerProcess

from supple.integrate import FixedStep, Run, RungeKutta4
from supple.machine import Fixed, FollowerForce, Placed, System
from supple.methods.intrinsic import CondensedLine, IntrinsicBody, LoadPath, condense
from supple.methods.intrinsic.engine import IntrinsicEngine
from supple.methods.intrinsic.line_march import Stepping, compiled_march
from supple.simulation import simulate
from supple_benchmarks.intrinsic.box_beam import meshed

N_STATIONS = 25
FORCE = (0.0, 0.2, 0.5)
"""Rotates the tip by more than two radians within the run."""
DURATION, N_STEPS, N_OUTPUTS = 4.0, 4000, 8


def box(n_modes: int) -> IntrinsicBody:
    """The box on its stations, with its lowest elastic modes only: FENIAX has no second-order modes."""
    shells, _ = meshed(48, 1)
    whole = condense(shells, LoadPath("root", "tip", N_STATIONS))
    fields = whole.expansion
    lowest = replace(fields, modes=fields.modes[..., :n_modes], warping=fields.warping[..., :n_modes])
    return replace(whole, modes=whole.modes.truncated(n_modes), expansion=lowest)


class InSupple:
    """The run in supple."""

    def __init__(self, body: IntrinsicBody) -> None:
        clamp = Fixed(first="ground", second="box.root")
        push = FollowerForce(first="box.tip", force=FORCE)
        system = System([Placed(body)], [clamp], [push])
        run = Run(DURATION, DURATION / N_OUTPUTS, step=FixedStep(DURATION / N_STEPS), method=RungeKutta4())
        solution = simulate(system, run)
        rotations, positions = body.places(solution.bodies["box"])
        self.tip, self.turned = positions[:, -1], rotations[:, -1]
        self._engine = IntrinsicEngine(system, run)
        self._start = self._engine.start(0.0)
        self._cost()  # compiles
        self.costs: list[tuple[float, float]] = []

    def turn(self) -> None:
        """Repeat the march."""
        self.costs.append(self._cost())

    def _cost(self) -> tuple[float, float]:
        began, began_wall = process_time(), perf_counter()
        reached = compiled_march(
            Stepping(self._engine.rule, N_STEPS),
            self._engine.lines,
            self._start,
            np.array([DURATION]),
            self._engine.tolerance,
        )
        reached.time.block_until_ready()
        return process_time() - began, perf_counter() - began_wall


class InFeniax(PeerProcess):
    """The run in FENIAX."""

    def __init__(self, interpreter: Path, line: CondensedLine, n_modes: int) -> None:
        case = {
            "modes": n_modes,
            "stations": line.n,
            "force": FORCE,
            "duration": DURATION,
            "steps": N_STEPS,
            "every": N_STEPS // N_OUTPUTS,
        }
        super().__init__("FENIAX", interpreter, "feniax_run.py", case, lambda at: export(line, at))
        self.tip, self.versions = np.array(self.ready["tip"]), self.ready["versions"]


def export(line: CondensedLine, folder: Path) -> None:
    """Write the matrices without the clamped root, and the stations, in FENIAX's format."""
    np.save(folder / "Ka.npy", line.stiffness[6:, 6:])
    np.save(folder / "Ma.npy", line.mass[6:, 6:])
    rows = [
        f"{x:.17g} {y:.17g} {z:.17g} {number - 1} line" for number, (x, y, z) in enumerate(line.tree.points)
    ]
    (folder / "structuralGrid").write_text("\n".join(rows) + "\n", encoding="utf-8")


def rows_of(interpreter: Path, n_modes: int, repetitions: int) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows with the cost of both codes and the distance of their tips; versions of FENIAX's environment."""
    body = box(n_modes)
    ours, theirs = InSupple(body), InFeniax(interpreter, body.line, n_modes)
    for _ in range(repetitions):
        ours.turn()
        theirs.turn()
    theirs.close()
    apart = float(np.linalg.norm(ours.tip - theirs.tip, axis=1).max())
    moved = float(np.linalg.norm(ours.tip - ours.tip[0], axis=1).max())
    cosine = (np.trace(ours.turned, axis1=1, axis2=2) - 1) / 2
    spent = {code: np.array(each.costs) for code, each in (("supple", ours), ("FENIAX", theirs))}
    rows = [
        {
            "modes": n_modes,
            "stations": N_STATIONS,
            "steps": N_STEPS,
            "code": code,
            "us processor / step": microseconds(median(costs[:, 0])),
            "us wall / step": microseconds(median(costs[:, 1])),
            "of supple's": float(median(costs[:, 0]) / median(spent["supple"][:, 0])),
            "the least, us": microseconds(costs[:, 0].min()),
            "tips apart, m": apart,
            "tip moved, m": moved,
            "tip turned, rad": float(np.arccos(cosine.min())),
        }
        for code, costs in spent.items()
    ]
    return rows, theirs.versions


def microseconds(seconds: float) -> float:
    """Microseconds per step."""
    return 1e6 * float(seconds) / N_STEPS


def main() -> None:
    parser = ArgumentParser(description="supple and FENIAX compared")
    parser.add_argument("--feniax-python", type=Path, help="interpreter of an environment with FENIAX")
    parser.add_argument("--repetitions", type=int, default=5)
    given = parser.parse_args()
    if given.feniax_python is None:
        sys.exit(
            "this comparison needs FENIAX in an environment of its own; give the interpreter by "
            "--feniax-python:\n" + (__doc__ or "").split("environment:\n")[-1]
        )
    rows: list[dict[str, Any]] = []
    versions: dict[str, Any] = {}
    for n_modes in (50, 100):
        found, versions = rows_of(given.feniax_python.absolute(), n_modes, given.repetitions)
        rows += found
    keep("against_feniax", rows, feniax=versions, one_core=True)


if __name__ == "__main__":
    if hasattr(os, "sched_setaffinity"):  # both codes, before either starts threads
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    main()
