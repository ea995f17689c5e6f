"""Abaqus and CalculiX input decks: a mesh with its sections, clamped and loaded, in a static step; its loads.

The deck serves as a check: run it in one of the two programs and compare the displacements.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TextIO

import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from supple.arrays import IntArray
from supple.body import FlexibleBody
from supple.equations.nodal_load import nodal_forces, prepared
from supple.errors import ModelError
from supple.fem import Anisotropic, FiniteElementModel, HomogeneousSection, Isotropic
from supple.fem.section import Section
from supple.machine import BaseAcceleration, NodalLoad
from supple.machine.laws.time_law import check_law_covers
from supple.machine.system import Load
from supple.mesh import CellType, Mesh
from supple.storage.atomic_write import replacing

__all__ = ["ABAQUS", "CALCULIX", "DeckProgram", "resultant", "static_load", "write_static_deck"]


CLAMPED, LOADED, EVERY_NODE = "SUPPLE_CLAMPED", "SUPPLE_LOADED", "SUPPLE_ALL"
"""Node sets of the deck, in addition to those of the mesh."""

_SOLID_TYPES = {
    CellType.TETRA4: "C3D4",
    CellType.TETRA10: "C3D10",
    CellType.WEDGE6: "C3D6",
    CellType.WEDGE15: "C3D15",
    CellType.HEXA8: "C3D8",
    CellType.HEXA20: "C3D20",
}
# CalculiX reads twenty characters of a number: thirteen digits, a sign, a point and an exponent.
_REAL = "%.13g"
# Numbers per line; both programs read sixteen at most. An element may continue on the next line.
_ON_A_LINE = 16


@dataclass(frozen=True)
class DeckProgram:
    """A program that runs decks, and its element for a shell triangle.

    shell : str             name of the element
    has_midsides : bool     whether the element has a node in the middle of each side
    """

    name: str
    shell: str
    has_midsides: bool


CALCULIX = DeckProgram("CalculiX", "S6", has_midsides=True)
"""The six-node shell is used, as CalculiX's three-node shell is a linear wedge, far too stiff in bending."""

ABAQUS = DeckProgram("Abaqus", "S3", has_midsides=False)


def write_static_deck(
    path: Path | str,
    model: FiniteElementModel,
    loads: ArrayLike,
    clamped: ArrayLike,
    *,
    program: DeckProgram = CALCULIX,
    title: str = "supple",
) -> Path:
    """Write a static step with large displacements (NLGEOM) as an input deck; returns the path.

    Nodes and elements are numbered from 1 in the order of the mesh, one element type after another. In names
    of sets, underscores replace all characters other than letters and digits.

    Parameters
    ----------
    path : Path             ends in .inp
    model : FiniteElementModel      solids, or shells of one material through the thickness
    loads : (N, 3) or (N, 6)        forces, N, and for shells moments, N m, at all nodes; directions are fixed
    clamped : int array (k,)        nodes that are fixed in all degrees of freedom
    program : CALCULIX or ABAQUS    program whose shell element is written; its mid-side nodes are numbered
                                    after the nodes of the mesh

    Raises
    ------
    ModelError          another suffix; springs, ties and constraints of the model; beams and pyramids;
                        laminates given by their A-B-D matrix alone; shells with an offset or an added
                        mass; anisotropic materials, or a separate shear modulus; loads of a wrong shape
                        or not finite; no load; no clamped node, or one out of range
    ResultFileError     the file cannot be written
    """
    path = Path(path)
    if path.suffix != ".inp":
        raise ModelError(f"cannot write {path}: decks are .inp files; end the path in .inp")
    loads, held = np.asarray(loads, dtype=float), np.unique(np.asarray(clamped, dtype=np.int64))
    _check(model, loads, held)
    with replacing(path) as temporary, temporary.open("w", encoding="ascii") as file:
        file.write(f"*HEADING\n{title.encode('ascii', 'replace').decode()}\n")
        sides = _sides(model, program)
        _write_mesh(file, model, program, sides)
        _write_sections(file, model)
        # A side between clamped nodes is clamped.
        middle = model.mesh.n_nodes + np.flatnonzero(np.isin(sides, held).all(axis=1))
        _write_step(file, model.dofs_per_node, loads, np.concatenate([held, middle]))
    return path


def static_load(
    body: FlexibleBody,
    loads: Iterable[Load] = (),
    *,
    time: float = 0.0,
    rotation: ArrayLike = (0.0, 0.0, 0.0),
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> NDArray[np.float64]:
    """Forces and moments on the nodes of a body that is undeformed and at rest, in the axes of its mesh.

    Parameters
    ----------
    loads : NodalLoad           on this body; also base accelerations; laws are evaluated at `time`
    rotation : (3,)             rotation vector of the body, mesh axes to global, rad
    gravity : (3,)              global, m/s^2; its load is the nodal mass matrix of the body times gravity
    Returns
    -------
    float array (N, 3) or (N, 6)    forces, N, and for shells moments, N m

    Raises
    ------
    ModelError      a load on another body; a load at an interface, or a force element: the mesh has no node
                    there; a table that has no value at `time`
    """
    loads = tuple(loads)
    for load in loads:
        if isinstance(load, BaseAcceleration | NodalLoad):
            check_law_covers(load.label, load.law, time)
    bases = [np.asarray(load.law(time)) for load in loads if isinstance(load, BaseAcceleration)]
    turn = Rotation.from_rotvec(np.asarray(rotation, dtype=float)).as_matrix()
    fall = np.zeros((len(body.nodes), body.dofs_per_node))
    fall[:, :3] = (np.asarray(gravity, dtype=float) - sum(bases)) @ turn
    total = (body.nodal_mass @ fall.ravel()).reshape(fall.shape)
    for load in loads:
        if isinstance(load, BaseAcceleration):
            continue
        if not isinstance(load, NodalLoad) or not load.nodes.size:
            raise ModelError(
                f"body '{body.name}': {getattr(load, 'label', type(load).__name__)} acts at an interface, "
                "and a mesh has no node there; give the load a node set"
            )
        if load.body != body.name:
            raise ModelError(
                f"{load.label} acts on body '{load.body}', not on '{body.name}': give the loads of one body"
            )
        forces = nodal_forces(prepared(load), jnp.asarray(body.nodes[load.nodes]), jnp.asarray(turn), time)
        np.add.at(total[:, :3], load.nodes, np.asarray(forces))
    return total


def resultant(model: FiniteElementModel, loads: ArrayLike) -> NDArray[np.float64]:
    """Resultant (6,) of nodal loads (N, 3) or (N, 6): force, and moment about the origin of the mesh."""
    given = np.asarray(loads, dtype=float)
    moments = np.cross(model.mesh.nodes, given[:, :3])
    if given.shape[1] > 3:
        moments = moments + given[:, 3:]
    return np.concatenate([given[:, :3].sum(axis=0), moments.sum(axis=0)])


def _check(model: FiniteElementModel, loads: NDArray[np.float64], held: IntArray) -> None:
    n, d = model.mesh.n_nodes, model.dofs_per_node
    if loads.ndim != 2 or len(loads) != n or loads.shape[1] not in (3, d):
        raise ModelError(
            f"loads have shape {loads.shape}; the model has {n} nodes of {d} degrees of freedom: "
            f"give ({n}, 3) or ({n}, {d})"
        )
    if not np.isfinite(loads).all():
        raise ModelError(
            f"the load on node {np.argmin(np.isfinite(loads).all(axis=1))} is not finite; correct it"
        )
    if not loads.any():
        raise ModelError("no node is loaded, so that all displacements are zero: give a load")
    if not held.size or held[0] < 0 or held[-1] >= n:
        raise ModelError(f"clamped nodes must be numbers from 0 to {n - 1}, at least one")
    # Masses are in the loads, and dashpots have no effect at rest.
    if beside := replace(model.attached, mass=None, damping=None).what:
        raise ModelError(
            f"the {beside} beside the elements cannot be written; leave them out of the model, or write the "
            "body's matrices instead (write_dmig_punch)"
        )
    for section in model.sections:
        for reason in _refusals(section):
            raise ModelError(reason)


def _refusals(section: Section) -> Iterator[str]:
    """Reasons why a section cannot be written, with the remedy."""
    kind, given, matrices = section.cell_type, section.property, "write the body's matrices instead"
    if kind is CellType.LINE2:
        yield (
            "beams cannot be written: CalculiX needs the shape of their section, and only its stiffness "
            f"is known; {matrices} (write_dmig_punch)"
        )
    if kind.dimension == 3 and kind not in _SOLID_TYPES:
        yield (
            f"{kind.name} cells cannot be written: CalculiX has no such element; "
            "mesh with tetrahedra, wedges or hexahedra"
        )
    if isinstance(given, Anisotropic):
        yield f"an anisotropic material cannot be written; {matrices} (write_dmig_punch)"
    if isinstance(given, HomogeneousSection) and (given.offset or given.added_mass):
        yield "a shell section with an offset or an added mass cannot be written; leave them out"
    if isinstance(given, HomogeneousSection | Isotropic) and _material(section).stated_shear_modulus:
        yield "a material with a separate shear modulus cannot be written; leave the shear modulus out"
    if not isinstance(given, HomogeneousSection | Isotropic):
        yield (
            "a laminate cannot be written: *SHELL SECTION, COMPOSITE needs plies, and only the A-B-D "
            f"matrix is known; {matrices} (write_dmig_punch)"
        )


def _sides(model: FiniteElementModel, program: DeckProgram) -> IntArray:
    """Nodes (S, 2) of each side of the shell triangles, once; empty for a shell without mid-side nodes."""
    triangles = model.mesh.cells.get(CellType.TRIANGLE3)
    if triangles is None or not program.has_midsides:
        return np.zeros((0, 2), dtype=np.int64)
    return np.unique(_sides_of(triangles).reshape(-1, 2), axis=0)


def _sides_of(triangles: IntArray) -> IntArray:
    """Nodes (E, 3, 2) of the sides of triangles, the smaller number first."""
    return np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)


def _element_nodes(section: Section, mesh: Mesh, sides: IntArray) -> IntArray:
    """Nodes (E, k) of the elements of a section, mid-side nodes last."""
    nodes = section.nodes(mesh)
    if section.cell_type is not CellType.TRIANGLE3 or not len(sides):
        return nodes
    # Sides are in ascending order of this key.
    key = sides @ [mesh.n_nodes, 1]
    middle = np.searchsorted(key, _sides_of(nodes) @ [mesh.n_nodes, 1])
    return np.column_stack([nodes, mesh.n_nodes + middle])


def _write_mesh(file: TextIO, model: FiniteElementModel, program: DeckProgram, sides: IntArray) -> None:
    mesh = model.mesh
    file.write(f"*NODE, NSET={EVERY_NODE}\n")
    places = np.concatenate([mesh.nodes, mesh.nodes[sides].mean(axis=1)])
    np.savetxt(
        file, np.column_stack([np.arange(1, len(places) + 1), places]), fmt=", ".join(["%d", *3 * [_REAL]])
    )
    sizes = [len(cells) for cells in mesh.cells.values()]
    first = dict(zip(mesh.cells, np.cumsum([1, *sizes[:-1]]).tolist(), strict=True))
    for number, section in enumerate(model.sections, 1):
        kind = _SOLID_TYPES.get(section.cell_type, program.shell)
        kind += "I" if section.has_incompatible_modes else "R" if section.reduced else ""
        file.write(f"*ELEMENT, TYPE={kind}, ELSET={_section_name(number)}\n")
        nodes = _element_nodes(section, mesh, sides)
        rows = np.column_stack([first[section.cell_type] + section.cells, nodes + 1])
        np.savetxt(file, rows, fmt=_numbers_in_lines(rows.shape[1]))
    for name, nodes in zip(_set_names(mesh.node_sets), mesh.node_sets.values(), strict=True):
        _write_set(file, "NSET", name, nodes + 1)
    for name, cells in zip(_set_names(mesh.cell_sets), mesh.cell_sets.values(), strict=True):
        members = [first[kind] + numbers for kind, numbers in cells.items()]
        _write_set(file, "ELSET", name, np.concatenate(members))


def _write_sections(file: TextIO, model: FiniteElementModel) -> None:
    for number, section in enumerate(model.sections, 1):
        material = _material(section)
        file.write(f"*MATERIAL, NAME=SUPPLE_MATERIAL_{number}\n")
        file.write(f"*ELASTIC\n{_REAL % material.youngs_modulus}, {_REAL % material.poissons_ratio}\n")
        file.write(f"*DENSITY\n{_REAL % material.density}\n")
        of = f"ELSET={_section_name(number)}, MATERIAL=SUPPLE_MATERIAL_{number}"
        if isinstance(section.property, HomogeneousSection):
            file.write(f"*SHELL SECTION, {of}\n{_REAL % section.property.thickness}\n")
        else:
            file.write(f"*SOLID SECTION, {of}\n")


def _write_step(file: TextIO, dofs_per_node: int, loads: NDArray[np.float64], held: IntArray) -> None:
    _write_set(file, "NSET", CLAMPED, held + 1)
    _write_set(file, "NSET", LOADED, np.flatnonzero(loads.any(axis=1)) + 1)
    file.write(f"*BOUNDARY\n{CLAMPED}, 1, {dofs_per_node}\n")
    file.write("*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.0\n*CLOAD\n")
    node, freedom = np.nonzero(loads)
    np.savetxt(file, np.column_stack([node + 1, freedom + 1, loads[node, freedom]]), fmt=f"%d, %d, {_REAL}")
    file.write(f"*NODE PRINT, NSET={EVERY_NODE}\nU\n*NODE FILE\nU\n*END STEP\n")


def _write_set(file: TextIO, keyword: str, name: str, members: IntArray) -> None:
    if not members.size:
        return
    file.write(f"*{keyword}, {keyword}={name}\n")
    whole = len(members) // _ON_A_LINE * _ON_A_LINE
    np.savetxt(file, members[:whole].reshape(-1, _ON_A_LINE), fmt="%d", delimiter=", ")
    if whole < len(members):
        np.savetxt(file, members[None, whole:], fmt="%d", delimiter=", ")


def _numbers_in_lines(count: int) -> str:
    """Format of `count` numbers; a comma at the end of a line continues them on the next one."""
    lines = [", ".join(["%d"] * min(_ON_A_LINE, count - at)) for at in range(0, count, _ON_A_LINE)]
    return ",\n".join(lines)


def _section_name(number: int) -> str:
    return f"SUPPLE_SECTION_{number}"


def _set_names(sets: Iterable[str]) -> Iterator[str]:
    """Names that both programs read; a name equal to an earlier one, apart from case, gets a number."""
    taken: set[str] = set()
    for name in sets:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)
        plain = plain if plain[:1].isalpha() else f"SET_{plain}"
        free, count = plain, 1
        while free.upper() in taken:
            count += 1
            free = f"{plain}_{count}"
        taken.add(free.upper())
        yield free


def _material(section: Section) -> Isotropic:
    given = section.property
    if isinstance(given, Isotropic):
        return given
    assert isinstance(given, HomogeneousSection)  # _check refuses all others
    return given.material
