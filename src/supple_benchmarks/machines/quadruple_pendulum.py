"""The quadruple pendulum of [Han2020] section 5.1: three rigid cylinders and a flexible one on ball joints.

The paper gives the cylinders (0.3 m long, 0.015 m in radius), the distance of 0.05 m from a joint to a
cylinder, the material, gravity along -y, 7 s and 500 outputs. The start position of the chain is given by a
drawing only. Here the links point in the directions 0, 30, 60 and 90 degrees in the horizontal plane, so that
the motion has components in all three directions. The flexible link is attached by the mean motion of one end
face; its other end is free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import AveragingInterface, FullBody, RigidBody, flexible_body
from supple.fem import Isotropic, solid_model
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType, Mesh, cylinder
from supple.reduction import ReducedBody
from supple.results.camera import Camera
from supple_benchmarks.han2020_bodies import LENGTH, RADIUS, STEEL_LIKE
from supple_benchmarks.machines.flexible_machine import FlexibleMachine

__all__ = ["QuadruplePendulum"]

TO_JOINT = 0.05
GRAVITY = (0.0, -9.806, 0.0)
HEADINGS = np.radians([0.0, 30.0, 60.0, 90.0])
FLEXIBLE = "link 4"


@dataclass(frozen=True)
class QuadruplePendulum:
    """Size of the benchmark.

    cell_type : TETRA4 or TETRA10       n_length : layers of 126 tetrahedra along the flexible cylinder
    n_modes : modal coordinates N_m     stiffness : factor on the paper's modulus
    tolerances : e, of the eigenvalues
    duration, output_step : s           step : s, of the runs that are compared
    """

    cell_type: CellType = CellType.TETRA10
    n_length: int = 28
    n_modes: int = 30
    stiffness: float = 1.0
    tolerances: tuple[float, ...] = (0.1, 0.01, 0.001)
    duration: float = 7.0
    output_step: float = 0.014
    step: float = 5e-4

    @classmethod
    def quick(cls) -> QuadruplePendulum:
        """A coarse mesh of four-node tetrahedra for a fifth of a second."""
        return cls(
            cell_type=CellType.TETRA4,
            n_length=12,
            n_modes=10,
            tolerances=(0.1, 0.01),
            duration=0.21,
            output_step=0.007,
            step=1e-3,
        )

    def mesh(self) -> Mesh:
        """The flexible cylinder, 3528 tetrahedra at the paper's size; x from the end with the joint."""
        return cylinder(RADIUS, LENGTH, 3, 1, self.n_length, self.cell_type)

    def machine(self) -> FlexibleMachine:
        """The pendulum with its run settings."""
        mesh = self.mesh()
        material = Isotropic(
            self.stiffness * STEEL_LIKE.youngs_modulus, STEEL_LIKE.poissons_ratio, STEEL_LIKE.density
        )
        model = solid_model(mesh, material)
        hinge = AveragingInterface("near", "root", position=(-TO_JOINT, 0.0, 0.0))
        look = cylinder(RADIUS, LENGTH, 3, 1, 4, CellType.TETRA4)
        return FlexibleMachine(
            name="quadruple-pendulum",
            body=flexible_body(FLEXIBLE, model, [hinge]).linearized(),
            model=model,
            material=material,
            system=_system,
            work=lambda solution: np.zeros(len(solution.times)),
            looks={f"link {k}": look for k in (1, 2, 3)},
            point=int(np.argmin(np.linalg.norm(mesh.nodes - [0.5 * LENGTH, RADIUS, 0.0], axis=1))),
            size=LENGTH,
            n_modes=self.n_modes,
            duration=self.duration,
            output_step=self.output_step,
            step=self.step,
            compared_from=2 * self.output_step,  # released from rest: gravity is applied suddenly
            camera=Camera.looking(along=(-0.8, -0.35, -1.0), up=(0.0, 1.0, 0.0)),
        )


def rigid_link(number: int) -> RigidBody:
    """One of the three rigid cylinders, its axis along x from 0 to LENGTH."""
    mass = STEEL_LIKE.density * np.pi * RADIUS**2 * LENGTH
    about_axis, across = 0.5 * RADIUS**2, (3 * RADIUS**2 + LENGTH**2) / 12
    return RigidBody(
        f"link {number}",
        mass,
        np.array([0.5 * LENGTH, 0.0, 0.0]),
        mass * np.diag([about_axis, across, across]),
        {"near": np.array([-TO_JOINT, 0.0, 0.0]), "far": np.array([LENGTH + TO_JOINT, 0.0, 0.0])},
    )


def _system(flexible: FullBody | ReducedBody) -> System:
    bodies, joints = [], []
    joint, end = np.zeros(3), GROUND
    for number, heading in enumerate(HEADINGS, start=1):
        along = np.array([np.cos(heading), 0.0, -np.sin(heading)])
        up = np.array([0.0, 1.0, 0.0])
        axes = np.column_stack([along, up, np.cross(along, up)])
        body = flexible if number == len(HEADINGS) else rigid_link(number)
        bodies.append(Placed(body, position=joint + TO_JOINT * along, rotation=axes))
        joints.append(Ball(first=end, second=At(body.name, "near"), name=f"ball {number}"))
        end, joint = At(body.name, "far"), joint + (LENGTH + 2 * TO_JOINT) * along
    return System(bodies=tuple(bodies), joints=tuple(joints), gravity=np.array(GRAVITY))
