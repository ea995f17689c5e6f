"""Finite-element model: a mesh with its quadratic-strain elements, mass and linear stiffness."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from supple.arguments import check_instance
from supple.errors import ModelError, SuppleWarning
from supple.fem.attached import Attached
from supple.fem.attached_parts import attached_parts, point_masses
from supple.fem.beam2 import BeamLine, beam_line, beam_mass, beam_strain
from supple.fem.beam_section import BeamSection, LineSection, RodSection
from supple.fem.coarse_curvature import warn_of_coarse_curvature
from supple.fem.mass import CellMass, consistent_mass, nodal_mass_matrix, shell_mass
from supple.fem.material import Anisotropic, Isotropic
from supple.fem.node_sparsity import cell_nodes, full_cells, node_sparsity
from supple.fem.quadratic_strain import QuadraticStrain, stiffness
from supple.fem.rod2 import rod_mass, rod_strain
from supple.fem.section import Section, sections
from supple.fem.shell_kinematics import GREEN_LAGRANGE, ShellKinematics
from supple.fem.shell_section import HomogeneousSection, LaminateSection, ShellSection
from supple.fem.shell_triangle import shell_triangle
from supple.fem.solid_element import SOLID_ELEMENTS, solid_element, solid_mass, solid_rotation, solid_strain
from supple.mesh import CellType, DividedMesh, Mesh, MeshPart
from supple.mesh.facet_curvature import facet_curvature

__all__ = [
    "FiniteElementModel",
    "cell_masses",
    "finite_element_model",
    "isotropic_materials",
    "lumped_mass",
    "nodal_rotation_operator",
    "node_masses",
    "parts_of_model",
    "refuse_attached",
    "shell_model",
    "solid_model",
]

MassRule = Callable[[CellMass], CellMass]

CELLS_AT_ONCE = 4096
"""Number of elements whose stiffness is in memory at one time: some 100 MB for quadratic solids."""


@dataclass(frozen=True, eq=False)
class FiniteElementModel:
    """A mesh with its elements.

    Parameters
    ----------
    dofs_per_node : int                     3 (ux uy uz), or 6 (and rx ry rz) if any element has nodal
        rotations
    sections : tuple of Section             each: cells of one type with one material or section
    mass : csc_array (n, n)                 mass of the cells and concentrated masses, kg and kg m^2
    stiffness : csc_array (n, n)            tangent stiffness of the undeformed body
    rotation_limit : float                  largest rotation, rad, relative to the frame for which the
        kinematics are valid; infinite if no element has nodal rotations
    kinematics : ShellKinematics            strain of shells and beams; solids have Green-Lagrange strain
    attached : Attached                     springs, masses, dashpots and ties at nodes
    mass_of : MassRule                      mass of the cells: consistent_mass, or CellMass.lumped
    """

    mesh: Mesh
    dofs_per_node: int
    sections: tuple[Section, ...]
    mass: csc_array
    stiffness: csc_array
    rotation_limit: float
    kinematics: ShellKinematics = GREEN_LAGRANGE
    attached: Attached = field(default_factory=Attached)
    mass_of: MassRule = consistent_mass

    @property
    def n_dofs(self) -> int:
        """Number of nodal freedoms n."""
        return self.mesh.n_nodes * self.dofs_per_node

    @cached_property
    def blocks(self) -> tuple[QuadraticStrain, ...]:
        """The elements of each section, created on first use; a linear body never needs them."""
        return tuple(
            _block(self.mesh, section, self.kinematics, self.dofs_per_node) for section in self.sections
        )

    @property
    def strains(self) -> tuple[QuadraticStrain, ...]:
        """The strains of the elements, then of the springs."""
        springs = self.attached.springs
        return (*self.blocks, *springs) if springs else self.blocks

    @property
    def strains_vanish_in_rotation(self) -> bool:
        """Whether a rigid rotation about any axis has no second-order strain; False for von Karman strain."""
        return self.kinematics.gradients == GREEN_LAGRANGE.gradients


def shell_model(
    mesh: Mesh,
    section: ShellSection | LineSection | Mapping[str, ShellSection | LineSection],
    *,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
) -> FiniteElementModel:
    """Model of a mesh of triangles as a flat-faceted shell, and of its lines as beams.

    Parameters
    ----------
    mesh : Mesh                         of TRIANGLE3 and LINE2 cells
    section : ShellSection for triangles, LineSection for lines; or {cell set: section}, with every cell in
        exactly one set
    kinematics : ShellKinematics        GREEN_LAGRANGE, or VON_KARMAN for flat structures

    Raises
    ------
    ModelError   a cell that is neither a triangle nor a line; a cell without a section, with two, or with a
                 section for another type of cell; a shell thicker than the size of the mesh; a beam parallel
                 to the vector that orients its section
    MeshError    a cell set that the mesh does not have
    Warns
    -----
    SuppleWarning   a shell thicker than five times the median side of its triangles; a doubly curved shell
                    whose triangles are too large for its thickness
    """
    expected = "GREEN_LAGRANGE or VON_KARMAN of supple.fem"
    check_instance("shell_model, kinematics", kinematics, ShellKinematics, expected)
    given = sections(mesh, section)
    for each in given:
        _check_shell(mesh, each)
    return _model(mesh, 6, given, kinematics)


def solid_model(
    mesh: Mesh, material: Isotropic | Anisotropic | Mapping[str, Isotropic | Anisotropic]
) -> FiniteElementModel:
    """Model of a mesh of solid cells as a solid of finite (Green-Lagrange) strain.

    Parameters
    ----------
    mesh : Mesh                     of solid cells, linear or quadratic, also mixed
    material : Isotropic or Anisotropic; or {cell set: material}, with every cell in exactly one set

    Raises
    ------
    ModelError   a cell that is not a solid; a cell without a material, or with two; a property that is not a
                 material
    MeshError    a cell set that the mesh does not have
    """
    given = sections(mesh, material)
    for each in given:
        _check_solid(each)
    return _model(mesh, 3, given)


def finite_element_model(
    mesh: Mesh,
    given: tuple[Section, ...],
    *,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
    attached: Attached | None = None,
    dofs_per_node: int | None = None,
    mass_of: MassRule = consistent_mass,
) -> FiniteElementModel:
    """Model of a mesh of solids, shells and beams together, and of their attachments.

    Parameters
    ----------
    given : the sections of all cells
    kinematics : of shells and beams
    attached : springs, masses, dashpots and ties at nodes; each node has `dofs_per_node` freedoms
    dofs_per_node : 3 or 6; by default 6 if a section has stiffness in nodal rotations, otherwise 3
    mass_of : mass of a cell: consistent_mass, or CellMass.lumped

    Raises
    ------
    ModelError   as for `shell_model` and `solid_model`
    """
    for section in given:
        (_check_solid if section.cell_type.dimension == 3 else partial(_check_shell, mesh))(section)
    d = dofs_per_node or (6 if any(section.turns_nodes() for section in given) else 3)
    return _model(mesh, d, given, kinematics, attached or Attached(), mass_of)


def parts_of_model(model: FiniteElementModel, divided: DividedMesh) -> tuple[FiniteElementModel, ...]:
    """The finite-element model of each part of the model's mesh, with its own mass and stiffness.

    Each spring, mass or tie belongs to the first part that contains all of its nodes.

    divided : `model.mesh` in parts
    Raises ModelError for a spring, mass, dashpot, tie or constraint whose nodes are not all in one part.
    """
    nodes = [part.nodes for part in divided.parts]
    beside = attached_parts(model.attached, nodes, model.mesh.node_ids, model.dofs_per_node)
    return tuple(
        finite_element_model(
            part.mesh,
            tuple(made for section in model.sections if len((made := _in_part(section, part)).cells)),
            kinematics=model.kinematics,
            attached=own,
            dofs_per_node=model.dofs_per_node,
            mass_of=model.mass_of,
        )
        for part, own in zip(divided.parts, beside, strict=True)
    )


def _in_part(section: Section, part: MeshPart) -> Section:
    whole = part.cells.get(section.cell_type, np.empty(0, dtype=np.int64))
    own = np.flatnonzero(np.isin(whole, section.cells))
    order = np.argsort(section.cells)
    return section.of(order[np.searchsorted(section.cells, whole[own], sorter=order)], own)


def cell_masses(model: FiniteElementModel) -> tuple[CellMass, ...]:
    """Consistent mass of the cells of each section, not assembled; then the concentrated masses.

    Raises ModelError for a concentrated mass that couples several nodes.
    """
    beside = point_masses(model.attached, model.dofs_per_node)
    cells = (_cell_mass(model.mesh, section) for section in model.sections)
    return (*cells, *(() if beside is None else (beside,)))


def lumped_mass(model: FiniteElementModel) -> NDArray[np.float64]:
    """Diagonal mass (n,) of the nodal freedoms, kg and kg m^2; its total is that of the consistent mass.

    Raises ModelError as for `node_masses`.
    """
    masses = tuple(_cell_mass(model.mesh, section).lumped() for section in model.sections)
    diagonal = nodal_mass_matrix(masses, model.mesh.n_nodes, model.dofs_per_node).diagonal()
    diagonal.reshape(model.mesh.n_nodes, -1)[:, :3] += node_masses(model)[:, None]
    return diagonal


def node_masses(model: FiniteElementModel) -> NDArray[np.float64]:
    """Concentrated mass (N,) of each node, kg.

    Raises ModelError for a mass with rotary inertia, with a centre beside its node, with different values in
    different directions, or at several nodes.
    """
    found = np.zeros(model.mesh.n_nodes)
    beside = point_masses(model.attached, model.dofs_per_node)
    if beside is None or beside.coupled is None:
        return found
    own = beside.coupled[:, 0, 0]
    plain = own[:, None, None] * np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    other = np.abs(beside.coupled - plain).max(axis=(1, 2)) > 1e-12 * np.abs(own)
    if other.any():
        node = model.mesh.node_ids[beside.nodes[other][0, 0]]
        raise ModelError(
            f"the concentrated mass at node {node} (one of {np.count_nonzero(other)}) has rotary "
            "inertia, a centre beside its node or different values by direction: give the mass alone, or use "
            "a body in a floating frame"
        )
    found[beside.nodes[:, 0]] = own
    return found


def isotropic_materials(model: FiniteElementModel) -> set[Isotropic]:
    """Isotropic materials of solids, beams, rods, and of shells with one material through the thickness."""
    given = [section.property for section in model.sections]
    of_material = HomogeneousSection | BeamSection | RodSection
    made_of = [own.material if isinstance(own, of_material) else own for own in given]
    return {material for material in made_of if isinstance(material, Isotropic)}


def refuse_attached(attached: Attached, what: str) -> None:
    """Raise ModelError if there are attachments; `what` names the feature that does not support them."""
    if attached.what:
        raise ModelError(
            f"{what} supports no {attached.what} beside its elements; leave them out of the model, or use a "
            "body in a floating frame"
        )


def _check_shell(mesh: Mesh, section: Section) -> None:
    given = section.property
    if section.cell_type is CellType.LINE2:
        if not isinstance(given, LineSection | RodSection):
            raise ModelError(f"lines need a BeamSection, not {type(given).__name__}; give their cell set one")
        return
    if section.cell_type is not CellType.TRIANGLE3:
        raise ModelError(
            f"a shell model takes TRIANGLE3 cells; the mesh has {section.cell_type.name}. "
            "Use solid_model for solid cells"
        )
    if not isinstance(given, HomogeneousSection | LaminateSection):
        raise ModelError(
            f"a shell needs a wall, not {type(given).__name__}: HomogeneousSection(material, thickness)"
        )
    if isinstance(given, HomogeneousSection):
        _check_thickness(mesh, section, given.thickness)


def _check_solid(section: Section) -> None:
    if section.cell_type not in SOLID_ELEMENTS:
        raise ModelError(
            f"a solid model takes {', '.join(kind.name for kind in SOLID_ELEMENTS)} cells; the mesh has "
            f"{section.cell_type.name}. Use shell_model for triangles"
        )
    if not isinstance(section.property, Isotropic | Anisotropic):
        raise ModelError(
            f"a solid needs an Isotropic or Anisotropic material, not {type(section.property).__name__}"
        )


def _block(mesh: Mesh, section: Section, kinematics: ShellKinematics, dofs_per_node: int) -> QuadraticStrain:
    """The elements of a checked section."""
    given, corners, nodes = section.property, section.corners(mesh), section.nodes(mesh)
    if isinstance(given, LineSection):
        line = line_of(mesh, section)
        return beam_strain(line, nodal_freedoms(nodes, 6), given, kinematics, section.released)
    if isinstance(given, RodSection):
        own = None if section.turns_nodes() else 3
        return rod_strain(corners, nodal_freedoms(nodes, dofs_per_node, own), given)
    if isinstance(given, Isotropic | Anisotropic):
        return solid_strain(
            solid_element(section.cell_type, reduced=section.reduced, incompatible=section.incompatible),
            corners,
            nodal_freedoms(nodes, dofs_per_node, 3),
            given,
            section.directions,
        )
    dofs = nodal_freedoms(nodes, 6)
    return shell_triangle(corners, dofs, given, kinematics, section.directions, section.surface_curvature)


def line_of(mesh: Mesh, section: Section) -> BeamLine:
    """Axes of the beams of a section."""
    assert isinstance(section.property, LineSection)
    return beam_line(section.corners(mesh), section.property, section.directions, section.offsets)


def _portions(given: tuple[Section, ...]) -> Iterator[Section]:
    """The sections, each in portions of at most `CELLS_AT_ONCE` cells."""
    for section in given:
        for first in range(0, len(section.cells), CELLS_AT_ONCE):
            yield section.of(slice(first, first + CELLS_AT_ONCE))


def _model(
    mesh: Mesh,
    d: int,
    given: tuple[Section, ...],
    kinematics: ShellKinematics = GREEN_LAGRANGE,
    attached: Attached = Attached(),  # noqa: B008 (it is immutable)
    mass_of: MassRule = consistent_mass,
) -> FiniteElementModel:
    """The model of checked sections, with d freedoms for each node."""
    given = _on_their_surface(mesh, given)
    cells = [section.nodes(mesh) for section in given]
    sparsity = node_sparsity(
        [*cells, *(cell_nodes(spring.dofs, d) for spring in attached.springs)], mesh.n_nodes, d
    )
    elements = (_block(mesh, portion, kinematics, d) for portion in _portions(given))
    matrices = (full_cells(stiffness(block), block.dofs, d) for block in chain(elements, attached.springs))
    mass = nodal_mass_matrix(tuple(mass_of(_cell_mass(mesh, each)) for each in given), mesh.n_nodes, d)
    turns = any(section.turns_nodes() for section in given)
    return FiniteElementModel(
        mesh=mesh,
        dofs_per_node=d,
        sections=given,
        mass=mass if attached.mass is None else csc_array(mass + attached.mass),
        stiffness=sparsity.matrix(sparsity.data_of_portions(matrices)),
        rotation_limit=kinematics.rotation_limit if turns else float("inf"),
        kinematics=kinematics,
        attached=attached,
        mass_of=mass_of,
    )


def _on_their_surface(mesh: Mesh, given: tuple[Section, ...]) -> tuple[Section, ...]:
    """The sections, with surface curvatures of shells, if not given, from neighbouring triangles."""
    shells = [section for section in given if section.cell_type is CellType.TRIANGLE3]
    if all(section.surface_curvature is not None for section in shells):
        return given
    warn_of_coarse_curvature(mesh, shells)
    cells = np.concatenate([section.cells for section in shells])
    found = np.zeros((len(mesh.cells[CellType.TRIANGLE3]), 3, 3))
    found[cells] = facet_curvature(mesh.nodes, mesh.cells[CellType.TRIANGLE3][cells])
    return tuple(
        replace(section, surface_curvature=found[section.cells])
        if section in shells and section.surface_curvature is None and found[section.cells].any()
        else section
        for section in given
    )


def _cell_mass(mesh: Mesh, section: Section) -> CellMass:
    corners, nodes = section.corners(mesh), section.nodes(mesh)
    if isinstance(section.property, LineSection):
        return beam_mass(line_of(mesh, section), nodes, section.property)
    if isinstance(section.property, RodSection):
        return rod_mass(corners, nodes, section.property)
    if isinstance(section.property, Isotropic | Anisotropic):
        element = SOLID_ELEMENTS[section.cell_type]
        return CellMass(nodes, solid_mass(element, corners, section.property.density))
    return shell_mass(corners, nodes, section.property, section.mass_share)


def nodal_freedoms(
    nodes: NDArray[np.int64], dofs_per_node: int, first: int | None = None
) -> NDArray[np.int64]:
    """Numbers (E, k d) of the d freedoms of each of the nodes (E, k), node by node.

    first : d, if only the first freedoms of a node are wanted; by default all
    """
    own = np.arange(dofs_per_node if first is None else first)
    return (nodes[:, :, None] * dofs_per_node + own).reshape(len(nodes), -1)


def nodal_rotation_operator(model: FiniteElementModel) -> csc_array:
    """Operator (3 P, n) that gives the rotation vector at P points from the nodal freedoms.

    Shells, beams and rods with torsion: the rotational freedoms of their nodes. Solids: half the curl of u at
    the centre of each cell. Other rods: none.
    """
    d = model.dofs_per_node
    rotation, row, column = [np.empty(0)], [np.empty(0, int)], [np.empty(0, int)]
    n_rows = 0
    if d == 6:
        sheets = [section.nodes(model.mesh) for section in model.sections if section.turns_nodes()]
        turning = (
            np.unique(np.concatenate([nodes.ravel() for nodes in sheets])) if sheets else np.empty(0, int)
        )
        n_rows = 3 * len(turning)
        rotation, row = [np.ones(n_rows)], [np.arange(n_rows)]
        column = [(6 * turning[:, None] + np.arange(3, 6)).ravel()]
    for section in model.sections:
        if section.cell_type not in SOLID_ELEMENTS:
            continue
        values = solid_rotation(SOLID_ELEMENTS[section.cell_type], section.corners(model.mesh))
        dofs = nodal_freedoms(section.nodes(model.mesh), d, 3)
        rows = n_rows + np.arange(values.shape[0] * 3).reshape(-1, 3)
        rotation.append(values.ravel())
        row.append(np.broadcast_to(rows[:, :, None], values.shape).ravel())
        column.append(np.broadcast_to(dofs[:, None], values.shape).ravel())
        n_rows += rows.size
    entries = (np.concatenate(rotation), (np.concatenate(row), np.concatenate(column)))
    return coo_array(entries, shape=(n_rows, model.n_dofs)).tocsc()


def _check_thickness(mesh: Mesh, section: Section, thickness: float) -> None:
    """Check the wall thickness, which is often given in millimetres for a mesh in metres.

    ModelError if the thickness exceeds the diagonal of the mesh's bounding box; SuppleWarning if it exceeds
    five times the median side of the triangles.
    """
    corners = section.corners(mesh)
    extent = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
    width = float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))
    if thickness > extent:
        raise ModelError(
            f"wall thickness {thickness:g} exceeds the size of the whole mesh, {extent:g}: "
            "use the same unit of length for both"
        )
    if thickness > 5 * width:
        warnings.warn(
            f"wall thickness {thickness:g} is {thickness / width:.0f} times the size of its elements, "
            f"{width:g}: check that both are in the same unit of length; if they are, use solid elements",
            SuppleWarning,
            stacklevel=4,
        )
