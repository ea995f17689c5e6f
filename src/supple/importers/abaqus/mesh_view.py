"""The mesh of an Abaqus or CalculiX input file, or its nodes only."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import IntArray
from supple.importers.abaqus.deck_model import read_model
from supple.importers.abaqus.element_types import ElementBlock, Family, cells_of, element_type
from supple.importers.abaqus.public_names import public_ids, public_sets
from supple.importers.file_mesh import FileMesh, UnusedNodes, joined
from supple.importers.keyword_file import KeywordFile, read_keyword_file
from supple.importers.node_table import NodeTable
from supple.mesh import Mesh

__all__ = ["read_abaqus"]

# Ties, masses and wall offsets: part of a deck, not of a mesh.
_BEYOND_A_MESH = (
    "COUPLING", "CYCLICSYMMETRYMODEL", "DISTRIBUTINGCOUPLING", "EMBEDDEDELEMENT", "EQUATION", "FASTENER",
    "IMPERFECTION", "KINEMATICCOUPLING", "MODELCHANGE", "MPC", "NONSTRUCTURALMASS", "PRE-TENSIONSECTION",
    "RELEASE", "RIGIDBODY", "SHELLTOSOLIDCOUPLING", "TIE",
)  # fmt: skip
_SHELL_OPTIONS_BEYOND_A_MESH = ("COMPOSITE", "NODALTHICKNESS", "OFFSET")
_MESHED = (Family.SOLID, Family.SHELL, Family.MEMBRANE)
_KNOWN = "S3, S4, S6, S8, M3D3, .., C3D4, C3D5, C3D6, C3D8, C3D10, C3D13, C3D15, C3D20, C3D27 and variants"
_CARRIERS = (Family.PLANE, Family.CARRIER)
_PLANE_STRESS = "CPS"


@checked_arguments
def read_abaqus(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of an Abaqus or CalculiX input file; its materials, sections, supports and steps are ignored.

    Reads nodes, solid, shell and membrane elements, sets and instances as `read_abaqus_deck` does. A
    four-node shell becomes two triangles; a quadratic shell becomes triangles over the nodes on its edges.
    Meshers write named surfaces as plane or surface elements, and lines as trusses without a section: these
    are no cells, and a set of them becomes the set of their nodes, unless a node set has its name. In a mesh
    without solids and shells, plane stress elements are its surface. Set names are compared regardless of
    case and keep their first spelling; members of node sets are in the order of their lines.

    Parameters and errors are those of `read_mesh`; also ImportFormatError for repeated ids, beams, trusses,
    springs, masses, constraints, nonstructural mass and shell offsets.
    """
    path = Path(path)
    file = read_keyword_file(path)
    _refuse_what_is_beyond_a_mesh(file)
    model = read_model(file, strict=True)
    meshed = [block for block in model.elements if block.type.family in _MESHED]
    meshed = meshed or [block for block in model.elements if block.type.name.startswith(_PLANE_STRESS)]
    others = [block for block in model.elements if block not in meshed]
    made = [
        (kind, cells, block, owner)
        for block in meshed
        for kind, cells, owner in cells_of(block.type, block.nodes, model.positions)
    ]
    owner_of = joined((kind, block.first + owner) for kind, _, block, owner in made)
    node_ids, element_ids = public_ids(model)
    node_sets, cell_sets = public_sets(model, model.node_sets), {}
    taken = {name.upper() for name in node_sets}
    for name, members in public_sets(model, model.element_sets).items():
        found = {kind: np.flatnonzero(np.isin(of, members)) for kind, of in owner_of.items()}
        of_others = _nodes_of(others, members)
        if len(of_others) and not any(map(len, found.values())):
            if name.upper() not in taken:
                node_sets[name] = of_others
        else:
            cell_sets[name] = {kind: own for kind, own in found.items() if len(own)}
    # Nodes in the interior of a face or cell of nine or 27 nodes: no cell has them.
    interior = np.zeros(len(model.positions), dtype=bool)
    for block in meshed:
        interior[block.nodes] = True
    whole = FileMesh(
        path,
        model.positions,
        joined((kind, cells) for kind, cells, _, _ in made),
        node_sets,
        cell_sets,
        joined(
            (kind, np.column_stack([block.lines[owner], block.ids[owner]])) for kind, _, block, owner in made
        ),
        node_ids,
        {kind: element_ids[of] for kind, of in owner_of.items()},
        file.place,
    )
    return whole.without_unused(interior).to_mesh(only=only, unused_nodes=unused_nodes)


def _nodes_of(blocks: Sequence[ElementBlock], members: IntArray) -> IntArray:
    """Nodes of those elements of the blocks that are in `members`."""
    rows = [block.nodes[np.isin(block.numbers, members)] for block in blocks]
    return np.unique(np.concatenate([each.ravel() for each in rows])) if rows else np.zeros(0, np.int64)


def read_abaqus_nodes(path: str | Path) -> NodeTable:
    """Labelled nodes and node sets of an Abaqus or CalculiX file, for matrices that replace its elements.

    Raises
    ------
    ImportFormatError   missing or cut file, missing or repeated ids, sets of unknown nodes; *TRANSFORM
    """
    file = read_keyword_file(Path(path))
    for block in file.blocks:
        if block.key == "TRANSFORM":
            raise file.error(
                block.line, "*TRANSFORM rotates the freedoms of its nodes; export the matrices without it"
            )
    model = read_model(file, elements=False, strict=True)
    return NodeTable(
        str(path),
        public_ids(model)[0],
        model.positions,
        node_sets=public_sets(model, model.node_sets),
    )


def _refuse_what_is_beyond_a_mesh(file: KeywordFile) -> None:
    has_sections = any(block.key == "SOLIDSECTION" for block in file.blocks)
    permitted = (*_MESHED, *_CARRIERS) if has_sections else (*_MESHED, *_CARRIERS, Family.ROD)
    for block in file.blocks:
        kind = element_type(block.options.get("TYPE", "").upper())
        if block.key == "ELEMENT" and kind.family is Family.UNKNOWN:
            raise file.error(block.line, f"unknown element type '{kind.name}'; supported are TYPE={_KNOWN}")
        if block.key == "ELEMENT" and kind.family not in permitted:
            raise file.error(
                block.line,
                f"elements of type {kind.name} are not part of a mesh of surfaces and solids; read the file "
                "with its properties (abaqus = {}), or remove them",
            )
        if block.key in _BEYOND_A_MESH:
            raise file.error(
                block.line,
                f"*{block.name} is not part of a mesh, and its absence would change the body; make it "
                "an interface, a joint or a body of the machine and remove it, or import the matrices",
            )
        for option in _SHELL_OPTIONS_BEYOND_A_MESH:
            if block.key == "SHELLSECTION" and option in block.options:
                raise file.error(
                    block.line,
                    f"*SHELL SECTION, {option} is not read; mesh the middle surface of a uniform wall, or "
                    "import the matrices",
                )
