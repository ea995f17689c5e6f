"""The kinds of bodies in a case, one table each, and the rules on the places of a body that a key names."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from supple.body import (
    BodySource,
    MatrixFiles,
    RigidBody,
    deck_source,
    elements_source,
    labelled_matrices_source,
    matrices_source,
    section_beams_source,
)
from supple.cases.shared_rules import FileName
from supple.errors import MeshError, ModelError
from supple.fem import (
    GREEN_LAGRANGE,
    VON_KARMAN,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    shell_model,
    solid_model,
)
from supple.importers import MESH_SUFFIXES, NASTRAN_SUFFIXES, NODE_SUFFIXES, read_mesh
from supple.importers.toml import (
    ZERO,
    CheckedTable,
    KeyPath,
    Matrix,
    Mistakes,
    NonNegative,
    Positive,
    Raw,
    Vector,
    names,
    nearest_hint,
    tables,
    unknown,
)
from supple.mesh import Mesh, to_quadratic
from supple.mesh.mesh_part import mesh_part

Kinematics = Literal["green-lagrange", "von-karman"]
_KINEMATICS = {"green-lagrange": GREEN_LAGRANGE, "von-karman": VON_KARMAN}
NO_INTERFACES = (
    "has explicit elements, and these have no interfaces, which joints, springs, torques, follower loads and "
    "rotations need: tie the nodes to a modal part ([[tie]]) and give an interface of that part; [[support]] "
    "fixes nodes in space"
)


class BodyKind(CheckedTable):
    """A kind of body; class attributes state its properties and the requirements on its table."""

    mesh_suffixes: ClassVar[tuple[str, ...]] = ()
    """Suffixes of the mesh file; empty for kinds without a mesh."""
    is_elastic: ClassVar[bool] = False
    """True for elastic kinds that the case builds, with frame, reduction and damping."""
    has_elements: ClassVar[bool] = False
    """True for kinds with node sets, stress and nonlinear strains."""
    has_connections: ClassVar[bool] = False
    """True for kinds whose RBE2 and RBE3 elements can be interfaces."""


class ElasticKind(BodyKind, ABC):
    """A kind of elastic body."""

    is_elastic = True

    @abstractmethod
    def source(self, folder: Path, mesh: str, cells: str | None = None, /) -> BodySource:
        """The source of the body from files in `folder`.

        mesh : name of the mesh file; superelements and section tables do not use it
        cells : cell set of the mesh that forms the body, for `Homogeneous` kinds only; None: all cells
        """


class Homogeneous(ElasticKind):
    """Elements of one material on every cell of the mesh."""

    mesh_suffixes = MESH_SUFFIXES
    has_elements = True

    youngs_modulus: Positive = Field(description="Young's modulus, force per area")
    poissons_ratio: float = Field(gt=-1.0, lt=0.5, description="Poisson's ratio")
    density: Positive = Field(description="mass density, mass per volume")

    def source(self, folder: Path, mesh: str, cells: str | None = None, /) -> BodySource:
        """The source of the body: the mesh file, with elements on its cells."""
        try:
            read = read_mesh(folder / mesh)
        except MeshError:
            if cells is None:
                raise
            # The whole mesh of several bodies may be disconnected; the cells of this body are connected.
            read = read_mesh(folder / mesh, only=cells)
        if cells is not None:
            part = mesh_part(read, read.cells_of(cells))
            inside = {name: nodes[np.isin(nodes, part.nodes)] for name, nodes in read.node_sets.items()}
            sets = {name: nodes for name, nodes in inside.items() if len(nodes)}
            read = mesh_part(read, read.cells_of(cells), sets).mesh
        read = self.refined(read)
        material = Isotropic(self.youngs_modulus, self.poissons_ratio, self.density)
        return elements_source(read, lambda: self.model(read, material))

    def refined(self, mesh: Mesh) -> Mesh:
        """The mesh on which the elements are."""
        return mesh

    @abstractmethod
    def model(self, mesh: Mesh, material: Isotropic) -> FiniteElementModel:
        """The elements on a mesh."""


class Shell(Homogeneous):
    """Homogeneous flat-shell triangles on every cell of the mesh."""

    thickness: Positive = Field(description="wall thickness, a length")
    shear_factor: NonNegative = Field(
        0.0,
        description="k of the transverse shear stiffness k G t, such as 0.8333; default: rigid in shear",
    )
    kinematics: Kinematics = Field(
        "green-lagrange",
        description="membrane strain; von-karman only for flat structures bending out of their plane",
    )

    def model(self, mesh: Mesh, material: Isotropic) -> FiniteElementModel:
        """Shells of one thickness."""
        _check_cells(mesh, 2)
        section = HomogeneousSection(material, self.thickness, shear_factor=self.shear_factor)
        return shell_model(mesh, section, kinematics=_KINEMATICS[self.kinematics])


_FORMS = {
    1: "a mesh has no cross-sections of beams: give a deck with them (nastran = {}, abaqus = {}), or a "
    "section_table",
    2: "for shells give shell = { thickness = .., .. }",
    3: "for solids give solid = {..}",
}
"""Keys of a case file for cells of a dimension; parts of messages."""


def _check_cells(mesh: Mesh, dimension: int) -> None:
    """Raise ModelError for cells of another dimension."""
    for kind in mesh.cells:
        if kind.dimension != dimension:
            raise ModelError(f"the mesh has {kind.name} cells: {_FORMS[kind.dimension]}")


class Solid(Homogeneous):
    """Green-Lagrange solid elements (tetrahedra, hexahedra) on every cell of the mesh."""

    second_order: bool = Field(
        False,
        description="add a node in the middle of each edge, such as TETRA10 for TETRA4: first-order "
        "tetrahedra and wedges are too stiff in bending",
    )

    def refined(self, mesh: Mesh) -> Mesh:
        """The mesh, with cells of second order if the case has `second_order`."""
        return to_quadratic(mesh) if self.second_order else mesh

    def model(self, mesh: Mesh, material: Isotropic) -> FiniteElementModel:
        """Solids of one material."""
        _check_cells(mesh, 3)
        return solid_model(mesh, material)


class DeckKind(ElasticKind):
    """A body from an input file of another program: elements, materials, sections, masses, springs, ties."""

    has_elements = True
    has_connections = True

    kinematics: Kinematics = Field(
        "green-lagrange",
        description="membrane strain of shells; von-karman only for flat ones bending out of their plane",
    )
    part: str | None = Field(None, description="one of several disconnected parts of the file: part_1 ..")
    leave_out: tuple[str, ...] = Field(
        (), strict=False, description="cards of the file that would change the body and are omitted"
    )

    def source(self, folder: Path, mesh: str, _cells: str | None = None, /) -> BodySource:
        """The source of the body from its input file."""
        return deck_source(
            folder / mesh, _KINEMATICS[self.kinematics], part=self.part, leave_out=self.leave_out
        )


class Nastran(DeckKind):
    """The elements, materials, properties, masses and ties of a Nastran bulk data file."""

    mesh_suffixes = NASTRAN_SUFFIXES


class Abaqus(DeckKind):
    """The elements, materials, sections, masses and ties of an Abaqus or CalculiX input file."""

    mesh_suffixes = (".inp",)


class Matrices(ElasticKind):
    """A linear body from matrices of another program, full or condensed, with the nodes of its mesh file."""

    mesh_suffixes = NODE_SUFFIXES
    has_connections = True

    stiffness: FileName = Field(
        description="DMIG .pch, OUTPUT4 .op4, OUTPUT2 .op2, HDF5 .h5, Abaqus .mtx or CalculiX .sti, beside "
        "the case file; rows without a node (QSET, SPOINT) are modal coordinates"
    )
    mass: FileName = Field(description="as for stiffness, or CalculiX .mas; may be the same file")
    stiffness_name: str | None = Field(
        None,
        description="name of the matrix in a DMIG or OUTPUT4 file; default: the only name that begins with K",
    )
    mass_name: str | None = Field(
        None, description="as stiffness_name; default: the only name that begins with M"
    )
    damping: FileName | None = Field(None, description="as for stiffness; default: no damping matrix")
    damping_name: str | None = Field(
        None, description="as stiffness_name; default: the only name that begins with B"
    )
    recovery: FileName | None = Field(
        None, description="HDF5 or OUTPUT4 file of the recovery matrix: motions of inner points from the rows"
    )
    recovery_name: str | None = Field(None, description="name of the recovery matrix in an OUTPUT4 file")
    rigid_tolerance: Positive | None = Field(
        None, description="largest relative force under rigid motion; default: from the printed digits"
    )

    def source(self, folder: Path, mesh: str, _cells: str | None = None, /) -> BodySource:
        """The source of the body from its matrix files and the nodes of its mesh file."""
        files = MatrixFiles(
            nodes=folder / mesh,
            stiffness=folder / self.stiffness,
            mass=folder / self.mass,
            damping=None if self.damping is None else folder / self.damping,
            recovery=None if self.recovery is None else folder / self.recovery,
            stiffness_name=self.stiffness_name,
            mass_name=self.mass_name,
            damping_name=self.damping_name,
            recovery_name=self.recovery_name,
        )
        return labelled_matrices_source(files, rigid_tolerance=self.rigid_tolerance)


class Superelement(ElasticKind):
    """A linear body from matrices of another program; rows after the nodal rows are modal coordinates."""

    stiffness: FileName = Field(
        description="Matrix Market file of the stiffness matrix, beside the case file"
    )
    mass: FileName = Field(description="Matrix Market file of the mass matrix, beside the case file")
    nodes: FileName = Field(description="Matrix Market file of the node positions, an array of 3 columns")
    dofs_per_node: Literal[3, 6] = Field(
        description="freedoms per node: 3 (translations) or 6 (and rotations)"
    )
    damping: FileName | None = Field(None, description="Matrix Market file of the damping matrix")
    recovery: FileName | None = Field(
        None, description="Matrix Market file of the matrix from the rows to displacements, 3 rows a point"
    )
    points: FileName | None = Field(None, description="Matrix Market file of the recovered points, 3 columns")

    def source(self, folder: Path, _mesh: str, _cells: str | None = None, /) -> BodySource:
        """The source of the body from its Matrix Market files."""
        return matrices_source(
            nodes=folder / self.nodes,
            stiffness=folder / self.stiffness,
            mass=folder / self.mass,
            dofs_per_node=self.dofs_per_node,
            damping=None if self.damping is None else folder / self.damping,
            recovery=None if self.recovery is None else folder / self.recovery,
            points=None if self.points is None else folder / self.points,
        )


class Rigid(BodyKind):
    """A rigid body."""

    mass: Positive = Field(description="total mass, a mass")
    centre: Vector = Field(ZERO, description="centre of mass in body axes, a length")
    inertia: Matrix = Field(
        description="inertia tensor about the centre of mass in body axes, 3 rows, mass times length squared"
    )

    def body(self, name: str, places: Mapping[str, np.ndarray]) -> RigidBody:
        """The rigid body.

        places : positions of its interfaces in body axes, by interface name
        """
        return RigidBody(
            name=name,
            mass=self.mass,
            inertia=np.array(self.inertia),
            centre=np.array(self.centre),
            points=places,
        )


class ReducedFile(BodyKind):
    """A body from the file of a reduced body; the value of the key is the file name, not a table."""


class SectionTableFile(ElasticKind):
    """A body of beams or of intrinsic modes from a section table; the value of the key is the file name."""

    has_elements = True

    file: FileName

    def source(self, folder: Path, _mesh: str, _cells: str | None = None, /) -> BodySource:
        """The source of the body: beams between the sections of the table."""
        return section_beams_source(folder / self.file)


KINDS: Mapping[str, type[BodyKind]] = MappingProxyType(
    {
        "shell": Shell,
        "solid": Solid,
        "nastran": Nastran,
        "abaqus": Abaqus,
        "matrices": Matrices,
        "superelement": Superelement,
        "rigid": Rigid,
        "reduced": ReducedFile,
        "section_table": SectionTableFile,
    }
)
"""The kinds by key; the table of a body has exactly one of these keys."""


def kind_of(body: Raw) -> type[BodyKind] | None:
    """The kind of a body, from the first key of `KINDS` in its table; None if there is no such key."""
    return next((kind for key, kind in KINDS.items() if key in body), None)


def is_elastic(body: Raw) -> bool:
    """True for an elastic, not explicit body that the case builds; also if no key states the kind."""
    kind = kind_of(body)
    return (kind is None or kind.is_elastic) and not is_explicit_table(body)


def is_explicit_table(body: Raw) -> bool:
    """True for a body in explicit integration, modal or of finite elements."""
    return "modal" in body or "explicit" in body


def kinds_that(fact: str) -> list[str]:
    """Keys of the kinds with a property, such as `has_elements`."""
    return [key for key, kind in KINDS.items() if getattr(kind, fact)]


def at_elements(
    raw: Raw, given: Iterable[tuple[KeyPath, Raw]], kinds: Mapping[str, tuple[str, str]]
) -> Mistakes:
    """The rule that tables of some kinds refer to node sets of bodies with elements.

    given : path and content of each table
    kinds : by kind of table, two phrases for messages: on a body without elements, and on an interface
    """
    bodies = {str(body.get("name")): body for _, body in tables(raw, "body")}
    for path, each in given:
        name, _, where = str(each.get("at")).partition(".")
        would_be, is_of = kinds.get(str(each.get("kind")), ("", ""))
        if not is_of or name not in bodies:
            continue
        kind = kind_of(bodies[name])
        if kind is not None and not kind.has_elements:
            able = ", ".join(kinds_that("has_elements"))
            yield (
                (*path, "at"),
                f"body {name!r} has no elements {would_be}; give a node set of a body with elements ({able})",
            )
        elif where in names(bodies[name], "interface"):
            yield (
                (*path, "at"),
                f"{where!r} is an interface, but {is_of} elements; give a node set of a body with elements",
            )


def place_exists(raw: Raw, path: KeyPath, place: object, may_be: str) -> Mistakes:
    """The rule that a place exists; a node set can be checked only once the mesh has been read."""
    ground = may_be == "ground"
    if not isinstance(place, str):
        return
    if place == "ground":
        if not ground:
            yield (
                path,
                "ground is not allowed here, only as first end of a joint or spring, or as end of an element",
            )
        return
    bodies = {str(body.get("name")): body for _, body in tables(raw, "body")}
    name, dot, where = place.partition(".")
    if not dot:
        wanted = "ground or BODY.INTERFACE" if ground else "BODY.INTERFACE"
        nearest = nearest_hint(place, ["ground"] if ground else [])
        yield path, f"{place!r} is not {wanted}{nearest}; for example {next(iter(bodies), 'blade')}.root"
    elif name not in bodies:
        yield path, unknown("body", name, list(bodies))
    else:
        body, interfaces = bodies[name], names(bodies[name], "interface")
        kind = kind_of(body)
        may_be_a_set = may_be == "node set" and "mesh" in body and (kind is None or kind.has_elements)
        if "explicit" in body and not may_be_a_set:
            yield path, f"{name!r} {NO_INTERFACES}"
        elif where not in interfaces and not may_be_a_set:
            yield path, unknown(f"interface of {name!r}", where, interfaces)
