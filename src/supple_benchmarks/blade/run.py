"""The blade benchmark as a whole: full runs, bases of fixed size, self-correction, a batch of load cases."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from supple.body import FlexibleBody, RayleighDamping
from supple_benchmarks.blade.batch_run import BatchRun, run_batch
from supple_benchmarks.blade.corrected_run import CorrectedRun, correct_blade
from supple_benchmarks.blade.full_run import FullCase, FullRun, run_full
from supple_benchmarks.blade.reduced_run import ReducedRun, bases_of, run_reduced
from supple_benchmarks.compared_models import FRAMES, KINEMATICS, reduce_to_compare
from supple_benchmarks.nrel5mw_blade import (
    CASES,
    COARSE_GRID,
    PAPER_SPEED,
    RATED,
    Blade,
    BladeCase,
    blade_damping,
    root_clamped_frequencies,
)
from supple_benchmarks.progress import Announce

__all__ = ["BladeBenchmark", "BladeRun", "run_blade"]


@dataclass(frozen=True)
class BladeBenchmark:
    """Size of the benchmark.

    full : FullCase         full-order runs, in the order in which they are made
    duration : s            of the reduced runs
    relative_error : float  target of the self-correction, over the tip's amplitude
    batch : int             number of load cases
    n_linear : int          columns of the basis without derivatives
    """

    blade: Blade
    cases: tuple[BladeCase, ...]
    full: tuple[FullCase, ...]
    duration: float
    batch: int
    relative_error: float = 1e-3
    n_linear: int = 50

    @classmethod
    def whole(cls, seconds: float = 20.0, long: float = 100.0) -> BladeBenchmark:
        """The whole benchmark: full runs last `seconds`, and the first one at least `long`, s.

        At the paper's speed they last at least 1.5 times the spin-up. Reduced runs last 100 s.
        """
        gl = "green-lagrange"
        fast = max(seconds, 1.5 * PAPER_SPEED.start)
        full = [FullCase(RATED, "nodal-fixed", gl, False, max(seconds, long))]
        full += [FullCase(RATED, "mean-axis", gl, False, seconds)]
        full += [FullCase(PAPER_SPEED, frame, gl, False, fast) for frame in FRAMES]
        full += [FullCase(RATED, frame, gl, True, seconds) for frame in FRAMES]
        full += [FullCase(RATED, "nodal-fixed", "von-karman", False, seconds)]
        return cls(Blade(), CASES, tuple(full), duration=100.0, batch=64)

    @classmethod
    def quick(cls) -> BladeBenchmark:
        """A coarse blade that is spun up in 1.5 s, with 2 s of motion and a larger allowed error.

        All bases have 25 columns, because bases of equal size share one compiled program.
        """
        case = replace(RATED, start=1.5)
        full = tuple(FullCase(case, frame, "green-lagrange", False, 2.0) for frame in FRAMES)
        return cls(Blade(COARSE_GRID), (case,), full, duration=2.0, batch=4, n_linear=25, relative_error=5e-3)


@dataclass(frozen=True, eq=False)
class BladeRun:
    """The results of the finished runs."""

    benchmark: BladeBenchmark
    body: FlexibleBody
    frequencies: np.ndarray
    """Lowest angular frequencies of the blade clamped at its root, rad/s"""
    full: list[FullRun] = field(default_factory=list)
    reduced: list[ReducedRun] = field(default_factory=list)
    corrected: list[CorrectedRun] = field(default_factory=list)
    batch: BatchRun | None = None

    @property
    def damping(self) -> RayleighDamping:
        """Two per cent in the first two clamped modes."""
        return blade_damping(self.frequencies)

    def full_of(self, case: BladeCase, frame: str) -> FullRun | None:
        """The full run with which reduced runs are compared, if it has been made."""
        own = (full for full in self.full if full.case.case == case and full.case.frame == frame)
        return next((full for full in own if full.case.is_reference), None)


def run_blade(benchmark: BladeBenchmark, folder: Path, announce: Announce) -> Iterator[BladeRun]:
    """Run the benchmark; yields the results of the finished runs after each step.

    Full runs are stored in the folder as they are computed, and continued by the next call. They come first,
    because errors are measured against them.
    """
    progress = announce("mesh, matrices, modes of the blade")
    blade = benchmark.blade
    body = blade.body()
    run = BladeRun(benchmark, body, root_clamped_frequencies(body))
    progress(1.0)
    for wanted in benchmark.full:
        own = body if wanted.kinematics == "green-lagrange" else blade.body(KINEMATICS[wanted.kinematics])
        bar = announce(f"full: {wanted.label}")
        run.full.append(run_full(blade, own, run.damping, wanted, folder, bar))
        yield run
    for frame in FRAMES:
        for case in benchmark.cases:
            yield from _reduced_runs(run, frame, case, announce)
            yield from _corrected_run(run, frame, case, announce)
    best = run.corrected[0].rounds[-1].body
    bar = announce(f"{benchmark.batch} load cases of {benchmark.duration:g} s, {best.r} coordinates")
    batch = run_batch(blade, benchmark.cases[0], best, range(benchmark.batch), benchmark.duration, bar)
    yield replace(run, batch=batch)


def _reduced_runs(run: BladeRun, frame: str, case: BladeCase, announce: Announce) -> Iterator[BladeRun]:
    benchmark = run.benchmark
    for basis in bases_of(benchmark.blade, run.body, frame, case, benchmark.n_linear):
        bar = announce(f"reduced: {case.name}, {frame}, {basis.label}")
        reduced = reduce_to_compare(run.body, basis, run.damping)
        full = run.full_of(case, frame)
        run.reduced.append(run_reduced(benchmark.blade, case, basis, reduced, full, benchmark.duration, bar))
        yield run


def _corrected_run(run: BladeRun, frame: str, case: BladeCase, announce: Announce) -> Iterator[BladeRun]:
    """Self-correction over the time of the full run, so that both errors refer to the same motion."""
    benchmark = run.benchmark
    full = run.full_of(case, frame)
    duration = benchmark.duration if full is None else min(full.case.duration, benchmark.duration)
    amplitude = [
        each.tip.amplitude for each in run.reduced if each.case == case and each.basis.frame == frame
    ]
    run.corrected.append(
        correct_blade(
            benchmark.blade,
            run.body,
            run.damping,
            case,
            frame,
            allowed=benchmark.relative_error * amplitude[0],
            duration=duration,
            full=full,
            progress=announce(f"self-correcting: {case.name}, {frame}"),
        )
    )
    yield run
