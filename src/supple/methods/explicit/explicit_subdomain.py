"""Explicit sub-domain: nonlinear finite elements with lumped mass, plasticity and failure."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from supple.arguments import check_fields, checked_arguments
from supple.arrays import FloatArray
from supple.body import LinearRayleighDamping
from supple.body.damping import refuse_relative_damping
from supple.errors import ModelError
from supple.fem import FiniteElementModel, Isotropic, lumped_mass, node_masses
from supple.fem.mass import CellMass
from supple.fem.model import SOLID_ELEMENTS
from supple.fem.solid_element import solid_mass
from supple.methods.explicit.element_part import ElementPart, check_law, refuse_beside_elements
from supple.methods.explicit.elements import (
    BulkArrays,
    BulkViscosity,
    SolidPoints,
    bulk_arrays,
    element_limits,
    hourglass_stiffness,
    solid_points,
)
from supple.methods.explicit.materials import Law, StVenantKirchhoff

__all__ = ["ExplicitSubdomain", "explicit_subdomain"]


@dataclass(frozen=True, eq=False)
class ExplicitSubdomain(ElementPart):
    """Finite elements of one law; built by `explicit_subdomain`.

    name : str
    model : FiniteElementModel      of solids
    law : Law
    hourglass : float       stiffness of an hourglass mode of hexahedra relative to that of stretching
    deletion : float        plastic strain at which an element is deleted; infinite: never
    damping : LinearRayleighDamping | None      beta acts on the rate of the Green-Lagrange strain; alpha not
        on nodes tied to a modal part
    bulk_viscosity : BulkViscosity      spreads shock fronts over a few elements; BulkViscosity(0, 0): none
    """

    name: str
    model: FiniteElementModel = field(repr=False)
    law: Law
    hourglass: float = 0.01
    deletion: float = float("inf")
    damping: LinearRayleighDamping | None = None
    bulk_viscosity: BulkViscosity = field(default_factory=BulkViscosity)

    def __post_init__(self) -> None:
        check_fields(self)
        what = f"explicit sub-domain '{self.name}'"
        refuse_relative_damping(self.damping, what)
        refuse_beside_elements(what, self.model)
        if self.model.dofs_per_node != 3:
            raise ModelError(f"{what}: its law is for solids, its model has shells; use explicit_shell")
        if not 0 <= self.hourglass <= 1:
            raise ModelError(f"{what}: the hourglass stiffness is a fraction, 0 to 1, got {self.hourglass}")
        densities = (self.law.elastic.density, self._density)
        check_law(what, self.law, densities, self.deletion)

    @cached_property
    def masses(self) -> FloatArray:
        """(N,) lumped masses, kg; positive for quadratic tetrahedra too (Hinton, Rock and Zienkiewicz 1976).

        Concentrated masses are included, independent of the density of the law.
        """
        beside = node_masses(self.model)
        return beside + (lumped_mass(self.model)[::3] - beside) * (self.law.elastic.density / self._density)

    @cached_property
    def points(self) -> tuple[SolidPoints, ...]:
        """The strain points of each section."""
        pairs = zip(self.model.sections, self.model.blocks, strict=True)
        return tuple(solid_points(self.model, section, block) for section, block in pairs)

    @cached_property
    def element_limits(self) -> tuple[FloatArray, ...]:
        """The longest stable step of each element of each block at rest, s, without damping or viscosity."""
        elastic = self.law.elastic
        return tuple(
            element_limits(points, masses, elastic, hourglass_stiffness(points, elastic, self.hourglass))
            for points, masses in zip(self.points, self._element_masses, strict=True)
        )

    @property
    def bulk_arrays(self) -> tuple[BulkArrays | None, ...]:
        """The bulk viscosity of each block; None without viscosity."""
        return tuple(
            bulk_arrays(points, masses, self.law.elastic, limits, self.bulk_viscosity)
            for points, masses, limits in zip(
                self.points, self._element_masses, self.element_limits, strict=True
            )
        )

    @cached_property
    def _element_masses(self) -> tuple[FloatArray, ...]:
        """(E, k) lumped masses, kg, of each block."""
        found = []
        for section, points in zip(self.model.sections, self.points, strict=True):
            element, corners = SOLID_ELEMENTS[section.cell_type], section.corners(self.model.mesh)
            mass = solid_mass(element, corners, self.law.elastic.density)
            found.append(np.einsum("ekk->ek", CellMass(points.nodes, mass).lumped().translational))
        return tuple(found)

    @property
    def step_limit(self) -> float:
        """Longest stable step at rest, s, without damping or viscosity."""
        return min(float(own.min()) for own in self.element_limits)

    @property
    def _density(self) -> float:
        return self.model.sections[0].property.density  # ty: ignore[missing-union-attribute] - of solids


@checked_arguments
def explicit_subdomain(
    model: FiniteElementModel,
    material: Law | None = None,
    *,
    name: str = "explicit",
    hourglass: float = 0.01,
    deletion: float = float("inf"),
    damping: LinearRayleighDamping | None = None,
    bulk_viscosity: BulkViscosity | None = None,
) -> ExplicitSubdomain:
    """Nonlinear finite elements for explicit time integration.

    model : model of TETRA4, TETRA10 or HEXA8 cells; hexahedra have one strain point and hourglass control
    material : J2Plasticity(..), NeoHookean(..) or StVenantKirchhoff(..); default StVenantKirchhoff with the
        constants of the model
    name, hourglass, deletion, damping : see `ExplicitSubdomain`
    bulk_viscosity : BulkViscosity      default BulkViscosity(); BulkViscosity(0, 0): none
    Raises ModelError for shells, a model of several materials, values outside their ranges, a density of 0, a
    deletion strain with an elastic law, a stated shear modulus that differs from E / (2 (1 + nu)), and,
    without a `material`, constants that are not Isotropic. Cells of other types raise ModelError later, when
    a run is prepared.
    """
    own = {section.property for section in model.sections}
    if len(own) != 1:
        raise ModelError(
            f"explicit sub-domain '{name}' has {len(own)} materials; make one sub-domain for each, and "
            "join them by Tie(..)"
        )
    (constants,) = own
    if material is None:
        if not isinstance(constants, Isotropic):
            raise ModelError(f"explicit sub-domain '{name}' needs a solid of an Isotropic material")
        material = StVenantKirchhoff(constants)
    viscosity = BulkViscosity() if bulk_viscosity is None else bulk_viscosity
    return ExplicitSubdomain(name, model, material, hourglass, deletion, damping, viscosity)
