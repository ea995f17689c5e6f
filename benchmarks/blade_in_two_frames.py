"""Difference of the rated blade between the two frames, by kind of damping.

Reduced bodies with ten linear columns and fifteen picked derivatives in each frame, 20 s of the rated case
with Rayleigh damping, with either of its parts alone, with modal damping, and without damping. Each body is
within 9e-3 m of the full model in the same frame.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/blade_in_two_frames.py
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from measure import keep

from supple.body import Damping, FlexibleBody, ModalDamping
from supple.integrate import Run
from supple.reduction import NoLoads, reduce
from supple.simulation import simulate
from supple_benchmarks.blade.full_run import OUTPUT_STEP, STEP, TOLERANCES
from supple_benchmarks.blade.reduced_run import FixedBasis, bases_of
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.nrel5mw_blade import (
    RATED,
    Blade,
    TipMotion,
    blade_damping,
    root_clamped_frequencies,
    tip_motion,
)

SECONDS = 20.0


def main() -> None:
    blade = Blade()
    body = blade.body()
    rayleigh = blade_damping(root_clamped_frequencies(body))
    kinds = {
        "alpha M, beta by strain rate": rayleigh,
        "alpha M + beta K": rayleigh.linearized(),
        "beta by strain rate": replace(rayleigh, alpha=0.0),
        "alpha M alone": replace(rayleigh, beta=0.0),
        "beta K alone": replace(rayleigh, alpha=0.0).linearized(),
        "2 % of every mode": ModalDamping(0.02),
        "none": None,
    }
    bases = {frame: bases_of(blade, body, frame, RATED)[0] for frame in FRAMES}
    rows = []
    for kind, damping in kinds.items():
        fixed, mean = (run(blade, body, basis, damping) for basis in bases.values())
        apart = {
            "flap apart, m": float(np.abs(fixed.flap - mean.flap).max()),
            "edge apart, m": float(np.abs(fixed.edge - mean.edge).max()),
        }
        rows.append({"damping": kind, "largest flap, m": float(fixed.flap.max()), **apart})
        print(rows[-1], flush=True)
    keep("blade_in_two_frames", rows, bases={frame: basis.label for frame, basis in bases.items()})


def run(blade: Blade, body: FlexibleBody, basis: FixedBasis, damping: Damping | None) -> TipMotion:
    """Motion of the tip relative to the root, computed in one frame."""
    reduced = reduce(
        body, FRAMES[basis.frame], basis.recipe, derivatives=basis.derivatives, damping=damping, loads=NoLoads
    )
    motion = simulate(
        blade.system(reduced, RATED, blade.loads(RATED, SECONDS)),
        Run(duration=SECONDS, output_step=OUTPUT_STEP, step=STEP, tolerances=TOLERANCES),
    )
    return tip_motion(blade, RATED, reduced, motion)


if __name__ == "__main__":
    main()
