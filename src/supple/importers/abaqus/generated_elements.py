"""Elements that a file generates from others: *ELGEN and *ELCOPY."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from supple.arrays import IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.element_types import CELLS, ElementBlock, ElementType, Family
from supple.importers.abaqus.nodes import most_generated
from supple.importers.keyword_file import KeywordFile, fields
from supple.importers.numbering import Labels
from supple.importers.plain_number import is_plain_digits, plain_integer
from supple.mesh import CellType
from supple.mesh.reference_cell import mirrored_order


def generated_elements(
    file: KeywordFile, node_labels: Labels, placed: ScopedBlock, earlier: Sequence[ElementBlock]
) -> list[ElementBlock]:
    """Elements of *ELGEN without masters; a line has a master, then triples of count, node and id step."""
    found = list[ElementBlock]()
    for line, text in placed.block.data:
        words = fields(text)
        if not all(map(is_plain_digits, filter(None, words))):
            raise file.error(line, f"*ELGEN takes whole numbers; got '{text[:40]}'")
        master, *rest = [int(word or 1) for word in words]
        source = next((b for b in earlier if b.scope == placed.scope and master in b.ids), None)
        if source is None:
            raise file.error(line, f"*ELGEN starts from element {master}, which is not above it")
        if source.axis_nodes is not None:
            raise file.error(
                line,
                f"*ELGEN starts from element {master}, a beam with a node for its first axis; write its "
                "elements explicitly",
            )
        nodes = node_labels.ids[source.nodes[source.ids == master]]
        ids = np.array([master])
        steps = [[*rest[i : i + 3], 1, 1][:3] for i in range(0, len(rest), 3)]
        most_generated(file, line, int(np.prod([float(step[0]) for step in steps])))
        for count, node_step, id_step in steps:
            k = np.arange(count)
            nodes = (nodes + node_step * k[:, None, None]).reshape(-1, nodes.shape[1])
            ids = (ids + id_step * k[:, None]).ravel()
        numbers = _numbers(file, line, node_labels, placed, nodes[1:])
        lines = np.full(len(ids) - 1, line)
        name, scope = placed.block.options.get("ELSET"), placed.scope
        found.append(ElementBlock(source.type, scope, 0, ids[1:], numbers, lines, name, master=master))
    return found


def copied_elements(
    file: KeywordFile,
    node_labels: Labels,
    placed: ScopedBlock,
    earlier: Sequence[ElementBlock],
    listed: IntArray,
) -> list[ElementBlock]:
    """Elements of *ELCOPY: those of a set, with shifted ids and nodes; with REFLECT, see `_reflected`.

    listed : ids that *ELSET adds to the old set, besides those of its *ELEMENT keywords
    """
    block = placed.block
    name, by, nodes_by = block.options.get("OLDSET", "").upper(), 0, 0
    try:
        by, nodes_by = (plain_integer(block.options.get(key, "0")) for key in ("ELEMENTSHIFT", "SHIFTNODES"))
    except ValueError:
        name = ""
    if not name:
        raise file.error(block.line, "*ELCOPY takes OLD SET, ELEMENT SHIFT and SHIFT NODES; correct them")
    found = list[ElementBlock]()
    masters = [
        each.master
        for each in earlier
        if each.master is not None and (each.scope, (each.set_name or "").upper()) == (placed.scope, name)
    ]
    listed = np.concatenate([listed, np.array(masters, dtype=np.int64)])
    for source in (each for each in earlier if each.scope == placed.scope):
        whole = (source.set_name or "").upper() == name
        own = np.flatnonzero(np.isin(source.ids, listed) | whole)
        if not own.size:
            continue
        n, given = source.type.n_nodes, source.nodes[own]
        if source.axis_nodes is not None:
            given = np.column_stack([given, source.axis_nodes[own]])
        numbers = _numbers(file, block.line, node_labels, placed, node_labels.ids[given] + nodes_by)
        order = _reflected(source.type) if "REFLECT" in block.options else np.arange(n)
        found.append(
            ElementBlock(
                source.type,
                placed.scope,
                0,
                source.ids[own] + by,
                numbers[:, order],
                np.full(len(own), block.line),
                block.options.get("NEWSET"),
                None if source.axis_nodes is None else numbers[:, n],
            )
        )
    if not found:
        raise file.error(block.line, f"*ELCOPY: there are no elements of set '{name}' above it; correct it")
    return found


def _numbers(file: KeywordFile, line: int, labels: Labels, placed: ScopedBlock, ids: IntArray) -> IntArray:
    """Numbers of the nodes of made elements; ImportFormatError for a node that the file does not define."""
    numbers, known = labels.numbers(placed.scope, ids)
    if not known.all():
        what = f"*{placed.block.key} makes an element with node {ids[~known][0]}"
        raise file.error(line, f"{what}, which the file does not define")
    return numbers


def _reflected(kind: ElementType) -> IntArray:
    """Node order of a reflected element: solids as `mirrored_order`, surfaces reversed, lines unchanged."""
    n = kind.n_nodes
    if kind.family is Family.SOLID:
        order = mirrored_order(CellType[CELLS[n]])
        return order if len(order) == n else np.concatenate([order, np.arange(len(order), n)])
    if kind.family in (Family.BEAM, Family.ROD) or n < 3:
        return np.arange(n)
    corners = 3 if n in (3, 6) else 4
    turned = [0, *range(corners - 1, 0, -1)]
    edges = [corners + edge for edge in range(corners - 1, -1, -1)] if n > corners else []
    return np.array([*turned, *edges, *range(2 * corners, n)])
