"""A linear body with 12 modes on a ball joint, in supple and in Exudyn, one after the other in one run.

A steel bar of 10-node tetrahedra, on a ball joint at the mean motion of one end face, swings under gravity
from the horizontal. Both codes use its 12 lowest free elastic modes, generalized-alpha with rho_inf = 0.8,
the same step, the same relative Newton tolerance and one thread. Exudyn runs twice: with Newton's method, and
with the modified Newton method (its default), which keeps the Jacobian as long as the iteration converges.
The tips of the two codes are closer to each other than to the exact motion, and converge at second order in
the step.

Exudyn (BSD licence) is not a dependency: pip install exudyn==1.13.6
Run: OMP_NUM_THREADS=1 taskset -c 0 python benchmarks/against_exudyn.py
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from exudyn_run import Outcome, TimedRun, best_of, exudyn, march_as_long_runs_do, timed_run
from measure import keep
from scipy.sparse import csr_matrix

from supple.body import AveragingInterface, FlexibleBody, MeanAxisFrame, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType, Mesh, block
from supple.quantities import node_positions
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.simulation import simulate

DURATION, STEP, OUTPUT_STEP, N_MODES, TOLERANCE = 2.0, 1e-3, 0.02, 12, 1e-6
GRAVITY = (0.0, 0.0, -9.81)
REPEATS = 5


def bar() -> tuple[Mesh, FlexibleBody]:
    mesh = block(1.0, 0.02, 0.02, 20, 1, 1, CellType.TETRA10)
    model = solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0))
    body = flexible_body("bar", model, [AveragingInterface("root", "root")])
    return mesh, body


def in_supple(mesh: Mesh, body: FlexibleBody) -> TimedRun:
    small = reduce(
        body.linearized(), MeanAxisFrame(), NormalModes(N_MODES), derivatives=NoDerivatives(), loads=NoLoads
    )
    system = System(
        bodies=(Placed(small),),
        joints=(Ball(first=GROUND, second=At("bar", "root")),),
        gravity=GRAVITY,
    )

    def run() -> Outcome:
        solution = simulate(
            system,
            Run(
                duration=DURATION,
                output_step=OUTPUT_STEP,
                step=FixedStep(STEP),
                method=GeneralizedAlpha(0.8),
                tolerances=Tolerances(TOLERANCE),
            ),
        )
        cost = solution.statistics
        tip = node_positions(small, solution.bodies["bar"], mesh.nodes_of("tip")).mean(axis=1)
        return cost.steps, cost.iterations, cost.seconds, tip

    return run


def reduced_in_exudyn(mesh: Mesh, body: FlexibleBody) -> Any:
    """The body with its lowest modes, reduced by Exudyn."""
    exudyn()
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    finite_elements = FEMinterface()
    finite_elements.nodes = {"Position": np.array(mesh.nodes)}
    finite_elements.massMatrix = csr_matrix(body.mass)
    finite_elements.stiffnessMatrix = csr_matrix(body.stiffness)
    finite_elements.ComputeEigenmodes(nModes=N_MODES, excludeRigidBodyModes=6, useSparseSolver=False)
    return ObjectFFRFreducedOrderInterface(finite_elements)


def assembled_in_exudyn(mesh: Mesh, reduced: Any, gravity: Sequence[float]) -> tuple[Any, int]:
    """The assembled system, and the number of the sensor at its tip."""
    exu = exudyn()
    from exudyn import itemInterface as items  # noqa: N813

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    added = reduced.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], gravity=list(gravity))
    number = added["oFFRFreducedOrder"]

    def mean_of(nodes: np.ndarray) -> int:
        weights = np.full(len(nodes), 1 / len(nodes))
        return mbs.AddMarker(
            items.MarkerSuperElementPosition(
                bodyNumber=number, meshNodeNumbers=[int(n) for n in nodes], weightingFactors=list(weights)
            )
        )

    root, tip = mesh.nodes_of("root"), mesh.nodes_of("tip")
    ground = mbs.AddObject(
        items.ObjectGround(referencePosition=[float(x) for x in mesh.nodes[root].mean(axis=0)])
    )
    on_ground = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground))
    mbs.AddObject(items.SphericalJoint(markerNumbers=[on_ground, mean_of(root)]))
    sensor = mbs.AddSensor(
        items.SensorMarker(
            markerNumber=mean_of(tip), storeInternal=True, outputVariableType=exu.OutputVariableType.Position
        )
    )
    mbs.Assemble()
    return mbs, sensor


def in_exudyn(mesh: Mesh, body: FlexibleBody, *, modified_newton: bool) -> TimedRun:
    mbs, sensor = assembled_in_exudyn(mesh, reduced_in_exudyn(mesh, body), GRAVITY)
    return timed_run(
        mbs,
        sensor,
        duration=DURATION,
        step=STEP,
        output_step=OUTPUT_STEP,
        tolerance=TOLERANCE,
        modified_newton=modified_newton,
    )


def main() -> None:
    march_as_long_runs_do()
    mesh, body = bar()
    runs = {
        "supple": in_supple(mesh, body),
        "Exudyn": in_exudyn(mesh, body, modified_newton=False),
        "Exudyn, modified Newton": in_exudyn(mesh, body, modified_newton=True),
    }
    best = best_of(runs, REPEATS)
    _, _, our_seconds, our_tip = best["supple"]
    rows = [
        {
            "code": code,
            "steps": int(steps),
            "iterations / step": iterations / steps,
            "us / iteration": 1e6 * seconds / iterations,
            "us / step": 1e6 * seconds / steps,
            "time, of supple's": seconds / our_seconds,
            "tips apart, m": float(np.linalg.norm(tip - our_tip, axis=1).max()),
        }
        for code, (steps, iterations, seconds, tip) in best.items()
    ]
    keep("against_exudyn", rows, exudyn=version("exudyn"))


if __name__ == "__main__":
    main()
