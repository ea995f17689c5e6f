"""Chains of equal bodies: compile time, and time per step and body, beside Exudyn.

Run with one thread: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/chain.py
Rods on ball joints, hung at one end, fall from rest along x. Rigid rods, and slender solid ones by eight
fixed-interface modes and the constraint modes of their two ends, in a mean-axis frame. Compiling is measured
in a process without kept programs; steps in turns with Exudyn, which solves the same equations.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
from exudyn_run import TimedRun, best_of, exudyn, timed_run
from measure import keep

from supple.body import AveragingInterface, MeanAxisFrame, RigidBody, flexible_body
from supple.export import interface_nodes, write_exudyn
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, NoDerivatives, ReducedBody, reduce
from supple.simulation import simulate

NUMBERS = (1, 2, 4, 8, 16, 32)
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
    return reduce(body, MeanAxisFrame(), CraigBampton(n_modes=8), derivatives=NoDerivatives())


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


def in_supple(rod: Any, n: int) -> TimedRun:
    system, run = chain(rod, n), run_options()

    def timed() -> Any:
        solution = simulate(system, run)
        cost = solution.statistics
        last = system.bodies[-1].body
        tip = solution.bodies[last.name]
        place = np.asarray(last.interface("far").position)
        if isinstance(last, ReducedBody):
            place = place + (tip.coordinates @ last.interface("far").motion.T)[:, :3]
        position = tip.position + np.einsum(
            "tij,tj->ti", tip.rotation, np.broadcast_to(place, tip.position.shape)
        )
        return cost.steps, cost.iterations, cost.seconds, position

    return timed


def compile_seconds(kind: str, n: int) -> float:
    """Wall time from the system to the first state, in a new process that finds no kept programs."""
    with TemporaryDirectory() as folder:
        shown = subprocess.run(
            [sys.executable, __file__, kind, str(n)],
            env=os.environ | {"JAX_COMPILATION_CACHE_DIR": folder},
            capture_output=True,
            text=True,
            check=True,
        )
    return float(shown.stdout.split()[-1])


def in_exudyn(rod: Any, n: int, file: Path) -> TimedRun:
    exu = exudyn()
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
        modified_newton=True,
    )


RODS = {"rigid": rigid_rod, "flexible": flexible_rod}


def row(kind: str, rod: Any, n: int, file: Path) -> dict[str, Any]:
    runs = {"supple": in_supple(rod, n), "Exudyn": in_exudyn(rod, n, file)}
    best = best_of(runs, REPEATS)
    steps, iterations, seconds, tip = best["supple"]
    _, _, their_seconds, their_tip = best["Exudyn"]
    return {
        "bodies": f"{n} {kind}",
        "start and compile, s": compile_seconds(kind, n),
        "iterations / step": iterations / steps,
        "us / step and body": 1e6 * seconds / steps / n,
        "Exudyn, modified Newton, us / step and body": 1e6 * their_seconds / steps / n,
        "ends apart, m": float(np.linalg.norm(tip[-1] - their_tip[-1])),
    }


def main() -> None:
    if len(sys.argv) == 3:  # the process of its own
        system = chain(RODS[sys.argv[1]](), int(sys.argv[2]))
        began = perf_counter()
        cost = simulate(system, run_options()).statistics
        print(perf_counter() - began - cost.seconds)
        return
    rows = []
    with TemporaryDirectory() as folder:
        for kind, make in RODS.items():
            rod = make()
            file = Path(folder) / "rod.npz"
            if isinstance(rod, ReducedBody):
                file = write_exudyn(file, rod)
            rows += [row(kind, rod, n, file) for n in NUMBERS]
    keep("chain", rows, exudyn=version("exudyn"))


if __name__ == "__main__":
    main()
