"""The slider-crank of [Han2020] section 5.2: a rigid crank, a flexible aluminium rod, a slider.

The paper gives the rod's material, 4380 tetrahedra of 3.6 mm on average (1 mm at least), the total mass
(5.407 kg), the torque (ramped to 1 Nm at 0.1 s) and 0.5 s; the drawings with the dimensions are not in its
text. Values chosen here: a rod of 0.14 m between bores of 15 and 8 mm in radius, which fits this number and
size of tetrahedra; a crank of 0.03 m; a slider of 0.5 kg; the crank's disc has the remaining mass. The crank
starts at right angles to the slider's path, at rest, without gravity.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.integrate import cumulative_simpson

from supple.body import FullBody, RigidBody, RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.integrate import FloatingMotion, Solution
from supple.machine import GROUND, At, DeadTorque, Placed, Prismatic, Revolute, System, Table
from supple.mesh import (
    CellType,
    Mesh,
    RodCells,
    block,
    connecting_rod,
    cylinder,
)
from supple.reduction import ReducedBody
from supple.results.camera import Camera
from supple_benchmarks.han2020_bodies import ALUMINIUM, ROD
from supple_benchmarks.machines.flexible_machine import FlexibleMachine

__all__ = ["SliderCrank", "slider_position"]

CRANK_RADIUS, TOTAL_MASS, SLIDER_MASS = 0.03, 5.407, 0.5
DISC_RADIUS, DISC_THICKNESS = 0.05, 0.03
TORQUE, RAMP = 1.0, 0.1
AXIS = (0.0, 0.0, 1.0)
FLEXIBLE = "rod"


@dataclass(frozen=True)
class SliderCrank:
    """Size of the benchmark.

    cell_type : TETRA4 or TETRA10       cells : of the rod
    n_modes : modal coordinates N_m     stiffness : factor on the paper's modulus
    tolerances : e, of the eigenvalues
    duration, output_step : s           step : s, of the runs that are compared
    """

    cell_type: CellType = CellType.TETRA10
    cells: RodCells = field(default_factory=RodCells)
    n_modes: int = 10
    stiffness: float = 1.0
    tolerances: tuple[float, ...] = (0.1, 0.01, 0.001)
    duration: float = 0.5
    output_step: float = 0.001
    step: float = 1e-4

    @classmethod
    def quick(cls) -> SliderCrank:
        """A coarse mesh of four-node tetrahedra for a twentieth of a second."""
        return cls(
            cell_type=CellType.TETRA4,
            cells=RodCells(around=9, ring=1, shank=8, width=3, thickness=1),
            tolerances=(0.1, 0.01),
            duration=0.05,
            output_step=0.002,
            step=5e-4,
        )

    def mesh(self) -> Mesh:
        """The connecting rod, 4374 tetrahedra at the paper's size."""
        return connecting_rod(ROD, self.cells, self.cell_type)

    def machine(self) -> FlexibleMachine:
        """The slider-crank with its run settings."""
        mesh = self.mesh()
        material = Isotropic(
            self.stiffness * ALUMINIUM.youngs_modulus, ALUMINIUM.poissons_ratio, ALUMINIUM.density
        )
        model = solid_model(mesh, material)
        bores = [
            RigidInterface("big", "big_bore", position=(0.0, 0.0, 0.0)),
            RigidInterface("small", "small_bore", position=(ROD.length, 0.0, 0.0)),
        ]
        body = flexible_body(FLEXIBLE, model, bores).linearized()
        rod_mass = float(body.rigid_modes[:, 0] @ (body.mass @ body.rigid_modes[:, 0]))
        # Node A: on the shank's upper edge near the big eye, where bending and the notch raise the stress.
        edge = [ROD.big.chord, 0.5 * ROD.big.shank_width, 0.5 * ROD.thickness]
        return FlexibleMachine(
            name="slider-crank",
            body=body,
            model=model,
            material=material,
            system=lambda flexible: _system(flexible, rod_mass),
            work=_work,
            looks={"crank": _disc(), "slider": _block()},
            point=int(np.argmin(np.linalg.norm(mesh.nodes - edge, axis=1))),
            size=ROD.length,
            n_modes=self.n_modes,
            duration=self.duration,
            output_step=self.output_step,
            step=self.step,
            compared_from=0.0,  # the torque increases from zero
            camera=Camera.looking(along=(0.25, -0.35, -1.0), up=(0.0, 1.0, 0.0)),
        )


def slider_position(angle: np.ndarray) -> np.ndarray:
    """Position of the slider's pin with a rigid rod, for crank angles from the slider's path, m."""
    return CRANK_RADIUS * np.cos(angle) + np.sqrt(ROD.length**2 - (CRANK_RADIUS * np.sin(angle)) ** 2)


def _system(rod: FullBody | ReducedBody, rod_mass: float) -> System:
    mass = TOTAL_MASS - SLIDER_MASS - rod_mass
    across = mass * (3 * DISC_RADIUS**2 + DISC_THICKNESS**2) / 12
    crank = RigidBody(
        "crank",
        mass,
        np.zeros(3),
        np.diag([across, across, 0.5 * mass * DISC_RADIUS**2]),
        {"shaft": np.zeros(3), "pin": np.array([CRANK_RADIUS, 0.0, 0.0])},
    )
    slider = RigidBody("slider", SLIDER_MASS, np.zeros(3), 1e-4 * np.eye(3), {"pin": np.zeros(3)})
    end = np.array([np.sqrt(ROD.length**2 - CRANK_RADIUS**2), 0.0, 0.0])
    pin = np.array([0.0, CRANK_RADIUS, 0.0])
    slope = np.arcsin(CRANK_RADIUS / ROD.length)
    # Clockwise, so that the crank first pushes the slider outwards.
    ramp = Table([0.0, RAMP, 1e3], [[0.0, 0.0, 0.0], [0.0, 0.0, -TORQUE], [0.0, 0.0, -TORQUE]])
    return System(
        bodies=(
            Placed(crank, rotation=np.array([0.0, 0.0, 0.5 * np.pi])),
            Placed(rod, position=pin, rotation=np.array([0.0, 0.0, -slope])),
            Placed(slider, position=end),
        ),
        joints=(
            Revolute(first=GROUND, second=At("crank", "shaft"), axis=AXIS, name="shaft"),
            Revolute(first=At("crank", "pin"), second=At(FLEXIBLE, "big"), axis=AXIS, name="crank pin"),
            Revolute(first=At(FLEXIBLE, "small"), second=At("slider", "pin"), axis=AXIS, name="slider pin"),
            Prismatic(first=GROUND, second=At("slider", "pin"), axis=(1.0, 0.0, 0.0), name="guide"),
        ),
        loads=(DeadTorque(first=At("crank", "shaft"), torque=ramp),),
    )


def _work(solution: Solution) -> np.ndarray:
    """Work of the torque, by Simpson's rule on the output times, J."""
    torque = -TORQUE * np.minimum(solution.times / RAMP, 1.0)
    power = torque * solution.motion("crank", FloatingMotion).angular_velocity[:, 2]
    return cumulative_simpson(power, x=solution.times, initial=0.0)


def _disc() -> Mesh:
    """The crank's disc with its axis along z, drawn behind the rod."""
    along_x = cylinder(DISC_RADIUS, DISC_THICKNESS, 4, 2, 1, CellType.TETRA4)
    return replace(along_x, nodes=along_x.nodes[:, [1, 2, 0]] - [0.0, 0.0, DISC_THICKNESS + ROD.thickness])


def _block() -> Mesh:
    """The slider, behind and in front of the rod's small eye."""
    mesh = block(0.04, 0.034, 0.034, 3, 3, 3, CellType.TETRA4)
    return replace(mesh, nodes=mesh.nodes + np.array([0.004, 0.0, 0.0]))
