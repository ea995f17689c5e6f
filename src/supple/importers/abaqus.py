"""Abaqus and CalculiX input files (.inp): nodes, elements and sets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.errors import ImportFormatError
from supple.importers.file_mesh import CellOrigin, FileMesh, UnusedNodes
from supple.importers.keyword_file import (
    KeywordBlock,
    KeywordFile,
    fields,
    integers,
    numbered_points,
    read_keyword_file,
)
from supple.importers.node_table import NodeTable
from supple.importers.numbering import first_repeated, numbers_of
from supple.importers.plain_number import is_plain_digits
from supple.importers.quadrilateral import CROSSED, crossed_quadrilaterals, split_quadrilaterals
from supple.mesh import CellType, Mesh

__all__ = ["read_abaqus"]

IntArray = NDArray[np.int64]

_CELL_TYPES = {
    "S3": CellType.TRIANGLE3,
    "S3R": CellType.TRIANGLE3,
    "C3D4": CellType.TETRA4,
    "C3D10": CellType.TETRA10,
    "C3D10M": CellType.TETRA10,
    "C3D8": CellType.HEXA8,
    "C3D8I": CellType.HEXA8,
    "C3D8R": CellType.HEXA8,
    "C3D20": CellType.HEXA20,
    "C3D20R": CellType.HEXA20,
}
_QUADRILATERALS = ("S4", "S4R")

# Keywords and options that make or move nodes, elements or sets: to pass over them would read a wrong mesh.
_KEYWORDS_NOT_READ = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM")
# What ties nodes, adds mass or moves the wall away from its nodes: a mesh cannot hold it, matrices do.
_KEYWORDS_BEYOND_A_MESH = (
    "COUPLING", "CYCLIC SYMMETRY MODEL", "DISTRIBUTING COUPLING", "EMBEDDED ELEMENT", "EQUATION", "FASTENER",
    "IMPERFECTION", "KINEMATIC COUPLING", "MODEL CHANGE", "MPC", "NONSTRUCTURAL MASS", "PRE-TENSION SECTION",
    "RELEASE", "RIGID BODY", "SHELL TO SOLID COUPLING", "TIE",
)  # fmt: skip
_SHELL_OPTIONS_BEYOND_A_MESH = ("COMPOSITE", "NODAL THICKNESS", "OFFSET")
_OPTIONS_NOT_READ = {"NODE": ("INPUT", "SYSTEM"), "ELEMENT": ("INPUT", "FILE", "OFFSET"), "NSET": ("ELSET",)}


@dataclass(frozen=True)
class _Nodes:
    """All nodes of a file, in its order, and the sets named beside them."""

    ids: IntArray
    positions: NDArray[np.float64]
    named: list[tuple[str, IntArray]]


@dataclass(frozen=True)
class _ElementBlock:
    """Elements of one *ELEMENT: their ids, node numbers (not ids) and first lines."""

    type_name: str
    set_name: str | None
    ids: IntArray
    nodes: IntArray
    lines: IntArray


@checked_arguments
def read_abaqus(
    path: str | Path, *, only: str | None = None, unused_nodes: UnusedNodes = UnusedNodes.REFUSE
) -> Mesh:
    """Mesh of an Abaqus or CalculiX input file; its materials, sections, supports and steps are passed over.

    Reads *NODE, *ELEMENT (S3, S3R, S4, S4R, C3D4, C3D10, C3D10M, C3D8, C3D8I, C3D8R, C3D20, C3D20R), *NSET
    and *ELSET with GENERATE and sets naming sets, NSET= on *NODE, ELSET= on *ELEMENT, and *INCLUDE. A
    four-node shell becomes two triangles. Set names are compared regardless of case and keep their first
    spelling.

    Parameters
    ----------
    path : str or Path
    only : str or None            a cell set: read it and its nodes alone; None reads everything
    unused_nodes : UnusedNodes    REFUSE or DROP nodes that no element uses
    Returns
    -------
    Mesh   nodes in the order of the file, node sets in the order of their lines
    Raises
    ------
    ImportFormatError   missing or cut file, unknown element type, missing or repeated ids, unknown members;
                        constraints, masses and shell offsets, which a mesh does not have
    MeshError           what the file describes is no usable mesh
    """
    path = Path(path)
    file = read_keyword_file(path)
    _refuse_what_is_not_read(file)
    _refuse_what_is_beyond_a_mesh(file)
    nodes = _read_nodes(file, path)
    blocks = _read_elements(file, path, nodes)

    cells: dict[CellType, list[IntArray]] = {}
    cell_ids: dict[CellType, list[IntArray]] = {}
    origins: dict[CellType, tuple[CellOrigin, ...]] = {}
    for block in blocks:
        is_quad = block.type_name in _QUADRILATERALS
        kind = CellType.TRIANGLE3 if is_quad else _CELL_TYPES[block.type_name]
        cells.setdefault(kind, []).append(
            split_quadrilaterals(nodes.positions, block.nodes) if is_quad else block.nodes
        )
        cell_ids.setdefault(kind, []).append(np.repeat(block.ids, 2) if is_quad else block.ids)
        origins[kind] = origins.get(kind, ()) + _origins(file, block, 2 if is_quad else 1)

    node_sets = _read_sets(file, "NSET", "node", nodes.ids, nodes.named)
    element_ids = np.concatenate([block.ids for block in blocks])
    element_sets = [(block.set_name, block.ids) for block in blocks if block.set_name]
    cell_sets = {
        name: _cells_with_ids(cell_ids, ids)
        for name, ids in _read_sets(file, "ELSET", "element", element_ids, element_sets).items()
    }
    return FileMesh(
        path,
        nodes.positions,
        {kind: np.vstack(parts) for kind, parts in cells.items()},
        {name: numbers_of(nodes.ids, ids)[0] for name, ids in node_sets.items()},
        cell_sets,
        origins,
        nodes.ids,
        {kind: np.concatenate(parts) for kind, parts in cell_ids.items()},
    ).to_mesh(only=only, unused_nodes=unused_nodes)


def read_abaqus_nodes(path: str | Path) -> NodeTable:
    """Labelled nodes and node sets of an Abaqus or CalculiX file, for matrices that replace its elements.

    Raises
    ------
    ImportFormatError   missing or cut file, missing or repeated ids, sets of unknown nodes; *TRANSFORM
    """
    path = Path(path)
    file = read_keyword_file(path)
    _refuse_what_is_not_read(file)
    for block in file.blocks:
        if block.name == "TRANSFORM":
            raise file.error(
                block.line, "*TRANSFORM turns the freedoms of its nodes; export the matrices without it"
            )
    nodes = _read_nodes(file, path)
    sets = _read_sets(file, "NSET", "node", nodes.ids, nodes.named)
    numbered = {name: numbers_of(nodes.ids, ids)[0] for name, ids in sets.items()}
    return NodeTable(str(path), nodes.ids, nodes.positions, node_sets=numbered)


def _refuse_what_is_not_read(file: KeywordFile) -> None:
    parts = instances = 0
    for block in file.blocks:
        if block.name in _KEYWORDS_NOT_READ:
            raise file.error(block.line, f"*{block.name} is not supported; write out what it makes")
        for option in _OPTIONS_NOT_READ.get(block.name, ()):
            if option in block.options:
                raise file.error(
                    block.line, f"*{block.name}, {option}= is not supported; write out what it makes"
                )
        parts += block.name == "PART"
        instances += block.name == "INSTANCE"
        if max(parts, instances) > 1 or (block.name == "INSTANCE" and block.data):
            raise file.error(
                block.line,
                "several or moved parts are not supported; export a flat input file, or one a part",
            )


def _refuse_what_is_beyond_a_mesh(file: KeywordFile) -> None:
    below = ""
    for block in file.blocks:
        if block.name in _KEYWORDS_BEYOND_A_MESH:
            raise file.error(
                block.line,
                f"*{block.name} is not part of a mesh, and without it the body would be another one; make it "
                "an interface, a joint or a body of the machine and remove it, or import the matrices",
            )
        for option in _SHELL_OPTIONS_BEYOND_A_MESH:
            if block.name == "SHELL SECTION" and option in block.options:
                raise file.error(
                    block.line,
                    f"*SHELL SECTION, {option} is not read; mesh the middle surface of an even wall, or "
                    "import the matrices",
                )
        below = (
            block.name if block.name in ("ASSEMBLY", "INSTANCE", "END INSTANCE", "END ASSEMBLY") else below
        )
        if block.name == "NODE" and block.data and below in ("ASSEMBLY", "END INSTANCE"):
            raise file.error(
                block.line,
                "reference points (*NODE below *ASSEMBLY) are not part of the mesh; remove them and their "
                "sets: an interface has a position of its own",
            )


def _read_nodes(file: KeywordFile, path: Path) -> _Nodes:
    blocks = [block for block in file.blocks if block.name == "NODE" and block.data]
    if not blocks:
        raise ImportFormatError(f"{path}: no nodes below a *NODE; is this a mesh file, and whole?")
    found = [numbered_points(file, block) for block in blocks]
    ids = np.concatenate([points.ids for points in found])
    _refuse_repeated(file, "node", ids, np.concatenate([points.lines for points in found]))
    named = [
        (block.options["NSET"], points.ids)
        for block, points in zip(blocks, found, strict=True)
        if "NSET" in block.options
    ]
    return _Nodes(ids, np.vstack([points.positions for points in found]), named)


def _read_elements(file: KeywordFile, path: Path, nodes: _Nodes) -> list[_ElementBlock]:
    blocks = [_read_element_block(file, block, nodes) for block in file.blocks if block.name == "ELEMENT"]
    if not blocks:
        raise ImportFormatError(f"{path}: no elements below an *ELEMENT; is this a mesh file, and whole?")
    ids, lines = (np.concatenate([getattr(block, part) for block in blocks]) for part in ("ids", "lines"))
    _refuse_repeated(file, "element", ids, lines)
    return blocks


def _read_element_block(file: KeywordFile, block: KeywordBlock, nodes: _Nodes) -> _ElementBlock:
    name = block.options.get("TYPE", "").upper()
    if name not in _CELL_TYPES and name not in _QUADRILATERALS:
        known = ", ".join([*_CELL_TYPES, *_QUADRILATERALS])
        raise file.error(block.line, f"unknown element type '{name}'; supported are TYPE={known}")
    if not block.data:
        raise file.error(block.line, "no elements below *ELEMENT; remove it, or is the file cut short?")
    n_nodes = 4 if name in _QUADRILATERALS else _CELL_TYPES[name].n_nodes

    read = integers(file, block)
    starts = np.arange(0, len(read.values), n_nodes + 1)
    run_on = np.flatnonzero(~read.first[starts])
    if run_on.size or len(read.values) % (n_nodes + 1):
        line = int(read.lines[starts[run_on[0] - 1 if run_on.size else -1]])
        raise file.error(
            line,
            f"an element of type {name} is an id and {n_nodes} nodes, on lines of its own; is the file cut "
            "short?",
        )
    rows, lines = read.values.reshape(-1, n_nodes + 1), read.lines[starts]
    numbers, known = numbers_of(nodes.ids, rows[:, 1:])
    if not known.all():
        row, corner = np.argwhere(~known)[0]
        raise file.error(
            int(lines[row]),
            f"element {rows[row, 0]} names node {rows[row, 1 + corner]}, which the file does not define; "
            "add the node, or remove the element",
        )
    if name in _QUADRILATERALS:
        crossed = crossed_quadrilaterals(nodes.positions, numbers)
        if crossed.size:
            raise file.error(int(lines[crossed[0]]), f"element {rows[crossed[0], 0]}: {CROSSED}")
    return _ElementBlock(name, block.options.get("ELSET"), rows[:, 0], numbers, lines)


def _origins(file: KeywordFile, block: _ElementBlock, cells: int) -> tuple[CellOrigin, ...]:
    """The element behind each of its `cells` cells."""
    return tuple(
        CellOrigin(file.lines[line][0], file.lines[line][1], element)
        for element, line in zip(block.ids.tolist(), block.lines.tolist(), strict=True)
        for _ in range(cells)
    )


def _read_sets(
    file: KeywordFile, keyword: str, member: str, known: IntArray, named: list[tuple[str, IntArray]]
) -> dict[str, IntArray]:
    """Ids in each set, `named` ones first, each once and in the order given."""
    spelling: dict[str, str] = {}
    sets: dict[str, IntArray] = {}

    def extend(name: str, ids: IntArray) -> None:
        key = spelling.setdefault(name.upper(), name)
        sets[key] = _each_once(np.concatenate([sets[key], ids]) if key in sets else ids)

    for name, ids in named:
        extend(name, ids)
    for block in file.blocks:
        if block.name != keyword:
            continue
        name = block.options.get(keyword)
        if not name:
            raise file.error(block.line, f"*{keyword} without a name; write *{keyword}, {keyword}=NAME")
        if not block.data:
            raise file.error(
                block.line, f"set '{name}' is empty; list its members, or is the file cut short?"
            )
        earlier = {key: sets[first] for key, first in spelling.items()}
        extend(name, _members(file, block, name, member, known, earlier))
    return sets


def _members(
    file: KeywordFile,
    block: KeywordBlock,
    name: str,
    member: str,
    known: IntArray,
    earlier: dict[str, IntArray],
) -> IntArray:
    """Ids that the data lines of a set name one by one, by range, or by an earlier set."""
    generate = "GENERATE" in block.options
    found: list[IntArray] = []
    for line, text in block.data:
        words = fields(text)
        if generate:
            ids = _generated(file, line, words, len(known))
        else:
            ids = np.concatenate(
                [_member(file, line, word, f"set '{name}'", member, earlier) for word in words]
            )
        unknown = ids[~np.isin(ids, known)]
        if unknown.size:
            raise file.error(
                line,
                f"set '{name}' names {member} {unknown[0]}, which the file does not define; "
                f"add the {member}, or take it out of the set",
            )
        found.append(ids)
    return np.concatenate(found)


def _member(
    file: KeywordFile, line: int, word: str, what: str, member: str, earlier: dict[str, IntArray]
) -> IntArray:
    if is_plain_digits(word):
        return np.array([int(word)], dtype=np.int64)
    if word.upper() not in earlier:
        raise file.error(
            line, f"{what} names '{word}', neither a {member} id nor a set above; define that set first"
        )
    return earlier[word.upper()]


def _generated(file: KeywordFile, line: int, words: list[str], n_known: int) -> IntArray:
    if len(words) not in (2, 3) or not all(map(is_plain_digits, words)):
        raise file.error(line, f"GENERATE takes first, last, step; '{', '.join(words)}' is not that")
    first, last, step = [*map(int, words), 1][:3]
    if step < 1 or last < first:
        raise file.error(
            line, f"GENERATE from {first} to {last} by {step} names nothing; let it count upwards"
        )
    # Among one id more than there are, one is unknown, however long the range.
    count = min((last - first) // step, n_known) + 1
    return first + step * np.arange(count, dtype=np.int64)


def _cells_with_ids(cell_ids: dict[CellType, list[IntArray]], ids: IntArray) -> dict[CellType, IntArray]:
    found = {kind: np.flatnonzero(np.isin(np.concatenate(parts), ids)) for kind, parts in cell_ids.items()}
    return {kind: members for kind, members in found.items() if members.size}


def _each_once(ids: IntArray) -> IntArray:
    return ids[np.sort(np.unique(ids, return_index=True)[1])]


def _refuse_repeated(file: KeywordFile, what: str, ids: IntArray, lines: IntArray) -> None:
    second = first_repeated(ids)
    if second is not None:
        raise file.error(
            int(lines[second]), f"{what} {ids[second]} is defined a second time; renumber or remove it"
        )
