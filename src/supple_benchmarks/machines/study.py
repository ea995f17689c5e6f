"""A machine run with its flexible body unreduced, and reduced to tolerances on its eigenvalues.

Every tolerance gives three bodies: the whole Craig-Bampton basis; its N_m lowest modes as in [Han2020]
(46)-(49), which makes all bases of equal size but omits the static motions of the interface; and those modes
with attachment modes, which add the static motions again. A further body has its N_m exact modes, the limit
of the second basis for tolerance zero.

Compared runs have the same fixed steps, so that errors of the time integration, which are larger, cancel. The
cost of adaptive steps, and the size of integration errors, are measured with the finest body.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.body import FullBody
from supple.integrate import AdaptiveStep, FixedStep, Run, Solution, StepControl, Tolerances
from supple.machine import System
from supple.reduction import (
    AttachmentModes,
    CraigBampton,
    ErrorControlled,
    LinearBasisRecipe,
    NoDerivatives,
    NoLoads,
    NormalModes,
    ReducedBody,
    reduce,
)
from supple.simulation import simulate_recorded
from supple.storage import read_reduced_body, write_reduced_body
from supple_benchmarks.machines.flexible_machine import FlexibleMachine
from supple_benchmarks.machines.run import MachineRun, Variant, deformation, drift, energy_norm, point_history
from supple_benchmarks.progress import Announce

__all__ = ["ADAPTIVE", "APART", "Separation", "Study", "run_study"]

Array = NDArray[np.float64]

ADAPTIVE = AdaptiveStep(first=1e-6, largest=1e-2, tolerance=1e-6)
"""First and largest step of [Han2020]."""
NEWTON = Tolerances(residual=1e-12)
"""Far below the differences between bodies: with 1e-8 all whole bases have the same error, 7e-9 m."""
APART = 0.01
"""Two runs have diverged when node A differs by this fraction of the machine's size."""


@dataclass(frozen=True, eq=False)
class Separation:
    """Divergence of two runs with different steps: distance of node A over time, and time of divergence.

    coarse, fine : the steps, as text     time : s, from which the distance exceeds 1 % of the machine's size,
        or None     solutions : of both runs
    """

    coarse: str
    fine: str
    times: Array
    distance: Array
    time: float | None
    solutions: tuple[Solution, Solution]


@dataclass(frozen=True, eq=False)
class Study:
    """The finished runs."""

    machine: FlexibleMachine
    reference: MachineRun
    runs: tuple[MachineRun, ...] = ()
    separations: tuple[Separation, ...] = ()

    @property
    def compared_until(self) -> float:
        """The time up to which motions are compared: the start of chaotic motion, or the end."""
        apart = [each.time for each in self.separations if each.time is not None]
        return min(apart, default=float(self.reference.point.times[-1]))

    def of(self, variant: Variant) -> list[MachineRun]:
        """The reduced runs of one variant, the loosest tolerance first."""
        return [run for run in self.runs if run.variant is variant]


def run_study(
    machine: FlexibleMachine, folder: Path, announce: Announce, tolerances: tuple[float, ...]
) -> Iterator[Study]:
    """Run the machine in every variant; yields the study with the finished runs after each run.

    Every motion is stored in `folder`; an interrupted study continues from there.
    """
    runner = _Runner(machine, folder, announce)
    full = FullBody(machine.body, machine.frame)
    reference = runner.run(Variant.UNREDUCED, None, None, full)
    runner = replace(runner, truth=deformation(full, reference.solution))
    study = Study(machine, reference)
    yield study
    for variant, tolerance, recipe in _recipes(machine, tolerances):
        run = runner.reduced(variant, tolerance, recipe)
        study = replace(study, runs=(*study.runs, run))
        yield study
        if variant is Variant.MODAL_COORDINATES:
            whole = runner.reduced(Variant.WHOLE_BASIS, tolerance, CraigBampton(n_modes=run.modes))
            study = replace(study, runs=(*study.runs, whole))
            yield study
    finest = study.of(Variant.WITH_ATTACHMENT_MODES)[-1]
    half = FixedStep(machine.step / 2)
    tight = replace(ADAPTIVE, largest=ADAPTIVE.largest / 2, tolerance=ADAPTIVE.tolerance / 100)
    for coarse, fine in ((FixedStep(machine.step), half), (ADAPTIVE, tight)):
        study = replace(study, separations=(*study.separations, runner.separation(finest, coarse, fine)))
        yield study


def _recipes(
    machine: FlexibleMachine, tolerances: tuple[float, ...]
) -> Iterator[tuple[Variant, float | None, LinearBasisRecipe]]:
    """All recipes but those of whole bases, whose size is known only after an error-controlled reduction."""
    yield Variant.EXACT_MODES, None, NormalModes(machine.n_modes)
    for tolerance in tolerances:
        modal = ErrorControlled(tolerance, machine.n_modes)
        yield Variant.MODAL_COORDINATES, tolerance, modal
        yield Variant.WITH_ATTACHMENT_MODES, tolerance, AttachmentModes(modal)


@dataclass(frozen=True)
class _Runner:
    machine: FlexibleMachine
    folder: Path
    announce: Announce
    truth: Array | None = None
    """Deformation of the unreduced body; None during the run of that body."""

    def reduced(self, variant: Variant, tolerance: float | None, recipe: LinearBasisRecipe) -> MachineRun:
        """The machine with its body reduced by a recipe."""
        # The body is stored with its motion, because round-off determines the signs of its columns.
        path = self.folder / self.file_name(f"{_words(variant, tolerance)} body")
        if path.exists():
            body = read_reduced_body(path)
        else:
            body = reduce(
                self.machine.body, self.machine.frame, recipe, derivatives=NoDerivatives(), loads=NoLoads
            )
            path.parent.mkdir(parents=True, exist_ok=True)
            write_reduced_body(path, body)
        proven = body.report.certificate
        modes = proven.n_fixed_interface_modes if proven else None
        if isinstance(recipe, CraigBampton):
            modes = recipe.n_modes
        return self.run(variant, tolerance, modes, body, sum(body.report.seconds.values()))

    def run(
        self,
        variant: Variant,
        tolerance: float | None,
        modes: int | None,
        body: FullBody | ReducedBody,
        offline_seconds: float = 0.0,
    ) -> MachineRun:
        """The machine with its body in a given variant, and the quantities compared."""
        system = self.machine.system(body)
        solution = self.simulate(system, body, _words(variant, tolerance), FixedStep(self.machine.step))
        shape = deformation(body, solution)
        return MachineRun(
            variant,
            tolerance,
            modes,
            body,
            system,
            solution,
            point_history(self.machine, body, solution),
            energy_norm(self.machine, shape if self.truth is None else shape - self.truth),
            drift(self.machine, system, solution),
            offline_seconds,
        )

    def simulate(
        self, system: System, body: FullBody | ReducedBody, label: str, step: StepControl
    ) -> Solution:
        """The motion with given steps, read from disk if present."""
        run = Run(self.machine.duration, self.machine.output_step, step=step, tolerances=NEWTON)
        name = self.file_name(f"{label} {_step_words(step)}")
        case = f"{name}, {body.n_coordinates} coordinates, {step}, {NEWTON}"
        return simulate_recorded(system, run, self.folder / name, case=case, progress=self.announce(label))

    def file_name(self, label: str) -> str:
        """Name of a file for the machine's current body: its matrices determine part of the name."""
        name = f"{self.machine.label}_{self.fingerprint}_{label}"
        return "".join(c if c.isalnum() or c in "-_." else "_" for c in name) + ".h5"

    @cached_property
    def fingerprint(self) -> str:
        """Eight characters that change with the flexible body."""
        body = self.machine.body
        digest = hashlib.sha256()
        for numbers in (body.nodes, body.stiffness.data, body.mass.data):
            digest.update(numbers.tobytes())
        return digest.hexdigest()[:8]

    def separation(self, run: MachineRun, coarse: StepControl, fine: StepControl) -> Separation:
        """Motion of the run's body with two kinds of steps, and the time at which the two motions diverge."""
        label = _words(run.variant, run.tolerance)
        solutions = [
            run.solution
            if step == FixedStep(self.machine.step)
            else self.simulate(run.system, run.body, label, step)
            for step in (coarse, fine)
        ]
        points = [
            run.body.node_motion(solution.bodies[run.body.name], [self.machine.point]).position[:, 0]
            for solution in solutions
        ]
        distance = np.linalg.norm(points[0] - points[1], axis=1)
        apart = distance > APART * self.machine.size
        times = solutions[0].times
        time = float(times[np.argmax(apart)]) if apart.any() else None
        return Separation(
            _step_words(coarse), _step_words(fine), times, distance, time, (solutions[0], solutions[1])
        )


def _words(variant: Variant, tolerance: float | None) -> str:
    return variant.value if tolerance is None else f"{variant.value} {100 * tolerance:g} %"


def _step_words(step: StepControl) -> str:
    if isinstance(step, FixedStep):
        return f"fixed {step.size:g} s"
    return f"adaptive {step.tolerance:g}, to {step.largest:g} s"
