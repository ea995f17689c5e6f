"""Error-controlled reduction of the bodies of [Han2020]: modes, accuracy of estimates, verification.

The paper's cylinder (section 5.1) and connecting rod (5.2) on meshes of our own, with four- and ten-node
tetrahedra. For each tolerance: the number of fixed-interface modes by every estimator and by the exact
errors, the ratio of estimates to exact errors, the verification, and the cost.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from supple.body import FlexibleBody, RigidInterface, flexible_body
from supple.fem import solid_model
from supple.mesh import CellType, RodCells, connecting_rod, cylinder
from supple_benchmarks.han2020_bodies import ALUMINIUM, LENGTH, RADIUS, ROD, STEEL_LIKE

__all__ = ["ELEMENTS", "BodyCase", "EigenvalueErrors", "cylinder_case", "rod_case"]

BORES = ("big_bore", "small_bore")
ELEMENTS = {CellType.TETRA4: "tet4", CellType.TETRA10: "tet10"}


@dataclass(frozen=True)
class BodyCase:
    """A body to reduce.

    name, element : as in the report        n_modes : elastic eigenvalues controlled, N_m
    published : {tolerance: modes} of the paper, on its own mesh
    """

    name: str
    element: str
    n_modes: int
    published: Mapping[float, int]
    build: Callable[[], FlexibleBody]


@dataclass(frozen=True)
class EigenvalueErrors:
    """Size of the benchmark.

    tolerances : of the relative eigenvalue errors
    cylinders : (element, layers of 126 tetrahedra along the cylinder)
    rods : (element, cells of the rod)
    beams : (element, (n_core, n_ring, n_length)), cylinders compared with beam theory
    candidates : number of fixed-interface and of free modes for the comparison of the reduction bases
    """

    tolerances: tuple[float, ...] = (0.1, 0.01, 0.001)
    cylinders: tuple[tuple[CellType, int], ...] = ((CellType.TETRA10, 28), (CellType.TETRA4, 28))
    rods: tuple[tuple[CellType, RodCells], ...] = (
        (CellType.TETRA10, RodCells()),
        (CellType.TETRA4, RodCells()),
    )
    beams: tuple[tuple[CellType, tuple[int, int, int]], ...] = (
        (CellType.TETRA10, (3, 1, 28)),
        (CellType.TETRA4, (3, 1, 28)),
        (CellType.TETRA4, (4, 2, 48)),
        (CellType.TETRA4, (6, 3, 70)),
    )
    candidates: int = 300

    @classmethod
    def quick(cls) -> EigenvalueErrors:
        """Four-node tetrahedra as published, ten-node ones on coarse meshes: under 40 s."""
        coarse = RodCells(around=12, ring=1, shank=10, width=3, thickness=2)
        return cls(
            cylinders=((CellType.TETRA10, 8), (CellType.TETRA4, 28)),
            rods=((CellType.TETRA10, coarse), (CellType.TETRA4, RodCells())),
            beams=((CellType.TETRA10, (3, 1, 20)), (CellType.TETRA4, (3, 1, 28))),
            candidates=160,
        )

    def cases(self) -> tuple[BodyCase, ...]:
        """All bodies."""
        return (
            *(cylinder_case(element, n_length) for element, n_length in self.cylinders),
            *(rod_case(element, cells) for element, cells in self.rods),
        )


def cylinder_case(element: CellType, n_length: int) -> BodyCase:
    """The flexible link of the quadruple pendulum; its right end is the interface."""

    def build() -> FlexibleBody:
        mesh = cylinder(RADIUS, LENGTH, 3, 1, n_length, element)
        return flexible_body("cylinder", solid_model(mesh, STEEL_LIKE), [RigidInterface("end", "tip")])

    return BodyCase("cylinder", ELEMENTS[element], 30, {0.1: 35, 0.01: 58, 0.001: 446}, build)


def rod_case(element: CellType, cells: RodCells) -> BodyCase:
    """The rod of the slider-crank; its bores are the interfaces."""

    def build() -> FlexibleBody:
        mesh = connecting_rod(ROD, cells, element)
        bores = [RigidInterface(bore, bore) for bore in BORES]
        return flexible_body("rod", solid_model(mesh, ALUMINIUM), bores)

    return BodyCase("rod", ELEMENTS[element], 10, {0.1: 8, 0.01: 25, 0.001: 105}, build)
