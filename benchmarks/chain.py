"""Chains of equal bodies: compile time and time per step, compared with Exudyn and MuJoCo if installed.

Run with one thread: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/chain.py [--quick] [--json FILE]
Rods on ball joints, supported at one end, fall from rest along x. They are rigid, or slender solids with
eight fixed-interface modes and the constraint modes of their two ends, in a mean-axis frame. All times are
processor times.
Compilation is measured in a process with an empty program cache: `compile_s` is the time of a run of 200
steps before its first step, with the program of short runs (`quick_us_per_step`); `compile_well_s` is the
additional time for the program of long runs, whose steps are compared.
Steps are timed alternately with Exudyn, which solves the same equations with the same step and tolerance, by
modified and by full Newton, with its dense and its sparse solver; the fastest of the four is listed.
MuJoCo has no flexible body of this kind; its rigid chain is integrated by the fourth-order Runge-Kutta rule.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import version
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import jax
import numpy as np
from exudyn_run import Outcome, TimedRun, best_of, timed_run
from measure import keep
from mujoco_chain import MUJOCO, in_mujoco

from supple.body import AveragingInterface, MeanAxisFrame, RigidBody, flexible_body
from supple.export import interface_nodes, write_exudyn
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType, block
from supple.methods.floating.compiled.engine import controls, initial_state
from supple.methods.floating.compiled.programs import COMPILED_MARCH, QUICK_MARCH
from supple.programs.program_cache import CachedProgram
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, ReducedBody, reduce
from supple.simulation import simulate

NUMBERS, QUICK = (1, 2, 4, 8, 16, 32, 64), (1, 8)
LENGTH, WIDTH, GRAVITY = 1.0, 0.1, (0.0, 0.0, -9.81)
DURATION, OUTPUT_STEP, STEP, TOLERANCE, REPEATS = 0.2, 0.1, 1e-3, 1e-6, 2
STEEL = Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7850.0)


def flexible_rod() -> ReducedBody:
    """A block of twenty-node hexahedra from x = 0 to 1."""
    mesh = block(LENGTH, WIDTH, WIDTH, 6, 1, 1, CellType.HEXA20)
    x = mesh.nodes[:, 0]
    ends = [
        AveragingInterface("near", np.flatnonzero(x < 1e-9)),
        AveragingInterface("far", np.flatnonzero(x > LENGTH - 1e-9)),
    ]
    body = flexible_body("rod", solid_model(mesh, STEEL), ends).linearized()
    return reduce(body, MeanAxisFrame(), CraigBampton(n_modes=8), derivatives=NoDerivatives(), loads=NoLoads)


def rigid_rod() -> RigidBody:
    """The same rod, rigid."""
    mass = STEEL.density * LENGTH * WIDTH**2
    across, along = mass * (LENGTH**2 + WIDTH**2) / 12, mass * WIDTH**2 / 6
    return RigidBody(
        "rod",
        mass,
        [LENGTH / 2, 0.0, 0.0],
        np.diag([along, across, across]),
        {"near": [0.0, 0.0, 0.0], "far": [LENGTH, 0.0, 0.0]},
    )


def chain(rod: Any, n: int) -> System:
    bodies = [Placed(replace(rod, name=f"rod {i}"), position=[i * LENGTH, 0, 0]) for i in range(n)]
    ends = [GROUND, *(At(f"rod {i}", "far") for i in range(n - 1))]
    joints = [Ball(first=end, second=At(f"rod {i}", "near"), name=f"ball {i}") for i, end in enumerate(ends)]
    return System(bodies, joints, gravity=GRAVITY)


def run_options() -> Run:
    return Run(
        DURATION,
        OUTPUT_STEP,
        step=FixedStep(STEP),
        method=GeneralizedAlpha(0.8),
        tolerances=Tolerances(TOLERANCE),
    )


def in_supple(rod: Any, n: int, march: CachedProgram = COMPILED_MARCH) -> TimedRun:
    """Only the march: the compiled program, from the start to the output times."""
    system, run = chain(rod, n), run_options()
    model, state = initial_state(system, 0.0, STEP)
    settings, times = controls(run), run.times[1:]
    program = march.compiled(model, settings, state, times)

    def timed() -> Outcome:
        last, _ = jax.block_until_ready(program(model, settings, state, times))
        body, place = system.bodies[-1].body, last.configuration
        position = np.asarray(body.interface("far").position)
        if isinstance(body, ReducedBody):
            position = position + body.interface("far").motion[:3] @ place.coordinates[-body.n_coordinates :]
        tip = place.origins[-1] + place.rotations[-1] @ position
        return int(last.steps), int(last.iterations), 0.0, np.asarray(tip)[None]

    return timed


def by_processor(run: TimedRun) -> TimedRun:
    """The run with processor time instead of wall time."""

    def timed() -> Outcome:
        began = process_time()
        steps, iterations, _, positions = run()
        return steps, iterations, process_time() - began, positions

    return timed


def compile_seconds(kind: str, n: int) -> tuple[float, float]:
    """Compile times of both programs in a new process without cached programs, s: short runs, long runs."""
    with TemporaryDirectory() as folder:
        shown = subprocess.run(
            [sys.executable, __file__, "--only", kind, str(n)],
            env=os.environ | {"JAX_COMPILATION_CACHE_DIR": folder},
            capture_output=True,
            text=True,
            check=True,
        )
    first, besides = map(float, shown.stdout.split()[-2:])
    return first, besides


def in_exudyn(rod: Any, n: int, file: Path, *, modified_newton: bool, linear_solver: str) -> TimedRun:
    import exudyn as exu
    from exudyn import itemInterface as items  # noqa: N813
    from exudyn.FEM import ObjectFFRFreducedOrderInterface
    from exudyn.rigidBodyUtilities import RigidBodyInertia

    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(items.ObjectGround(referencePosition=[0.0, 0.0, 0.0]))
    previous = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground))
    sensor = 0
    for i in range(n):
        if isinstance(rod, RigidBody):
            number = mbs.CreateRigidBody(
                referencePosition=[(i + 0.5) * LENGTH, 0.0, 0.0],
                inertia=RigidBodyInertia(mass=rod.mass, inertiaTensor=np.array(rod.inertia)),
                gravity=list(GRAVITY),
            )
            near, far = (
                mbs.AddMarker(
                    items.MarkerBodyPosition(bodyNumber=number, localPosition=[side * LENGTH / 2, 0, 0])
                )
                for side in (-1, 1)
            )
            if i == n - 1:
                sensor = mbs.AddSensor(
                    items.SensorBody(
                        bodyNumber=number,
                        localPosition=[LENGTH / 2, 0, 0],
                        storeInternal=True,
                        outputVariableType=exu.OutputVariableType.Position,
                    )
                )
        else:
            loaded = ObjectFFRFreducedOrderInterface()
            loaded.LoadFromFile(str(file))
            number = loaded.AddObjectFFRFreducedOrder(
                mbs, positionRef=[i * LENGTH, 0.0, 0.0], gravity=list(GRAVITY)
            )["oFFRFreducedOrder"]
            near, far = (
                mbs.AddMarker(
                    items.MarkerSuperElementPosition(
                        bodyNumber=number,
                        meshNodeNumbers=nodes,
                        weightingFactors=[1 / len(nodes)] * len(nodes),
                    )
                )
                for nodes in (interface_nodes(rod, "near"), interface_nodes(rod, "far"))
            )
            if i == n - 1:
                sensor = mbs.AddSensor(
                    items.SensorMarker(
                        markerNumber=far,
                        storeInternal=True,
                        outputVariableType=exu.OutputVariableType.Position,
                    )
                )
        mbs.AddObject(items.SphericalJoint(markerNumbers=[previous, near]))
        previous = far
    mbs.Assemble()
    return timed_run(
        mbs,
        sensor,
        duration=DURATION,
        step=STEP,
        output_step=OUTPUT_STEP,
        tolerance=TOLERANCE,
        modified_newton=modified_newton,
        linear_solver=linear_solver,
    )


RODS = {"rigid": rigid_rod, "flexible": flexible_rod}


def row(kind: str, rod: Any, n: int, file: Path) -> dict[str, Any]:
    runs = {"supple": in_supple(rod, n), "quick": in_supple(rod, n, QUICK_MARCH)}
    if find_spec("exudyn"):
        for newton, solver in product((True, False), ("EXUdense", "EigenSparse")):
            runs[f"exudyn {newton} {solver}"] = in_exudyn(
                rod, n, file, modified_newton=newton, linear_solver=solver
            )
    if MUJOCO and kind == "rigid":
        across, along = rod.inertia[1, 1], rod.inertia[0, 0]
        runs["mujoco"] = in_mujoco(
            n, rod.mass, LENGTH / 2, (along, across, across), duration=DURATION, step=STEP, gravity=GRAVITY[2]
        )
    best = best_of({code: by_processor(run) for code, run in runs.items()}, REPEATS)
    steps, iterations, seconds, tip = best["supple"]
    theirs = {code: 1e6 * own[2] / own[0] for code, own in best.items()}
    exudyn = [cost for code, cost in theirs.items() if code.startswith("exudyn")]
    compiled = compile_seconds(kind, n)
    return {
        "kind": kind,
        "bodies": n,
        "compile_s": compiled[0],
        "compile_well_s": compiled[1],
        "us_per_step": 1e6 * seconds / steps,
        "quick_us_per_step": theirs["quick"],
        "exudyn_us_per_step": min(exudyn, default=None),
        "mujoco_us_per_step": theirs.get("mujoco"),
        "iterations_per_step": iterations / steps,
        "ends_apart_m": max(
            (
                float(np.linalg.norm(tip[-1] - own[3][-1]))
                for code, own in best.items()
                if code not in ("supple", "quick")
            ),
            default=None,
        ),
    }


def in_own_process(kind: str, n: int) -> None:
    system = chain(RODS[kind](), n)
    began = process_time()
    cost = simulate(system, run_options()).statistics
    first = process_time() - began - cost.seconds
    model, state = initial_state(system, 0.0, STEP)
    began = process_time()
    COMPILED_MARCH.compiled(model, controls(run_options()), state, run_options().times[1:])
    print(first, process_time() - began)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="chains of 1 and 8 bodies")
    parser.add_argument("--json", type=Path, help="file to write; default: in benchmarks/results")
    parser.add_argument("--only", nargs=2, metavar=("KIND", "BODIES"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.only:
        in_own_process(options.only[0], int(options.only[1]))
        return
    rows = []
    with TemporaryDirectory() as folder:
        for kind, make in RODS.items():
            rod = make()
            file = Path(folder) / "rod.npz"
            if isinstance(rod, ReducedBody):
                file = write_exudyn(file, rod)
            rows += [row(kind, rod, n, file) for n in (QUICK if options.quick else NUMBERS)]
    peers = {name: version(name) for name in ("exudyn", "mujoco") if find_spec(name)}
    keep("chain", rows, options.json, **peers)


if __name__ == "__main__":
    main()
