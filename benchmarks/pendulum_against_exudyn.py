"""The quadruple pendulum in supple and in Exudyn, one after the other in one run: cost of a step.

Three rigid cylinders and a flexible one on ball joints fall under gravity [Han2020]. supple reduces the
flexible link to 30 modal coordinates, each eigenvalue within 1 %, and writes it with `write_exudyn`; Exudyn
loads that file. Both use generalized-alpha with rho_inf = 0.8, the same step, the same relative Newton
tolerance and one thread. Exudyn runs twice: with Newton's method, and with the modified Newton method (its
default), which keeps the Jacobian as long as the iteration converges. The positions of the free end are
compared; their difference decreases with the step.

Exudyn (BSD licence) is not a dependency: pip install exudyn==1.13.6
Run: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/pendulum_against_exudyn.py
"""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from exudyn_run import Outcome, TimedRun, best_of, exudyn, march_as_long_runs_do, timed_run
from measure import keep

from supple.body import RigidBody
from supple.export import interface_nodes, write_exudyn
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import System
from supple.mesh import CellType
from supple.quantities import node_positions
from supple.reduction import ErrorControlled, NoDerivatives, NoLoads, ReducedBody, reduce
from supple.simulation import simulate
from supple_benchmarks.machines.quadruple_pendulum import GRAVITY, QuadruplePendulum

DURATION, OUTPUT_STEP, STEPS, TOLERANCE, REPEATS = 1.0, 0.02, (1e-3, 5e-4), 1e-6, 5


def in_supple(system: System, link: ReducedBody, end: int, step: float) -> TimedRun:
    def run() -> Outcome:
        solution = simulate(
            system,
            Run(
                duration=DURATION,
                output_step=OUTPUT_STEP,
                step=FixedStep(step),
                method=GeneralizedAlpha(0.8),
                tolerances=Tolerances(TOLERANCE),
            ),
        )
        cost = solution.statistics
        return (
            cost.steps,
            cost.iterations,
            cost.seconds,
            node_positions(link, solution.bodies[link.name], [end])[:, 0],
        )

    return run


def in_exudyn(system: System, file: Path, end: int, step: float, *, modified_newton: bool) -> TimedRun:
    exu = exudyn()
    from exudyn import itemInterface as items  # noqa: N813

    mbs = exu.SystemContainer().AddSystem()
    joints = _add_bodies(mbs, items, system, file)
    for first, second in joints[:-1]:
        mbs.AddObject(items.SphericalJoint(markerNumbers=[first, second]))
    flexible = joints[-1][0]
    sensor = mbs.AddSensor(
        items.SensorSuperElement(
            bodyNumber=flexible,
            meshNodeNumber=end,
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    return timed_run(
        mbs,
        sensor,
        duration=DURATION,
        step=step,
        output_step=OUTPUT_STEP,
        tolerance=TOLERANCE,
        modified_newton=modified_newton,
    )


def _add_bodies(mbs: Any, items: Any, system: System, file: Path) -> list[tuple[int, int]]:
    """Add ground and bodies; marker pairs of the joints, and last (number of the flexible body, 0)."""
    from exudyn.FEM import ObjectFFRFreducedOrderInterface
    from exudyn.rigidBodyUtilities import RigidBodyInertia

    first = system.bodies[0]
    start = first.position + first.rotation @ first.body.interface("near").position
    ground = mbs.AddObject(items.ObjectGround(referencePosition=start.tolist()))
    previous, pairs = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground)), []
    for placed in system.bodies:
        body, axes = placed.body, placed.rotation
        if isinstance(body, RigidBody):
            number = mbs.CreateRigidBody(
                referencePosition=(placed.position + axes @ body.centre).tolist(),
                referenceRotationMatrix=axes,
                inertia=RigidBodyInertia(mass=body.mass, inertiaTensor=np.array(body.inertia)),
                gravity=list(GRAVITY),
            )
            near, far = (
                mbs.AddMarker(
                    items.MarkerBodyPosition(
                        bodyNumber=number,
                        localPosition=(body.interface(name).position - body.centre).tolist(),
                    )
                )
                for name in ("near", "far")
            )
            pairs.append((previous, near))
            previous = far
            continue
        loaded = ObjectFFRFreducedOrderInterface()
        loaded.LoadFromFile(str(file))
        number = loaded.AddObjectFFRFreducedOrder(
            mbs, positionRef=placed.position.tolist(), rotationMatrixRef=axes, gravity=list(GRAVITY)
        )["oFFRFreducedOrder"]
        nodes = interface_nodes(body, "near")
        marker = items.MarkerSuperElementPosition(
            bodyNumber=number, meshNodeNumbers=nodes, weightingFactors=[1 / len(nodes)] * len(nodes)
        )
        pairs += [(previous, mbs.AddMarker(marker)), (number, 0)]
    return pairs


def main() -> None:
    march_as_long_runs_do()
    machine = QuadruplePendulum(cell_type=CellType.TETRA4).machine()
    link = reduce(
        machine.body,
        machine.frame,
        ErrorControlled(0.01, machine.n_modes),
        derivatives=NoDerivatives(),
        loads=NoLoads,
    )
    system = machine.system(link)
    end = int(machine.model.mesh.nodes_of("tip")[0])
    rows = []
    with TemporaryDirectory() as folder:
        file = write_exudyn(Path(folder) / "link.npz", link)
        for step in STEPS:
            runs = {
                "supple": in_supple(system, link, end, step),
                "Exudyn": in_exudyn(system, file, end, step, modified_newton=False),
                "Exudyn, modified Newton": in_exudyn(system, file, end, step, modified_newton=True),
            }
            rows += _compared(step, runs)
    keep("pendulum_against_exudyn", rows, exudyn=version("exudyn"))


def _compared(step: float, runs: dict[str, Run]) -> list[dict[str, Any]]:
    """Rows with the best of several alternating runs of each code."""
    best = best_of(runs, REPEATS)
    _, _, our_seconds, our_end = best["supple"]
    return [
        {
            "step, s": step,
            "code": code,
            "iterations / step": iterations / steps,
            "us / step": 1e6 * seconds / steps,
            "time, of supple's": seconds / our_seconds,
            "ends apart, m": float(np.linalg.norm(end - our_end, axis=1).max()),
        }
        for code, (steps, iterations, seconds, end) in best.items()
    ]


if __name__ == "__main__":
    main()
