"""Explicit sub-domain of shells: flat triangles with small strain, any rotation, and lumped inertia."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from supple.arguments import check_fields, checked_arguments
from supple.arrays import FloatArray
from supple.body import LinearRayleighDamping
from supple.body.damping import refuse_relative_damping
from supple.errors import ModelError
from supple.fem import FiniteElementModel, HomogeneousSection, lumped_mass, stress_recovery
from supple.fem.kirchhoff_bending import MIDSIDES
from supple.fem.optimal_membrane import drilling_stiffness, triangle_area
from supple.fem.shell_triangle import (
    drilling_rotations,
    element_axes,
    plane_coordinates,
    plane_tensor,
    resultant_strains,
)
from supple.mesh import CellType
from supple.methods.explicit.element_part import ElementPart, check_law, refuse_beside_elements
from supple.methods.explicit.materials import J2Plasticity

__all__ = ["ExplicitShell", "explicit_shell"]


@dataclass(frozen=True, eq=False)
class ShellElements:
    """Arrays of E triangles of one section.

    nodes : int (E, 3);   corners : (E, 3, 3) m;   stiffness : (E, 18, 18)
    to_stress : (E, l, 6, 18)   stress in l layers, Pa, per displacement and rotation of the nodes
    inertia : (E,) of each corner, kg m^2;   mass : (E,) of each corner, kg
    thickness : m;   area : (E,) m^2
    membrane : (E, 3, 18)       membrane strain per displacement and rotation of the nodes
    bending : (E, p, 3, 18)     curvature at p points per displacement and rotation of the nodes
    drilling : (E, 18, 18) stiffness of the drilling rotations alone
    """

    nodes: NDArray[np.int64]
    corners: FloatArray
    stiffness: FloatArray
    to_stress: FloatArray
    mass: FloatArray
    inertia: FloatArray
    thickness: float
    area: FloatArray
    membrane: FloatArray
    bending: FloatArray
    drilling: FloatArray

    @cached_property
    def step_limits(self) -> FloatArray:
        """2 / omega_max of each triangle at rest, (E,), s."""
        diagonal = np.tile(np.column_stack([self.mass] * 3 + [self.inertia] * 3), (1, 3))
        scaled = self.stiffness / np.sqrt(diagonal[:, :, None] * diagonal[:, None])
        return 2 / np.sqrt(np.linalg.eigvalsh(scaled)[:, -1])


@dataclass(frozen=True, eq=False)
class ExplicitShell(ElementPart):
    """Shells of small strain; built by `explicit_shell`.

    name : str
    model : FiniteElementModel      of TRIANGLE3 cells with homogeneous sections
    law : J2Plasticity | None       None: elastic
    layers : int            Gauss points through the thickness; used only with a law
    deletion : float        plastic strain at which an element is deleted; infinite: never
    damping : LinearRayleighDamping | None      alpha only: beta must be 0; not on nodes tied to a modal part
    """

    name: str
    model: FiniteElementModel = field(repr=False)
    law: J2Plasticity | None = None
    layers: int = 5
    deletion: float = float("inf")
    damping: LinearRayleighDamping | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        what = f"explicit shell '{self.name}'"
        refuse_relative_damping(self.damping, what)
        refuse_beside_elements(what, self.model)
        for section in self.model.sections:
            if section.cell_type is not CellType.TRIANGLE3 or not isinstance(
                section.property, HomogeneousSection
            ):
                raise ModelError(
                    f"{what}: it has {section.cell_type.name} cells of "
                    f"{type(section.property).__name__}; explicit shells are TRIANGLE3 cells of a "
                    "HomogeneousSection"
                )
            if section.property.offset or section.property.added_mass or section.property.shear_factor:
                raise ModelError(
                    f"{what}: its section has an offset, an added mass or a shear "
                    "factor; explicit shells are plain sections about their nodes: leave these out"
                )
            if self.law is not None and section.property.material != self.law.elastic:
                raise ModelError(
                    f"{what}: its law has other elastic constants, or another density, "
                    "than its sections; make one part for each material"
                )
        if self.layers < 2:
            raise ModelError(f"{what}: {self.layers} layers have no bending stiffness; give at least 2")
        masses = [section.property.mass_per_area for section in self.model.sections]  # ty: ignore[missing-union-attribute] - of shells
        check_law(what, self.law, masses, self.deletion)
        if self.damping is not None and self.damping.beta:
            raise ModelError(f"{what}: strain-rate damping is available for solids only; give beta = 0")

    @cached_property
    def masses(self) -> FloatArray:
        """(N,) lumped masses, kg."""
        return lumped_mass(self.model)[::6]

    @cached_property
    def inertias(self) -> FloatArray:
        """(N,) rotary inertia about any axis, kg m^2."""
        total = np.zeros(len(self.nodes))
        for own in self.elements:
            np.add.at(total, own.nodes, own.inertia[:, None])
        return total

    @cached_property
    def elements(self) -> tuple[ShellElements, ...]:
        """The triangles of each section.

        Each corner has the inertia m (t^2/12 + A/8). With m t^2/12 alone, rotations would limit the step.
        The added term m A/8 vanishes with the square of the element size (Hughes, Cohen and Haroun 1978).
        """
        recovery = stress_recovery(self.model)
        made = []
        for section, block, stress in zip(
            self.model.sections, self.model.blocks, recovery.sections, strict=True
        ):
            given = section.property
            assert isinstance(given, HomogeneousSection)
            corners = section.corners(self.model.mesh)
            axes = element_axes(corners, given, section.directions)
            xy, surface = plane_coordinates(corners, axes), plane_tensor(section.surface_curvature, axes)
            area = triangle_area(xy)
            B = block.B[:, 0]
            membrane, bending = resultant_strains(xy, MIDSIDES, given, surface)
            drills = drilling_rotations(xy, given, surface) @ B
            D = block.w[:, :1, None] * np.broadcast_to(block.D, (len(B), *block.D.shape[-2:]))
            mass = given.mass_per_area * area / 3
            of_strain = np.broadcast_to(stress.of_strain, (len(B), *stress.of_strain.shape[1:]))
            made.append(
                ShellElements(
                    section.nodes(self.model.mesh),
                    corners,
                    B.swapaxes(1, 2) @ D @ B,
                    of_strain @ B[:, None],
                    mass,
                    mass * (given.thickness**2 / 12 + area / 8),
                    given.thickness,
                    area,
                    membrane @ B,
                    bending @ B[:, None],
                    drills.swapaxes(1, 2) @ drilling_stiffness(xy, given.membrane) @ drills,
                )
            )
        return tuple(made)

    @cached_property
    def step_limit(self) -> float:
        """Longest stable step at rest, s, from the fastest mode of any single element (Irons, Treharne)."""
        return min(float(own.step_limits.min()) for own in self.elements)


@checked_arguments
def explicit_shell(
    model: FiniteElementModel,
    *,
    name: str = "shell",
    law: J2Plasticity | None = None,
    layers: int = 5,
    deletion: float = float("inf"),
    damping: LinearRayleighDamping | None = None,
) -> ExplicitShell:
    """Shells for explicit time integration: small strains, any rotation; elastic, or plastic by a law.

    model : model of TRIANGLE3 cells with HomogeneousSection(..)
    name, law, layers, deletion, damping : see `ExplicitShell`
    Raises ModelError for other cells and sections, a law whose constants differ from those of the sections,
    fewer than 2 layers, a deletion strain that is not positive or without a law, a density of 0, and
    strain-rate damping.
    """
    return ExplicitShell(name, model, law, layers, deletion, damping)
