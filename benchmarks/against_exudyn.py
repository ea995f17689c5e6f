"""A linear body with 12 modes on a ball joint, in supple and in Exudyn, one after the other in one run.

A steel bar of 10-node tetrahedra hangs by the mean of one end face and swings under gravity from the
horizontal. Both codes use its 12 lowest free elastic modes, generalized-alpha with rho_inf = 0.8, the same
step and the same relative Newton tolerance. Exudyn (BSD licence) is not a dependency: pip install exudyn.
"""

from __future__ import annotations

import sys
from time import perf_counter

import numpy as np
from measure import keep
from scipy.sparse import csr_matrix

from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Tolerances
from supple.mesh import CellType, block
from supple.multibody import GROUND, At, Ball, Placed, System, simulate
from supple.reduction import NoDerivatives, NormalModes, reduce
from supple.results import node_positions

DURATION, STEP, N_MODES, TOLERANCE = 2.0, 1e-3, 12, 1e-6
GRAVITY = (0.0, 0.0, -9.81)


def bar():
    mesh = block(1.0, 0.02, 0.02, 20, 1, 1, CellType.TETRA10)
    model = solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0))
    body = flexible_body("bar", model, [AveragingInterface("root", "root")])
    return mesh, body


def in_supple(mesh, body) -> tuple[dict, np.ndarray]:
    small = reduce(body.linearized(), MeanAxisFrame(), NormalModes(N_MODES), derivatives=NoDerivatives())
    system = System(
        bodies=(Placed(small),),
        joints=(Ball(first=GROUND, second=At("bar", "root")),),
        gravity=GRAVITY,
    )
    options = {
        "duration": DURATION,
        "output_step": 0.02,
        "step": FixedStep(STEP),
        "method": GeneralizedAlpha(0.8),
        "tolerances": Tolerances(TOLERANCE),
    }
    simulate(system, **options)
    solution = simulate(system, **options)
    cost = solution.statistics
    tip = node_positions(small, solution.bodies["bar"], mesh.nodes_of("tip")).mean(axis=1)
    row = {
        "code": "supple",
        "steps": cost.steps,
        "iterations": cost.iterations,
        "us per iteration": 1e6 * cost.seconds / cost.iterations,
        "us per step": 1e6 * cost.seconds / cost.steps,
    }
    return row, tip[-1]


def in_exudyn(mesh, body) -> tuple[dict, np.ndarray]:
    try:
        import exudyn as exu
        from exudyn import itemInterface as items  # noqa: N813
        from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
    except ImportError:
        sys.exit("this comparison needs Exudyn: pip install exudyn")

    finite_elements = FEMinterface()
    finite_elements.nodes = {"Position": np.array(mesh.nodes)}
    finite_elements.massMatrix = csr_matrix(body.mass)
    finite_elements.stiffnessMatrix = csr_matrix(body.stiffness)
    finite_elements.ComputeEigenmodes(nModes=N_MODES, excludeRigidBodyModes=6, useSparseSolver=False)
    reduced = ObjectFFRFreducedOrderInterface(finite_elements)

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    added = reduced.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], gravity=list(GRAVITY))
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
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(DURATION / STEP)
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.relativeTolerance = TOLERANCE
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.02
    began = perf_counter()
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    seconds = perf_counter() - began
    iterations = mbs.sys["dynamicSolver"].it.newtonStepsCount
    history = mbs.GetSensorStoredData(sensor)
    steps = settings.timeIntegration.numberOfSteps
    row = {
        "code": f"Exudyn {exu.config.Version() if hasattr(exu, 'config') else exu.GetVersionString()}",
        "steps": steps,
        "iterations": int(iterations),
        "us per iteration": 1e6 * seconds / iterations,
        "us per step": 1e6 * seconds / steps,
    }
    return row, history[-1, 1:4]


def main() -> None:
    mesh, body = bar()
    ours, our_tip = in_supple(mesh, body)
    theirs, their_tip = in_exudyn(mesh, body)
    for row in (ours, theirs):
        row["step, ratio to Exudyn"] = row["us per step"] / theirs["us per step"]
        row["tips apart, m"] = float(np.linalg.norm(our_tip - their_tip))
    keep("against_exudyn", [ours, theirs])


if __name__ == "__main__":
    main()
