"""A reduced body written by supple, loaded by Exudyn: the same pendulum, the same modes, the same step.

A steel cylinder of 10-node tetrahedra, on a ball joint or a hinge at the mean motion of one end face, swings
from the horizontal under gravity with a lateral component. supple reduces it once (12 free modes and the
attachment modes of the two ends) and writes it with `write_exudyn`. Exudyn loads that file; joint, sensors
and stress refer to the exported nodes. Both use generalized-alpha with rho_inf = 0.8.

The remaining difference between the tips is due to the time integration, and falls by a factor of four when
the step is halved; so does the difference of the stress on the ball joint. A hinge also transmits a moment,
and Exudyn's marker transmits moments through the small rotations of its nodes. This causes a stress
difference of the order of the elastic rotation at the hinge: 4e-4 of the largest stress here at any step, and
a tenth of that with a tenth of the gravity.

Exudyn (BSD licence) is not a dependency: pip install exudyn==1.13.6
Run: OMP_NUM_THREADS=1 python benchmarks/exported_to_exudyn.py
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from measure import keep

from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
from supple.export import interface_nodes, write_exudyn
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, Ball, Joint, Placed, Revolute, System
from supple.mesh import CellType, cylinder, skin_of
from supple.quantities import TensorModes, stress_modes
from supple.reduction import NoDerivatives, NoLoads, ReducedBody, Rubin, reduce
from supple.simulation import simulate

DURATION, OUTPUT_STEP, STEPS, TOLERANCE = 1.0, 0.02, (2e-3, 1e-3, 5e-4, 2.5e-4), 1e-10
GRAVITY = (0.0, 3.0, -9.81)
LENGTH, RADIUS = 1.0, 0.01


@dataclass(frozen=True, eq=False)
class Pendulum:
    """The reduced link, its stress modes, the surface triangles of its mesh, and the node of the stress."""

    link: ReducedBody
    stress: TensorModes
    triangles: np.ndarray
    node: int


@dataclass(frozen=True)
class Hold:
    """A joint between the ground and the root in supple, and the six axes that it locks in Exudyn."""

    name: str
    joint: Joint
    locked: tuple[int, ...]


HOLDS = (
    Hold("ball", Ball(first=GROUND, second=At("link", "root")), (1, 1, 1, 0, 0, 0)),
    Hold(
        "hinge", Revolute(first=GROUND, second=At("link", "root"), axis=(0.0, 1.0, 0.0)), (1, 1, 1, 1, 0, 1)
    ),
)


@dataclass(frozen=True, eq=False)
class Swing:
    """Tip positions (t, 3), m, and stress (t, 6) at the node, Pa."""

    tip: np.ndarray
    stress: np.ndarray


def pendulum() -> Pendulum:
    mesh = cylinder(RADIUS, LENGTH, 2, 1, 40, CellType.TETRA10)
    model = solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0))
    ends = [AveragingInterface("root", "root"), AveragingInterface("tip", "tip")]
    body = flexible_body("link", model, ends).linearized()
    link = reduce(body, MeanAxisFrame(), Rubin(n_modes=12), derivatives=NoDerivatives(), loads=NoLoads)
    surface_point = np.array([LENGTH / 2, 0.0, RADIUS])
    node = int(np.argmin(np.linalg.norm(mesh.nodes - surface_point, axis=1)))
    return Pendulum(link, stress_modes(link, model), skin_of(mesh).triangles, node)


def in_supple(given: Pendulum, hold: Hold, step: float) -> Swing:
    link = given.link
    motion = simulate(
        System(bodies=(Placed(link),), joints=(hold.joint,), gravity=GRAVITY),
        Run(
            duration=DURATION,
            output_step=OUTPUT_STEP,
            step=FixedStep(step),
            method=GeneralizedAlpha(0.8),
            tolerances=Tolerances(TOLERANCE),
        ),
    ).bodies["link"]
    tip = link.interface("tip")
    local = tip.position + motion.coordinates @ tip.motion[:3].T
    position = motion.position + np.einsum("tij,tj->ti", motion.rotation, local)
    return Swing(position, given.stress.at(motion.coordinates)[:, given.node, 0])


def in_exudyn(given: Pendulum, hold: Hold, file: Path, step: float) -> Swing:
    try:
        import exudyn as exu
        from exudyn import itemInterface as items  # noqa: N813
        from exudyn.FEM import ObjectFFRFreducedOrderInterface
    except ImportError:
        sys.exit("this comparison needs Exudyn, which is not installed here: pip install exudyn==1.13.6")

    mbs = exu.SystemContainer().AddSystem()
    loaded = ObjectFFRFreducedOrderInterface()
    loaded.LoadFromFile(str(file))
    number = loaded.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], gravity=list(GRAVITY))[
        "oFFRFreducedOrder"
    ]

    def end(name: str) -> int:
        nodes = interface_nodes(given.link, name)
        return mbs.AddMarker(
            items.MarkerSuperElementRigid(
                bodyNumber=number, meshNodeNumbers=nodes, weightingFactors=[1 / len(nodes)] * len(nodes)
            )
        )

    place = [float(x) for x in given.link.interface("root").position]
    ground = mbs.AddObject(items.ObjectGround(referencePosition=place))
    on_ground = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
    mbs.AddObject(
        items.GenericJoint(markerNumbers=[on_ground, end("root")], constrainedAxes=list(hold.locked))
    )
    kinds = exu.OutputVariableType
    tip = mbs.AddSensor(
        items.SensorMarker(markerNumber=end("tip"), storeInternal=True, outputVariableType=kinds.Position)
    )
    stress = mbs.AddSensor(
        items.SensorSuperElement(
            bodyNumber=number,
            meshNodeNumber=given.node,
            storeInternal=True,
            outputVariableType=kinds.StressLocal,
        )
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(DURATION / step)
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.relativeTolerance = TOLERANCE
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = OUTPUT_STEP
    settings.parallel.numberOfThreads = 1
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
    return Swing(mbs.GetSensorStoredData(tip)[:, 1:], mbs.GetSensorStoredData(stress)[:, 1:])


def main() -> None:
    given = pendulum()
    rows = []
    with TemporaryDirectory() as folder:
        file = write_exudyn(
            Path(folder) / "link.npz", given.link, triangles=given.triangles, stress=given.stress
        )
        for hold in HOLDS:
            apart = None
            for step in STEPS:
                ours, theirs = in_supple(given, hold, step), in_exudyn(given, hold, file, step)
                before, apart = apart, float(np.linalg.norm(ours.tip - theirs.tip, axis=1).max())
                largest = np.abs(ours.stress).max()
                rows.append(
                    {
                        "joint": hold.name,
                        "step, s": step,
                        "tips apart, m": apart,
                        "falls by": before and before / apart,
                        "stress apart, of its largest": float(
                            np.abs(ours.stress - theirs.stress).max() / largest
                        ),
                    }
                )
    keep("exported_to_exudyn", rows, exudyn=version("exudyn"))


if __name__ == "__main__":
    main()
