"""Small bodies of all kinds of elements: strips, plates, laminates, solids, beams and tubes."""

from __future__ import annotations

import numpy as np

from supple.body import (
    FlexibleBody,
    FullBody,
    MeanAxisFrame,
    ModalDamping,
    NodalFixedFrame,
    RayleighDamping,
    RigidInterface,
    flexible_body,
)
from supple.fem import BeamSection, HomogeneousSection, Isotropic, LaminateSection, shell_model, solid_model
from supple.mesh import CellType, block, cylinder_shell, strip
from supple_benchmarks.lines import line_mesh, points_along_x

__all__ = [
    "DAMPED",
    "MODALLY",
    "Damping",
    "beam",
    "framed",
    "laminate",
    "plate",
    "rod",
    "shell_strip",
    "solid_bar",
    "tube",
]

RUBBER = Isotropic(1e9, 0.3, 1000.0)
Damping = RayleighDamping | ModalDamping
DAMPED = RayleighDamping(alpha=0.3, beta=2e-4)
MODALLY = ModalDamping(0.02, n_modes=12)
ENDS = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
FACES = (RigidInterface("root", "x_min"), RigidInterface("tip", "x_max"))


def framed(body: FlexibleBody, *, mean_axes: bool = False, damping: Damping | None = None) -> FullBody:
    """A full body with its frame at its interface "root", or in mean axes."""
    return FullBody(body, MeanAxisFrame() if mean_axes else NodalFixedFrame("root"), damping)


def shell_strip(length: float = 1.0, n_length: int = 6, name: str = "body") -> FlexibleBody:
    """A strip along x, 0.1 m wide, 1 cm thick; first mode at 10 rad/s if 1 m long and clamped at its root."""
    return flexible_body(
        name, shell_model(strip(length, 0.1, n_length, 2), HomogeneousSection(RUBBER, 0.01)), ENDS
    )


def plate() -> FlexibleBody:
    """A plate of 1 m by 0.8 m, 2 cm thick, with an interface along one edge."""
    return flexible_body(
        "body", shell_model(strip(1.0, 0.8, 5, 4), HomogeneousSection(RUBBER, 0.02)), ENDS[:1]
    )


def laminate() -> FlexibleBody:
    """A strip of two different layers, with extension-bending and bending-torsion coupling."""
    stiff, soft, thickness = 3e9, 5e8, 0.005
    A = np.diag([stiff + soft, soft, soft / 2]) * thickness
    B = np.diag([soft - stiff, 0.0, 0.0]) * thickness**2 / 2
    D = np.diag([stiff + soft, soft, soft / 2]) * thickness**3 / 3
    D[0, 2] = D[2, 0] = 0.1 * D[0, 0]
    wall = LaminateSection(
        A, B, D, 2 * thickness * 1200.0, 1200.0 * (2 * thickness) ** 3 / 12, (1.0, 0.0, 0.0)
    )
    return flexible_body("body", shell_model(strip(1.0, 0.15, 6, 2), wall), ENDS)


def solid_bar() -> FlexibleBody:
    """A bar of three quadratic bricks, 1 m long in total."""
    mesh = block(1.0, 0.06, 0.04, 3, 1, 1, CellType.HEXA20)
    return flexible_body("body", solid_model(mesh, RUBBER), ENDS)


def beam(length: float = 1.0, n: int = 10, name: str = "body", side: float = 0.02) -> FlexibleBody:
    """Beam elements with a square section of given side."""
    inertia = side**4 / 12
    section = BeamSection(
        RUBBER, side**2, inertia, 1.1 * inertia, 1.69 * inertia, 5 / 6, 5 / 6, orientation=(0, 1, 0)
    )
    return flexible_body(name, shell_model(line_mesh(points_along_x(length, n)), section), ENDS)


def rod(length: float, name: str, n: int = 5) -> FlexibleBody:
    """A link of a machine, of beam elements."""
    return beam(length, n, name, side=0.03)


def tube() -> FlexibleBody:
    """A thin cylindrical shell along x; rigid interfaces keep its ends circular."""
    mesh = cylinder_shell(0.05, 1.0, 5, 6)
    return flexible_body("body", shell_model(mesh, HomogeneousSection(RUBBER, 0.002)), FACES)
