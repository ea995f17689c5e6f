"""A machine run with its flexible body unreduced, and reduced to tolerances on its eigenvalues.

Every tolerance gives two bodies: the whole Craig-Bampton basis, and its lowest N_m vibrations as in [Han2020]
(46)-(49), which makes all of one size but drops the static motions of the interface. Beside them stands the
body with its N_m exact modes, which the second kind approaches as the tolerance goes to zero.

Runs that are compared take the same fixed steps, so that errors of time integration, which are larger, drop
out. What the adaptive step costs, and how far integration errors go, is found in runs of the finest body.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.benchmark.flexible_machine import FlexibleMachine
from supple.integrate import AdaptiveStep, FixedStep, Solution, StepControl, Tolerances
from supple.multibody import FullBody, System, balances, joint_gaps
from supple.reduction import (
    CraigBampton,
    ErrorControlled,
    LinearBasisRecipe,
    NoDerivatives,
    NormalModes,
    ReducedBody,
    reduce,
)
from supple.results import simulate_recorded, von_mises_history
from supple.results.node_motion import node_motion

__all__ = ["ADAPTIVE", "APART", "Drift", "MachineRun", "PointHistory", "Separation", "Study", "run_study"]

Array = NDArray[np.float64]
Announce = Callable[[str], Callable[[float], None]]
"""Called with the name of a run about to start; gives the callback for its progress."""

ADAPTIVE = AdaptiveStep(first=1e-6, largest=1e-2, tolerance=1e-6)
"""First and largest step of [Han2020]."""
NEWTON = Tolerances(residual=1e-8)
APART = 0.01
"""Two runs are apart when node A differs by this part of the machine's size."""


@dataclass(frozen=True, eq=False)
class PointHistory:
    """What node A does: position, velocity, acceleration (t, 3), von Mises stress and strain (t,)."""

    times: Array
    position: Array
    velocity: Array
    acceleration: Array
    stress: Array
    strain: Array


class Drift(NamedTuple):
    """What a run of rigid and reduced bodies should have kept, and did not."""

    energy: float
    """Largest change of the energy not put in from outside, over the largest kinetic energy."""
    joints: float
    """Largest constraint equation, m or rad."""


@dataclass(frozen=True, eq=False)
class MachineRun:
    """One simulation.

    kind : "unreduced", "whole basis", "modal coordinates" or "exact modes"
    tolerance : of the eigenvalues; None where none was asked for      modes : fixed-interface modes, N_d
    """

    kind: str
    tolerance: float | None
    modes: int | None
    body: FullBody | ReducedBody
    system: System
    solution: Solution
    point: PointHistory
    drift: Drift | None = None
    offline_seconds: float = 0.0


@dataclass(frozen=True, eq=False)
class Separation:
    """How two runs of one body with other steps part: distance of node A over time, and when they are apart.

    coarse, fine : the steps, in words     time : s, from which on the distance is above 1 % of the machine's
        size, or None     statistics : of both
    """

    coarse: str
    fine: str
    times: Array
    distance: Array
    time: float | None
    solutions: tuple[Solution, Solution]


@dataclass(frozen=True, eq=False)
class Study:
    """All that is known so far."""

    machine: FlexibleMachine
    reference: MachineRun
    runs: tuple[MachineRun, ...] = ()
    separations: tuple[Separation, ...] = ()

    @property
    def compared_until(self) -> float:
        """The time up to which motions are compared: when chaos takes over, or the end."""
        apart = [each.time for each in self.separations if each.time is not None]
        return min(apart, default=float(self.reference.point.times[-1]))

    def of_kind(self, kind: str) -> list[MachineRun]:
        """The reduced runs of one kind, the loosest tolerance first."""
        return [run for run in self.runs if run.kind == kind]


def run_study(
    machine: FlexibleMachine, folder: Path, announce: Announce, tolerances: tuple[float, ...]
) -> Iterator[Study]:
    """Run the machine in every form; yields all that is known after each run.

    Every motion is kept in `folder`; a study that was cut off goes on from there.
    """
    runner = _Runner(machine, folder, announce)
    full = FullBody(machine.body, machine.frame)
    study = Study(machine, runner.run("unreduced", None, None, full))
    yield study
    exact = runner.reduced("exact modes", None, None, NormalModes(machine.n_modes))
    study = replace(study, runs=(exact,))
    yield study
    for tolerance in tolerances:
        small = runner.reduced(
            "modal coordinates", tolerance, None, ErrorControlled(tolerance, machine.n_modes)
        )
        study = replace(study, runs=(*study.runs, small))
        yield study
        whole = runner.reduced("whole basis", tolerance, small.modes, CraigBampton(n_modes=small.modes))
        study = replace(study, runs=(*study.runs, whole))
        yield study
    finest = study.of_kind("modal coordinates")[-1]
    half = FixedStep(machine.step / 2)
    tight = replace(ADAPTIVE, largest=ADAPTIVE.largest / 2, tolerance=ADAPTIVE.tolerance / 100)
    for coarse, fine in ((FixedStep(machine.step), half), (ADAPTIVE, tight)):
        study = replace(study, separations=(*study.separations, runner.separation(finest, coarse, fine)))
        yield study


@dataclass(frozen=True)
class _Runner:
    machine: FlexibleMachine
    folder: Path
    announce: Announce

    def reduced(
        self, kind: str, tolerance: float | None, modes: int | None, recipe: LinearBasisRecipe
    ) -> MachineRun:
        began = perf_counter()
        body = reduce(self.machine.body, self.machine.frame, recipe, derivatives=NoDerivatives())
        seconds = perf_counter() - began
        proven = body.report.certificate
        return self.run(kind, tolerance, proven.n_fixed_interface_modes if proven else modes, body, seconds)

    def run(
        self,
        kind: str,
        tolerance: float | None,
        modes: int | None,
        body: FullBody | ReducedBody,
        offline_seconds: float = 0.0,
    ) -> MachineRun:
        system = self.machine.system(body)
        label = kind if tolerance is None else f"{kind}, {100 * tolerance:g} %"
        solution = self.simulate(system, body, label, FixedStep(self.machine.step))
        point = _history(self.machine, body, solution)
        drift = None if isinstance(body, FullBody) else _drift(self.machine, system, solution)
        return MachineRun(kind, tolerance, modes, body, system, solution, point, drift, offline_seconds)

    def simulate(
        self, system: System, body: FullBody | ReducedBody, label: str, step: StepControl
    ) -> Solution:
        machine = self.machine
        mesh = hashlib.sha256(machine.body.nodes.tobytes()).hexdigest()[:12]
        case = f"{machine.label}, nodes {mesh}, {label}, {body.r} coordinates, {step}"
        name = "".join(c if c.isalnum() or c in "-_." else "_" for c in f"{label} {body.r} {_words(step)}")
        options: dict[str, Any] = {
            "duration": machine.duration,
            "output_step": machine.output_step,
            "step": step,
            "tolerances": NEWTON,
        }
        path = self.folder / f"{machine.label}_{name}.h5"
        return simulate_recorded(system, path, case=case, progress=self.announce(label), **options)

    def separation(self, run: MachineRun, coarse: StepControl, fine: StepControl) -> Separation:
        label = f"{run.kind}, {100 * (run.tolerance or 0):g} %"
        solutions = [
            run.solution
            if step == FixedStep(self.machine.step)
            else self.simulate(run.system, run.body, f"{label}, {_words(step)}", step)
            for step in (coarse, fine)
        ]
        points = [
            node_motion(run.body, solution.bodies[run.body.name], [self.machine.point]).position[:, 0]
            for solution in solutions
        ]
        distance = np.linalg.norm(points[0] - points[1], axis=1)
        apart = distance > APART * self.machine.size
        times = solutions[0].times
        time = float(times[np.argmax(apart)]) if apart.any() else None
        return Separation(_words(coarse), _words(fine), times, distance, time, (solutions[0], solutions[1]))


def _words(step: StepControl) -> str:
    if isinstance(step, FixedStep):
        return f"fixed step {step.size:g} s"
    return f"adaptive step, tolerance {step.tolerance:g}, largest {step.largest:g} s"


def _drift(machine: FlexibleMachine, system: System, solution: Solution) -> Drift:
    energies = balances(system, solution)
    excess = energies.total - machine.work(solution)
    return Drift(
        float(np.abs(excess - excess[0]).max() / energies.kinetic.max()),
        float(np.abs(joint_gaps(system, solution)).max()),
    )


def _history(machine: FlexibleMachine, body: FullBody | ReducedBody, solution: Solution) -> PointHistory:
    motion = solution.bodies[body.name]
    node = node_motion(body, motion, [machine.point])
    stress = von_mises_history(body, machine.model, motion.coordinates, [machine.point])[:, 0]
    # In an isotropic material the equivalent strain is the equivalent stress over 3 G.
    shear_modulus = machine.material.youngs_modulus / (2 + 2 * machine.material.poissons_ratio)
    return PointHistory(
        solution.times,
        node.position[:, 0],
        node.velocity[:, 0],
        node.acceleration[:, 0],
        stress,
        stress / (3 * shear_modulus),
    )
