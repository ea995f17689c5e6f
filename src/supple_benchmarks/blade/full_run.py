"""Full-order simulations of the blade: long, written to disk during the run, and resumable."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from supple.body import FlexibleBody, FullBody, RayleighDamping
from supple.integrate import FixedStep, Run, Solution, Tolerances
from supple.simulation import simulate_recorded
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.nrel5mw_blade import Blade, BladeCase, TipMotion, tip_motion
from supple_benchmarks.progress import Progress

__all__ = ["FullCase", "FullRun", "run_full", "run_of"]

STEP = FixedStep(0.02)
TOLERANCES = Tolerances(residual=1e-6)
OUTPUT_STEP = 0.1
"""s; every fifth step is stored: the modes with most of the motion are below 3 Hz."""


def run_of(duration: float) -> Run:
    """The run of every model of the blade, of a duration in s."""
    return Run(duration, OUTPUT_STEP, step=STEP, tolerances=TOLERANCES)


@dataclass(frozen=True)
class FullCase:
    """A case of the full model.

    frame, kinematics : names from FRAMES and KINEMATICS
    linear : bool       internal force K q, without geometric stiffening
    """

    case: BladeCase
    frame: str
    kinematics: str
    linear: bool
    duration: float

    @property
    def is_reference(self) -> bool:
        """Whether reduced runs are compared with it: nonlinear, with Green-Lagrange strains."""
        return not self.linear and self.kinematics == "green-lagrange"

    @property
    def label(self) -> str:
        """Label for messages and file names."""
        strains = "linear" if self.linear else self.kinematics
        return f"{self.case.name}, {self.frame}, {strains}, {self.duration:g} s"


@dataclass(frozen=True, eq=False)
class FullRun:
    """A finished full-order simulation."""

    case: FullCase
    body: FullBody
    solution: Solution
    tip: TipMotion


def run_full(
    blade: Blade,
    body: FlexibleBody,
    damping: RayleighDamping,
    wanted: FullCase,
    folder: Path,
    progress: Progress,
) -> FullRun:
    """The run, read from the folder if complete, resumed if incomplete.

    body : nonlinear, with the requested kinematics
    """
    full = FullBody(body.linearized() if wanted.linear else body, FRAMES[wanted.frame], damping)
    name = wanted.label.replace(", ", "_").replace(" ", "-")
    solution = simulate_recorded(
        blade.system(full, wanted.case, blade.loads(wanted.case, wanted.duration)),
        run_of(wanted.duration),
        folder / f"full_{name}.h5",
        case=json.dumps({**asdict(wanted), "grid": asdict(blade.grid), "step": STEP.size}),
        progress=progress,
    )
    return FullRun(wanted, full, solution, tip_motion(blade, wanted.case, full, solution))
