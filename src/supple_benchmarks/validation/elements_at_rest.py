"""Static cases of shells and solids, nearly all under small loads: common test problems of elements."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import FiniteElementModel, HomogeneousSection, Isotropic, shell_model, solid_model
from supple.machine import GROUND, At, DeadForce, DeadTorque, Fixed, System
from supple.mesh import CellType, Mesh, block, cylinder_shell, plate, strip
from supple.simulation import equilibrium
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.validation.validation_case import Comparison, ValidationCase

__all__ = ["CASES"]

Array = NDArray[np.float64]

ALUMINIUM = Isotropic(7e10, 0.3, 2700.0)
MACNEAL = "R. H. MacNeal, R. L. Harder, Finite Elem. Anal. Des. 1 (1985) 3-20"


def _displacements(
    model: FiniteElementModel,
    *,
    root: str = "root",
    tip: str = "tip",
    force: ArrayLike = (0, 0, 0),
    torque: ArrayLike = (0, 0, 0),
    gravity: ArrayLike = (0, 0, 0),
) -> Array:
    """Nodal displacements (N, 3) of a body with a clamped root and a load on its rigid tip or its mass.

    root, tip : node sets, each moving as one rigid body
    force, torque : (3,) on the tip, of constant direction;  gravity : (3,)
    """
    ends = (RigidInterface("root", root), RigidInterface("tip", tip))
    body = FullBody(flexible_body("body", model, ends), NodalFixedFrame("root"))
    wall = Fixed(name="wall", first=GROUND, second=At("body", "root"))
    loads = (
        DeadForce(body="body", at="tip", force=force),
        DeadTorque(first=At("body", "tip"), torque=torque),
    )
    rest = equilibrium(System([body], [wall], loads, gravity=np.asarray(gravity, dtype=float)))
    return rest.system.bodies[0].positions() - model.mesh.nodes


def _reshaped(flat: Mesh, places: Array) -> Mesh:
    return Mesh(places, flat.cells, flat.node_sets)


def _mean_at(mesh: Mesh, moved: Array, where: str = "tip") -> Array:
    return moved[mesh.nodes_of(where)].mean(axis=0)


def _turn(mesh: Mesh, moved: Array, x: float) -> float:
    """Rotation about x, rad, of the section at x: least-squares fit to the nodal displacements."""
    section = np.abs(mesh.nodes[:, 0] - x) < 1e-9
    y, z = mesh.nodes[section, 1], mesh.nodes[section, 2]
    return float((y * moved[section, 2] - z * moved[section, 1]).sum() / (y**2 + z**2).sum())


def twisted_beam() -> Sequence[Comparison]:
    """A clamped strip twisted by 90 degrees: unit tip force in, or normal to, the plane of its tip."""
    length, width = 12.0, 1.1
    flat = strip(length, width, 24, 4)
    angle = np.pi / 2 * flat.nodes[:, 0] / length
    across = flat.nodes[:, 1]
    mesh = _reshaped(
        flat, np.column_stack([flat.nodes[:, 0], across * np.cos(angle), across * np.sin(angle)])
    )
    model = shell_model(mesh, HomogeneousSection(Isotropic(29e6, 0.22, 1.0), 0.32))
    inside = _mean_at(mesh, _displacements(model, force=(0, 0, 1.0)))[2]
    outside = _mean_at(mesh, _displacements(model, force=(0, 1.0, 0)))[1]
    return (
        Comparison(
            "deflection in the plane of the tip, m", inside, 5.424e-3, f"{MACNEAL}: twisted beam", 0.01
        ),
        Comparison("deflection out of this plane, m", outside, 1.754e-3, f"{MACNEAL}: twisted beam", 0.015),
    )


def curved_beam() -> Sequence[Comparison]:
    """A clamped quarter of a ring of shells, under a small tip force in its plane towards the centre."""
    middle, width, wall, force = 4.22, 0.2, 0.1, 0.01
    flat = strip(1.0, width, 48, 4)
    radius, angle = middle - flat.nodes[:, 1], np.pi / 2 * flat.nodes[:, 0]
    places = np.column_stack([radius * np.sin(angle), middle - radius * np.cos(angle), 0 * angle])
    mesh = _reshaped(flat, places)
    model = shell_model(mesh, HomogeneousSection(Isotropic(1e7, 0.25, 1.0), wall))
    moved = -_mean_at(mesh, _displacements(model, force=(-force, 0, 0)))[0]
    area, inertia = width * wall, wall * width**3 / 12
    exact = np.pi * force / 4e7 * (middle**3 / inertia + middle / area * (1 + 1.2 * 2 * 1.25))
    source = (
        "Castigliano's theorem: bending, stretching, shear; data of the curved beam of MacNeal and Harder"
    )
    return (Comparison("deflection in its plane, m", moved, exact, source, 5e-3),)


def bent_row_of_boxes() -> Sequence[Comparison]:
    """A cantilever of one row of HEXA8, bent to half of its length by a transverse dead force at its tip."""
    length, side, E = 10.0, 0.5, 1e6
    bending = E * side**4 / 12
    force = 2 * bending / length**2
    along, across, _ = elastica(bending, length, force)
    mesh = block(length, side, side, 20, 1, 1, CellType.HEXA8)
    bar = flexible_body("bar", solid_model(mesh, Isotropic(E, 0.0, 1.0)), [RigidInterface("root", "root")])
    wall = Fixed(first=GROUND, second=At("bar", "root"))
    # The nodes of the tip are free: a rigid section would add a strain of third order in its rotation.
    load = DeadForce(body="bar", at=mesh.nodes_of("tip"), force=(0, 0, force / 4))
    rest = equilibrium(System([FullBody(bar, NodalFixedFrame("root"))], [wall], [load]))
    moved = _mean_at(mesh, rest.system.bodies[0].positions() - mesh.nodes)
    source = "elastica, by shooting"
    return (
        Comparison("shortening, m", -float(moved[0]), length - along, source, 5e-3),
        Comparison("deflection, m", float(moved[2]), across, source, 5e-3),
    )


def square_bar_in_torsion() -> Sequence[Comparison]:
    """A square bar of quadratic bricks: twist per length away from the ends."""
    side, torque, n = 0.1, 100.0, 12
    mesh = block(6 * side, side, side, n, 3, 3, CellType.HEXA20)
    moved = _displacements(solid_model(mesh, ALUMINIUM), torque=(torque, 0, 0))
    rate = (_turn(mesh, moved, 4 * side) - _turn(mesh, moved, 2 * side)) / (2 * side)
    shear = ALUMINIUM.youngs_modulus / 2.6
    k = np.arange(1, 60, 2)
    constant = (1 - 192 / np.pi**5 * (np.tanh(k * np.pi / 2) / k**5).sum()) / 3
    source = "Saint-Venant's series: S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, section 109"
    return (Comparison("twist per length, rad/m", rate, torque / (shear * constant * side**4), source, 5e-3),)


def tube_in_torsion() -> Sequence[Comparison]:
    """A thin tube of flat shells with sixteen sides: twist per length away from the rigid ends."""
    radius, length, wall, sides, torque = 0.05, 0.5, 1e-3, 16, 20.0
    mesh = cylinder_shell(radius, length, 10, sides)
    model = shell_model(mesh, HomogeneousSection(ALUMINIUM, wall))
    moved = _displacements(model, root="x_min", tip="x_max", torque=(torque, 0, 0))
    rate = (_turn(mesh, moved, 0.3) - _turn(mesh, moved, 0.2)) / 0.1
    area = sides / 2 * radius**2 * np.sin(2 * np.pi / sides)
    around = 2 * sides * radius * np.sin(np.pi / sides)
    constant = 4 * area**2 * wall / around + around * wall**3 / 3
    exact = torque / (ALUMINIUM.youngs_modulus / 2.6 * constant)
    return (Comparison("twist per length, rad/m", rate, exact, "R. Bredt (1896), of the polygon", 2e-3),)


def clamped_plate() -> Sequence[Comparison]:
    """Deflection of a square plate under its weight, clamped along all edges."""
    side, thickness, g = 1.0, 0.01, 9.81
    mesh = plate(side, side, 16, 16)
    moved = _displacements(
        shell_model(mesh, HomogeneousSection(ALUMINIUM, thickness)),
        root="boundary",
        tip="centre",
        gravity=(0, 0, -g),
    )
    bending = ALUMINIUM.youngs_modulus * thickness**3 / 12 / (1 - 0.3**2)
    exact = 1.26532e-3 * ALUMINIUM.density * thickness * g * side**4 / bending
    source = "R. L. Taylor, S. Govindjee, Commun. Numer. Methods Eng. 20 (2004) 757-765"
    return (Comparison("sag of the middle, m", -_mean_at(mesh, moved, "centre")[2], exact, source, 0.01),)


CASES = (
    ValidationCase("twisted beam of shells", twisted_beam),
    ValidationCase("curved beam of shells", curved_beam),
    ValidationCase("clamped plate under its weight", clamped_plate),
    ValidationCase("bent row of eight-node boxes", bent_row_of_boxes),
    ValidationCase("square bar in torsion", square_bar_in_torsion),
    ValidationCase("tube in torsion", tube_in_torsion),
)
