"""100 cases of a swinging bar: a sweep of supple and Exudyn's `ParameterVariation`, one process each.

The bar of `against_exudyn.py` under 100 values of gravity, for half a second. Both codes reduce the bar once
beforehand and use the same modes, step and tolerance; Exudyn uses modified Newton, its default. Processor
seconds include the whole cost of a case: setup of the machine, march, largest deflection, and for supple the
statistics of all channels and the files of the sweep. The program is compiled beforehand; the time of
compilation is listed separately.

Exudyn (BSD licence) is not a dependency: pip install exudyn==1.13.6
Run: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/sweep_against_exudyn.py
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np
from against_exudyn import N_MODES, STEP, TOLERANCE, assembled_in_exudyn, bar, reduced_in_exudyn
from exudyn_run import exudyn, timed_run
from measure import keep

from supple.body import AveragingInterface, FlexibleBody, MeanAxisFrame, flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import Mesh
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.storage import write_reduced_body
from supple.sweeps import CaseTable, make_plan, plan_sweep, read_sweep, run_part_of_sweep
from supple.sweeps.sweep_file import SweepOutput

N_CASES, DURATION, OUTPUT_STEP = 100, 0.5, 0.02
GRAVITIES = np.linspace(-12.0, -2.0, N_CASES)

_CASE = f"""\
title = "bar on a ball joint"
gravity = [0.0, 0.0, -9.81]

[[body]]
name = "bar"
reduced = "bar.h5"

[[joint]]
name = "ball"
kind = "ball"
first = "ground"
second = "bar.root"

[[sensor]]
name = "tip"
kind = "position"
at = "bar.tip"

[simulation]
duration = {DURATION}
output_step = {OUTPUT_STEP}
step = {STEP}
rho_inf = 0.8
"""


def with_tip(mesh: Mesh) -> FlexibleBody:
    """The bar with interfaces at both ends; sensors of a reduced body refer to interfaces."""
    ends = [AveragingInterface(name, name) for name in ("root", "tip")]
    return flexible_body("bar", solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0)), ends)


def sweep_of(case: Path, folder: Path) -> np.ndarray:
    """Lowest heights of the tip, by a sweep in this process."""
    plan = make_plan(case, CaseTable({"gravity[2]": GRAVITIES.tolist()}), SweepOutput.model_validate({}))
    plan_sweep(plan, folder)
    run_part_of_sweep(folder, 1, 1)
    return read_sweep(folder).statistics.sel(channel="tip.z", statistic="minimum").values


def variation(mesh: Mesh, reduced: Any) -> np.ndarray:
    """Lowest heights of the tip, by Exudyn's `ParameterVariation`."""
    from exudyn.processing import ParameterVariation

    def lowest(parameters: dict[str, float]) -> float:
        mbs, sensor = assembled_in_exudyn(mesh, reduced, [0.0, 0.0, parameters["gravity"]])
        run = timed_run(
            mbs,
            sensor,
            duration=DURATION,
            step=STEP,
            output_step=OUTPUT_STEP,
            tolerance=TOLERANCE,
            modified_newton=True,
        )
        return float(run()[3][:, 2].min())

    _, values = ParameterVariation(lowest, {"gravity": GRAVITIES.tolist()}, showProgress=False)
    return np.array(values)


def cost(work: Callable[[], np.ndarray]) -> tuple[float, np.ndarray]:
    began = process_time()
    found = work()
    return process_time() - began, found


def main() -> None:
    exudyn()
    mesh, body = bar()
    reduced = reduced_in_exudyn(mesh, body)
    with TemporaryDirectory() as place:
        folder = Path(place)
        small = reduce(
            with_tip(mesh).linearized(),
            MeanAxisFrame(),
            NormalModes(N_MODES),
            derivatives=NoDerivatives(),
            loads=NoLoads,
        )
        write_reduced_body(folder / "bar.h5", small)
        case = folder / "bar.toml"
        case.write_text(_CASE, encoding="utf-8")
        first, _ = cost(lambda: sweep_of(case, folder / "compiled"))
        ours, heights = cost(lambda: sweep_of(case, folder / "sweep"))
    theirs, other = cost(lambda: variation(mesh, reduced))
    rows = [
        {
            "code": "supple",
            "cpu s": ours,
            "ms / case": 1e3 * ours / N_CASES,
            "compiled in, cpu s": first - ours,
        },
        {"code": "Exudyn", "cpu s": theirs, "ms / case": 1e3 * theirs / N_CASES},
    ]
    keep(
        "sweep_against_exudyn",
        rows,
        exudyn=version("exudyn"),
        ratio=theirs / ours,
        lowest_tips_apart=float(np.abs(heights - other).max()),
    )


if __name__ == "__main__":
    main()
