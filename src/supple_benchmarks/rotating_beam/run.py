"""Runs of the rotating beam: exact, full in both floating frames, reduced as in [Wu2019] Table 1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from supple.body import (
    FlexibleBody,
    FullBody,
)
from supple.integrate import FixedStep, Run, Solution
from supple.machine import GROUND, At, Placed, PrescribedRotation, System
from supple.machine.laws.spin_up import SpinUp
from supple.quantities.tracked_motion import displacement_from_axes, node_positions
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    DerivativeChoice,
    LinearBasisRecipe,
    NoDerivatives,
    PickedDerivatives,
    ReducedBody,
    Rubin,
    StaticLoad,
)
from supple.results.error_measures import MotionError, motion_error
from supple.simulation import simulate
from supple_benchmarks.compared_tensors import reduce_to_compare
from supple_benchmarks.progress import Announce, Progress
from supple_benchmarks.rotating_beam.exact_beam import ExactTip, exact_tip
from supple_benchmarks.rotating_beam.problem import BODY, FRAMES, KINEMATICS, ROOT, RotatingBeam, spin_up_load
from supple_benchmarks.rotating_beam.tip_motion import TipMotion
from supple_benchmarks.until_early_end import until_early_end

__all__ = [
    "BeamRun",
    "FullRun",
    "ReducedRun",
    "run_rotating_beam",
]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FullRun:
    """One full-order simulation."""

    frame: str
    kinematics: str
    omega: float
    solution: Solution
    body: FullBody
    tip: TipMotion


@dataclass(frozen=True)
class ReducedRun:
    """A reduced simulation and the full one in the same frame; `failed_at`: time of an early end, or None."""

    full: FullRun
    basis: str
    derivatives: str
    tensors: str
    body: ReducedBody
    n_linear: int
    n_added: int
    solution: Solution
    tip: TipMotion
    error: MotionError
    offline_seconds: float
    failed_at: float | None

    @property
    def columns(self) -> str:
        """The columns of the basis as text."""
        if self.n_added:
            return f"{self.n_linear}+{self.n_added} {self.derivatives}" + (
                ", plain" if self.tensors == "plain" else ""
            )
        return f"{self.n_linear} linear"


@dataclass(frozen=True)
class BeamRun:
    """The finished runs, and the exact beam's tip motion by speed."""

    problem: RotatingBeam
    exact: dict[float, ExactTip]
    full: tuple[FullRun, ...]
    reduced: tuple[ReducedRun, ...]


def run_rotating_beam(problem: RotatingBeam, announce: Announce) -> Iterator[BeamRun]:
    """Run the benchmark; yields all finished runs after each simulation."""
    exact: dict[float, ExactTip] = {}
    full: list[FullRun] = []
    reduced: list[ReducedRun] = []
    for speed in problem.speeds:
        spin = SpinUp(speed)
        progress = announce(f"exact beam, {speed:g} rad/s")
        exact[speed] = exact_tip(problem, spin)
        progress(1.0)
        for kinematics in problem.kinematics:
            body = problem.body(KINEMATICS[kinematics])
            for frame in FRAMES:
                label = f"{frame}, {kinematics}, {speed:g} rad/s"
                reference = _run_full(problem, spin, body, frame, kinematics, announce(f"full {label}"))
                full.append(reference)
                yield BeamRun(problem, exact, tuple(full), tuple(reduced))
                for choice in _choices(body, frame, with_linear=speed == problem.speeds[0]):
                    name = f"{choice.n_linear} + {choice.n_added} {choice.derivatives_name}, {choice.tensors}"
                    reduced.append(
                        _run_reduced(problem, spin, body, reference, choice, announce(f"{name}, {label}"))
                    )
                    yield BeamRun(problem, exact, tuple(full), tuple(reduced))


@dataclass(frozen=True)
class _Choice:
    """A basis: recipe, derivatives, tensors, and their names and numbers in the report."""

    recipe: LinearBasisRecipe
    basis_name: str
    derivatives: DerivativeChoice
    derivatives_name: str
    tensors: str
    n_linear: int
    n_added: int


def _choices(body: FlexibleBody, frame: str, *, with_linear: bool) -> list[_Choice]:
    """The bases of [Wu2019] Table 1 and variants: compressed derivatives, condensed tensors."""
    load = AmplitudeProduct(StaticLoad(spin_up_load(body)))

    def linear(n_columns: int) -> tuple[LinearBasisRecipe, str]:
        if frame == "nodal-fixed":
            return CraigBampton(n_modes=n_columns), "craig-bampton"
        return Rubin(n_columns=n_columns), "rubin"

    picked = PickedDerivatives(10, criterion=load)
    enriched: list[tuple[DerivativeChoice, str, str]] = [
        (picked, "picked", "condensed"),
        (CompressedDerivatives(10, weights=load), "compressed", "condensed"),
        (picked, "picked", "plain"),
    ]
    choices = [_Choice(*linear(10), *choice, 10, 10) for choice in enriched]
    if with_linear:
        choices.append(_Choice(*linear(50), NoDerivatives(), "none", "plain", 50, 0))
    return choices


def _system(body: FullBody | ReducedBody, spin: SpinUp) -> System:
    hinge = PrescribedRotation(
        name="hinge", first=GROUND, second=At(BODY, ROOT), axis=(0.0, -1.0, 0.0), angle=spin
    )
    return System(bodies=(Placed(body),), joints=(hinge,))


def _tip(problem: RotatingBeam, spin: SpinUp, body: FullBody | ReducedBody, solution: Solution) -> TipMotion:
    node = problem.mesh().nodes_of("tip_centre")
    positions = node_positions(body, solution.bodies[BODY], node)[:, 0]
    angle = np.asarray(spin(solution.times))
    cosine, sine, zero, one = np.cos(angle), np.sin(angle), 0 * angle, 1 + 0 * angle
    # Columns: the root's axis, the width, and the normal towards which a positive rotation moves the beam.
    axes = np.stack(
        [
            np.stack([cosine, zero, sine], axis=-1),
            np.stack([zero, one, zero], axis=-1),
            np.stack([-sine, zero, cosine], axis=-1),
        ],
        axis=-1,
    )
    seen = displacement_from_axes(positions, np.zeros(3), axes, body.nodes[node[0]])
    return TipMotion(solution.times, seen[:, 0], seen[:, 2])


def _run_full(
    problem: RotatingBeam,
    spin: SpinUp,
    body: FlexibleBody,
    frame: str,
    kinematics: str,
    progress: Progress,
) -> FullRun:
    full = FullBody(body, FRAMES[frame])
    solution = simulate(
        _system(full, spin),
        Run(duration=problem.duration, output_step=problem.output_step, step=FixedStep(problem.step)),
        progress=progress,
    )
    return FullRun(frame, kinematics, spin.speed, solution, full, _tip(problem, spin, full, solution))


def _run_reduced(
    problem: RotatingBeam,
    spin: SpinUp,
    body: FlexibleBody,
    full: FullRun,
    choice: _Choice,
    progress: Progress,
) -> ReducedRun:
    began = perf_counter()
    reduced = reduce_to_compare(
        body, FRAMES[full.frame], choice.recipe, derivatives=choice.derivatives, tensors=choice.tensors
    )
    offline = perf_counter() - began
    solution, failed_at = until_early_end(
        _system(reduced, spin),
        Run(duration=problem.duration, output_step=problem.output_step, step=FixedStep(problem.step)),
        progress=progress,
    )
    reference = full.solution.at(slice(len(solution.times)))
    return ReducedRun(
        full=full,
        basis=choice.basis_name,
        derivatives=choice.derivatives_name,
        tensors=choice.tensors,
        body=reduced,
        n_linear=choice.n_linear,
        n_added=choice.n_added,
        solution=solution,
        tip=_tip(problem, spin, reduced, solution),
        error=motion_error(reference, full.body, solution, reduced, body=BODY),
        offline_seconds=offline,
        failed_at=failed_at,
    )
