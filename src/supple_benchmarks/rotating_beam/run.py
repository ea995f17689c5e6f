"""Runs of the rotating beam: exact, full in both floating frames, reduced as in [Wu2019] Table 1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, FullBody
from supple.integrate import Solution
from supple.machine import GROUND, At, Placed, PrescribedRotation, System
from supple.machine.laws.spin_up import SpinUp
from supple.quantities.tracked_motion import displacement_from_axes, node_positions
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    NoDerivatives,
    PickedDerivatives,
    ReducedBody,
    StaticLoad,
)
from supple.results.error_measures import MotionError, motion_error
from supple.simulation import simulate
from supple_benchmarks.compared_models import (
    FRAMES,
    KINEMATICS,
    ROOT,
    FixedBasis,
    linear_basis,
    reduce_to_compare,
    turned_axes,
    until_early_end,
)
from supple_benchmarks.progress import Announce, Progress
from supple_benchmarks.rotating_beam.exact_beam import ExactTip, exact_tip
from supple_benchmarks.rotating_beam.problem import BODY, RotatingBeam, spin_up_load
from supple_benchmarks.rotating_beam.tip_motion import TipMotion

__all__ = [
    "BeamRun",
    "FullRun",
    "ReducedRun",
    "run_rotating_beam",
]

AXIS = (0.0, -1.0, 0.0)


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
    basis: FixedBasis
    body: ReducedBody
    solution: Solution
    tip: TipMotion
    error: MotionError
    offline_seconds: float
    failed_at: float | None

    @property
    def columns(self) -> str:
        """The columns of the basis as text."""
        return self.basis.columns if self.basis.n_added else f"{self.basis.columns} linear"


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
                for basis in _bases(body, frame, with_linear=speed == problem.speeds[0]):
                    name = f"{basis.n_linear} + {basis.n_added} {basis.derivatives_name}, {basis.tensors}"
                    bar = announce(f"{name}, {label}")
                    reduced.append(_run_reduced(problem, spin, body, reference, basis, bar))
                    yield BeamRun(problem, exact, tuple(full), tuple(reduced))


def _bases(body: FlexibleBody, frame: str, *, with_linear: bool) -> list[FixedBasis]:
    """The bases of [Wu2019] Table 1 and variants: compressed derivatives, condensed tensors."""
    load = AmplitudeProduct(StaticLoad(spin_up_load(body)))
    linear, name = linear_basis(frame, 10), "craig-bampton" if frame == "nodal-fixed" else "rubin"
    picked, compressed = PickedDerivatives(10, criterion=load), CompressedDerivatives(10, weights=load)
    bases = [
        FixedBasis(frame, linear, name, picked, "picked", "condensed", 10, 10),
        FixedBasis(frame, linear, name, compressed, "compressed", "condensed", 10, 10),
        FixedBasis(frame, linear, name, picked, "picked", "plain", 10, 10),
    ]
    if with_linear:
        many = linear_basis(frame, 50)
        bases.append(FixedBasis(frame, many, name, NoDerivatives(), "none", "plain", 50, 0))
    return bases


def _system(body: FullBody | ReducedBody, spin: SpinUp) -> System:
    hinge = PrescribedRotation(name="hinge", first=GROUND, second=At(BODY, ROOT), axis=AXIS, angle=spin)
    return System(bodies=(Placed(body),), joints=(hinge,))


def _tip(problem: RotatingBeam, spin: SpinUp, body: FullBody | ReducedBody, solution: Solution) -> TipMotion:
    node = problem.mesh().nodes_of("tip_centre")
    positions = node_positions(body, solution.bodies[BODY], node)[:, 0]
    # Columns: the root's axis, the width, and the normal towards which a positive rotation moves the beam.
    axes = turned_axes(AXIS, spin(solution.times))
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
    solution = simulate(_system(full, spin), problem.run, progress=progress)
    return FullRun(frame, kinematics, spin.speed, solution, full, _tip(problem, spin, full, solution))


def _run_reduced(
    problem: RotatingBeam,
    spin: SpinUp,
    body: FlexibleBody,
    full: FullRun,
    basis: FixedBasis,
    progress: Progress,
) -> ReducedRun:
    reduced, offline = reduce_to_compare(body, basis)
    solution, failed_at = until_early_end(_system(reduced, spin), problem.run, progress=progress)
    reference = full.solution.at(slice(len(solution.times)))
    return ReducedRun(
        full=full,
        basis=basis,
        body=reduced,
        solution=solution,
        tip=_tip(problem, spin, reduced, solution),
        error=motion_error(reference, full.body, solution, reduced, body=BODY),
        offline_seconds=offline,
        failed_at=failed_at,
    )
