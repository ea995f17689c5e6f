"""The parts of an explicit case: modal sub-domains and explicit elements, and where they start."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from supple.body import AveragingInterface, flexible_body
from supple.cases.body_kinds import Homogeneous, Shell, Solid
from supple.cases.damping import LinearRayleigh
from supple.cases.explicit import material_laws
from supple.cases.explicit.material_laws import MaterialLaw, StVenantKirchhoffLaw
from supple.cases.shared_rules import usable_names
from supple.explicit import (
    ENERGIES,
    OBSTACLES,
    STEPS,
    BulkViscosity,
    CentrifugalStiffness,
    ExplicitShell,
    ExplicitSubdomain,
    J2Plasticity,
    ModalSubdomain,
    Part,
    explicit_shell,
    modal_subdomain,
)
from supple.explicit import explicit_subdomain as explicit_elements
from supple.fem import Isotropic
from supple.importers import MESH_SUFFIXES, read_mesh
from supple.importers.toml import (
    ZERO,
    CheckedTable,
    KeyPath,
    Mistakes,
    NonNegative,
    Positive,
    Raw,
    Vector,
    on_each,
    table,
    tables,
)
from supple.mesh import Mesh
from supple.mesh.mesh_part import mesh_part
from supple.reduction import NormalModes, Rubin

SERIES = (ENERGIES, STEPS, OBSTACLES)
"""Names in a result file that are no parts."""


class ModalPart(CheckedTable):
    """Vibration modes on a four-point frame that flies and turns."""

    modes: int = Field(ge=1, description="vibration modes of the free part, from the lowest up")
    interfaces: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="node sets whose static answers to forces and moments join the modes"
    )
    highest_hz: Positive | None = Field(
        None, description="modes above it are left out, so that they do not shorten the step"
    )
    spin_stiffness: bool = Field(
        False, description="true stiffens the modes by the centrifugal stress of the part's own free spin"
    )
    yield_stress: Positive | None = Field(
        None,
        description="force per area, beyond which the run warns; the lowest of the explicit parts of its "
        "material if left out",
    )


class Viscosity(CheckedTable):
    """Of solids: spreads fronts over a few elements."""

    linear: NonNegative = Field(0.06, description="of critical damping of the shortest waves")
    quadratic: NonNegative = Field(1.2, description="elements that a shock is spread over, about")

    def build(self) -> BulkViscosity:
        """The viscosity."""
        return BulkViscosity(self.linear, self.quadratic)


class ExplicitPart(CheckedTable):
    """Nonlinear finite elements."""

    law: MaterialLaw = Field(
        default=StVenantKirchhoffLaw(kind="st-venant-kirchhoff"), description="how the material answers"
    )
    hourglass: float = Field(
        0.01, ge=0.0, le=1.0, description="stiffness of hourglass modes of hexahedra over that of stretching"
    )
    layers: int = Field(5, ge=2, description="Gauss points through the thickness of shells that yield")
    deletion: Positive | None = Field(None, description="plastic strain at which an element is deleted")
    bulk_viscosity: Viscosity = Field(
        Viscosity(linear=0.06, quadratic=1.2), description="pressure against the rate of volume; zeros: none"
    )


class PartTable(CheckedTable):
    """A modal or explicit part and where it starts."""

    name: str = Field(min_length=1, description="used as NAME.NODE_SET by ties, contacts, loads and output")
    mesh: str = Field(description="mesh file beside the case file: Gmsh .msh, Abaqus/CalculiX .inp or .bdf")
    cells: str | None = Field(None, description="cell set of the mesh that is this part; all if left out")
    shell: Shell | None = None
    solid: Solid | None = None
    modal: ModalPart | None = None
    explicit: ExplicitPart | None = None
    damping: LinearRayleigh | None = None
    position: Vector = Field(ZERO, description="start of the mesh origin, global axes")
    rotation: Vector = Field(ZERO, description="start orientation as a rotation vector, global axes, rad")
    velocity: Vector = Field(ZERO, description="start velocity of the mesh origin, global axes")
    angular_velocity: Vector = Field(ZERO, description="start angular velocity, global axes, rad per time")

    def read(self, folder: Path) -> Mesh:
        """The mesh of the part, with the node sets that it has a share in."""
        whole = read_mesh(folder / self.mesh)
        if self.cells is None:
            return whole
        part = mesh_part(whole, whole.cells_of(self.cells))
        inside = {name: nodes[np.isin(nodes, part.nodes)] for name, nodes in whole.node_sets.items()}
        sets = {name: nodes for name, nodes in inside.items() if len(nodes)}
        return mesh_part(whole, whole.cells_of(self.cells), sets).mesh

    def build(self, mesh: Mesh) -> Part:
        """The part on its mesh, where it starts."""
        made_of = self.solid or self.shell
        assert isinstance(made_of, Homogeneous)  # a rule of the case file
        material = Isotropic(made_of.youngs_modulus, made_of.poissons_ratio, made_of.density)
        start = {key: np.array(getattr(self, key)) for key in _START}
        return Part(self._subdomain(mesh, made_of, material), **start)

    def _subdomain(
        self, mesh: Mesh, made_of: Homogeneous, material: Isotropic
    ) -> ModalSubdomain | ExplicitSubdomain | ExplicitShell:
        model = made_of.model(mesh, material)
        damping = None if self.damping is None else self.damping.build()
        if self.modal is not None:
            ends = [AveragingInterface(name, name) for name in self.modal.interfaces]
            basis = Rubin(self.modal.modes) if ends else NormalModes(self.modal.modes)
            highest = np.inf if self.modal.highest_hz is None else 2 * np.pi * self.modal.highest_hz
            body = flexible_body(self.name, model, ends)
            stiffening = CentrifugalStiffness() if self.modal.spin_stiffness else None
            return modal_subdomain(
                body,
                basis,
                highest=highest,
                damping=damping,
                stiffening=stiffening,
                yield_stress=self.modal.yield_stress,
            )
        given = self.explicit
        assert given is not None  # a rule of the case file
        if self.shell is not None:
            law = given.law.build(material)
            return explicit_shell(
                model,
                name=self.name,
                law=law if isinstance(law, J2Plasticity) else None,
                layers=given.layers,
                deletion=np.inf if given.deletion is None else given.deletion,
                damping=damping,
            )
        return explicit_elements(
            model,
            given.law.build(material),
            name=self.name,
            hourglass=given.hourglass,
            deletion=np.inf if given.deletion is None else given.deletion,
            damping=damping,
            bulk_viscosity=given.bulk_viscosity.build(),
        )


_START = ("position", "rotation", "velocity", "angular_velocity")


def _are_of_one_kind(path: KeyPath, part: Raw) -> Mistakes:
    for keys, what in ((("solid", "shell"), "material"), (("modal", "explicit"), "way to march")):
        given = [key for key in keys if key in part]
        if len(given) != 1:
            seen = " and ".join(given) or "neither"
            yield path, f"a part needs exactly one {what}, {' or '.join(keys)}; this one has {seen}"


def _keys_have_an_effect(path: KeyPath, part: Raw) -> Mistakes:
    """Explicit shells are elastic or yield; what else is said has no effect, nor layers of a solid."""
    given = table(part, "explicit")
    kind = table(given, "law").get("kind")
    if "shell" not in part:
        if "layers" in given:
            yield (*path, "explicit", "layers"), "layers are of shells that yield; a solid has none"
        return
    if "hourglass" in given:
        yield (*path, "explicit", "hourglass"), "hourglass modes are of hexahedra; a shell has none"
    if "bulk_viscosity" in given:
        yield (*path, "explicit", "bulk_viscosity"), "bulk viscosity is of solids; a shell has none"
    if "law" in given and kind != "j2":
        message = f'the law of a shell is kind = "j2", or left out where it is elastic; got {kind!r}'
        yield (*path, "explicit", "law"), message
    for key in ("layers", "deletion") if "law" not in given else ():
        if key in given:
            yield (*path, "explicit", key), f'an elastic shell has no {key}; give it a law of kind "j2"'


def _meshes_can_be_read(path: KeyPath, part: Raw) -> Mistakes:
    mesh = part.get("mesh")
    if isinstance(mesh, str) and Path(mesh).suffix.lower() not in MESH_SUFFIXES:
        yield (*path, "mesh"), f"{mesh!r} is not a mesh that can be read: {' or '.join(MESH_SUFFIXES)}"


def _names_are_free(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "part")
    for path, part in tables(raw, "part"):
        if part.get("name") in SERIES:
            message = f"{part['name']!r} names a series of the result file; give the part another name"
            yield (*path, "name"), message


RULES = (
    _names_are_free,
    on_each(
        "part", _are_of_one_kind, _keys_have_an_effect, _meshes_can_be_read, *material_laws.RULES_OF_PART
    ),
)
