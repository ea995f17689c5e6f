"""The rotating beam of [Wu2019] section 6.1: a strip of shells, spun up about its root, full and reduced.

The beam (L = 10 m, EA = 2.8e7 N, EI = 1.4e4 N m^2, rho A = 1.2 kg/m) is a flat strip that rotates about the
width of its root section, so that it bends out of its plane. It is along x and rotates about -y, towards +z;
its tip lags. The full and the reduced models are run in both floating frames. A geometrically exact beam
without a floating frame is the reference for the kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody, RigidInterface, flexible_body
from supple.fem import HomogeneousSection, Isotropic, ShellKinematics, shell_model
from supple.integrate import FixedStep, Run
from supple.mesh import Mesh, strip
from supple_benchmarks.compared_models import ROOT
from supple_benchmarks.planar_beam import ROTATING_BEAM

__all__ = ["BODY", "RotatingBeam", "spin_up_load"]

Array = NDArray[np.float64]

BODY = "beam"


@dataclass(frozen=True)
class RotatingBeam:
    """Size of the benchmark.

    speeds : final speeds omega_s, rad/s        kinematics : names from KINEMATICS
    n_length, n_width : cells of the strip      width : m, of a strip with Poisson's ratio zero
    step, output_step, duration : s             steady_from : s, from when the extension is averaged
    """

    speeds: tuple[float, ...] = (6.0, 8.0, 10.0, 12.0)
    kinematics: tuple[str, ...] = ("green-lagrange", "von-karman")
    n_length: int = 64
    n_width: int = 2
    width: float = 1.0
    step: float = 0.01
    output_step: float = 0.02
    duration: float = 20.0
    steady_from: float = 16.0

    @classmethod
    def quick(cls) -> RotatingBeam:
        """One speed, one kinematics and a coarse mesh: under a minute."""
        return cls(speeds=(6.0,), kinematics=("green-lagrange",), n_length=10, n_width=2, step=0.02)

    @property
    def run(self) -> Run:
        """The run of the full and the reduced models."""
        return Run(self.duration, self.output_step, step=FixedStep(self.step))

    def mesh(self) -> Mesh:
        """The strip."""
        return strip(ROTATING_BEAM.length, self.width, self.n_length, self.n_width)

    def body(self, kinematics: ShellKinematics) -> FlexibleBody:
        """The strip, its root section a rigid interface; thickness and modulus follow from EA and EI."""
        beam = ROTATING_BEAM
        thickness = float(np.sqrt(12 * beam.bending_stiffness / beam.axial_stiffness))
        area = self.width * thickness
        material = Isotropic(beam.axial_stiffness / area, 0.0, beam.mass_per_length / area)
        model = shell_model(self.mesh(), HomogeneousSection(material, thickness), kinematics=kinematics)
        return flexible_body(BODY, model, [RigidInterface(ROOT, ROOT)])


def spin_up_load(body: FlexibleBody) -> Array:
    """Inertia force of a unit angular acceleration about the root's y axis, balanced at the root, (n_nodal,).

    Its modal components p_j give the weights p_j p_k by which derivatives are selected.
    """
    root = body.interface(ROOT)
    d = body.dofs_per_node
    turning = np.zeros((len(body.nodes), d))
    turning[:, :3] = np.cross([0.0, 1.0, 0.0], body.nodes - root.position)
    turning[:, 4] = 1.0
    load = (body.nodal_mass @ turning.ravel()).reshape(-1, d)
    force = load[:, :3].sum(axis=0)
    moment = np.cross(body.nodes - root.position, load[:, :3]).sum(axis=0) + load[:, 3:].sum(axis=0)
    clamped = np.asarray(root.node_ids)
    load[clamped, :3] -= force / len(clamped)
    load[clamped, 3:] -= moment / len(clamped)
    return load.ravel()
