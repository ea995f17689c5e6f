"""Nodes, elements, sets and surfaces of an Abaqus or CalculiX file, numbered over all its instances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.errors import ImportFormatError
from supple.importers.abaqus.assembly import Scope, ScopedBlock, scoped_blocks
from supple.importers.abaqus.element_types import (
    ElementBlock,
    ElementType,
    Family,
    all_faces,
    element_type,
    face_nodes,
)
from supple.importers.abaqus.generated_elements import copied_elements, generated_elements
from supple.importers.abaqus.nodes import NODE_KEYWORDS, each_once, plain_ids, read_nodes
from supple.importers.abaqus.report import Report
from supple.importers.keyword_file import IntegerRows, KeywordBlock, KeywordFile, fields, integers
from supple.importers.numbering import Labels, in_range
from supple.importers.plain_number import is_plain_digits
from supple.importers.quadrilateral import CROSSED, crossed_quadrilaterals


@dataclass(frozen=True, eq=False)
class DeckSurface:
    """A named surface.

    faces : (F, k) node numbers, corners first, one array for each k; edges have k = 2, nodes k = 1
    nodes : nodes of all faces, each once
    of_beams : whether it has elements of beams
    """

    name: str
    faces: tuple[IntArray, ...]
    nodes: IntArray
    of_beams: bool = False


@dataclass(eq=False)
class AbaqusModel:
    """Definitions of a file; sets and surfaces by scope and name in upper case.

    unsorted : node sets whose nodes are in the order of the file when paired (UNSORTED)

    Ids may repeat in different scopes; `Labels` find the number of an id in its scope.
    """

    file: KeywordFile
    report: Report
    scopes: tuple[Scope, ...]
    blocks: tuple[ScopedBlock, ...]
    nodes: Labels
    positions: FloatArray
    elements: tuple[ElementBlock, ...] = ()
    element_labels: Labels = field(default_factory=lambda: Labels(np.empty(0, int), np.empty(0, int)))
    node_sets: dict[tuple[int, str], tuple[str, IntArray]] = field(default_factory=dict)
    element_sets: dict[tuple[int, str], tuple[str, IntArray]] = field(default_factory=dict)
    surfaces: dict[tuple[int, str], DeckSurface] = field(default_factory=dict)
    unsorted: set[tuple[int, str]] = field(default_factory=set)

    def named(self, *keys: str) -> Iterator[ScopedBlock]:
        """Keywords of these names outside steps; each is counted in `report.read`."""
        for placed in self.blocks:
            if placed.block.key in keys and not placed.step:
                self.report.read[placed.block.name] += 1
                yield placed

    def nodes_of(self, scope: int, word: str, line: int, what: str) -> IntArray:
        """Numbers of the nodes that a word names: an id or set, also of an instance, as in A.12, A.SET.

        An unknown word is recorded as a doubt and gives no node.
        """
        return self._members(scope, word, line, what, "a node")

    def paired_nodes_of(self, scope: int, word: str, line: int, what: str) -> IntArray:
        """As `nodes_of`, in the order in which Abaqus pairs the nodes of sets: by id, unless UNSORTED."""
        found = self.nodes_of(scope, word, line, what)
        meanings = self._meanings(scope, word.strip('"').upper())
        if next((key for key in meanings if key in self.node_sets), None) in self.unsorted:
            return found
        return found[np.lexsort([self.nodes.ids[found], self.nodes.scopes[found]])]

    def elements_of(self, scope: int, word: str, line: int, what: str) -> IntArray:
        """Numbers of the elements that a word names, in the forms of `nodes_of`."""
        return self._members(scope, word, line, what, "an element")

    def surface(self, scope: int, name: str) -> DeckSurface | None:
        """The surface of that name; None without one."""
        return next(
            (self.surfaces[key] for key in self._meanings(scope, name.upper()) if key in self.surfaces), None
        )

    def positions_of_elements(self, numbers: IntArray) -> Iterator[tuple[ElementBlock, IntArray]]:
        """The blocks that contain these elements, and the indices of the elements in each block."""
        for block in self.elements:
            places = numbers[(numbers >= block.first) & (numbers < block.first + len(block.ids))]
            if places.size:
                yield block, np.unique(places - block.first)

    def nodes_of_elements(self, numbers: IntArray) -> IntArray:
        """Numbers of the nodes of these elements, each once."""
        found = [block.nodes[places].ravel() for block, places in self.positions_of_elements(numbers)]
        return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *found]))

    def nodes_of_families(self, *families: Family) -> BoolArray:
        """Mask (N,) of the nodes of elements of these families."""
        found = np.zeros(len(self.positions), dtype=bool)
        for block in self.elements:
            if block.type.family in families:
                found[block.nodes] = True
        return found

    def _meanings(self, scope: int, name: str) -> Iterator[tuple[int, str]]:
        """Keys that a name can have: in this scope, in an instance, in the model or the only instance."""
        yield scope, name
        instance, dot, rest = name.partition(".")
        for number, other in enumerate(self.scopes):
            if dot and other.name.upper() == instance:
                yield number, rest
        if scope:
            yield 0, name
        elif len(self.scopes) == 2:
            yield 1, name

    def _members(self, scope: int, word: str, line: int, what: str, kind: str) -> IntArray:
        of_nodes, member = kind == "a node", kind.split()[1]
        labels = self.nodes if of_nodes else self.element_labels
        sets = self.node_sets if of_nodes else self.element_sets
        for place, name in self._meanings(scope, word.strip('"').upper()):
            if (place, name) in sets:
                return sets[place, name][1]
            if is_plain_digits(name):
                numbers, known = labels.numbers(place, np.array([int(name)]))
                if known[0]:
                    return numbers
        if is_plain_digits(word):
            self.report.doubt(
                line,
                f"{what} names {member} {word}, which the file does not define; add the {member}, or remove "
                "it from the set",
            )
        else:
            self.report.doubt(
                line,
                f"{what} names '{word}', neither {kind} id nor a set above; define that set first",
            )
        return np.empty(0, dtype=np.int64)


def read_model(file: KeywordFile, *, elements: bool = True, strict: bool = False) -> AbaqusModel:
    """Nodes, elements, sets and surfaces of a file.

    elements : False: nodes and their sets only, for matrices that replace the elements
    strict : whether doubts raise ImportFormatError (see `Report`)

    Raises
    ------
    ImportFormatError   no nodes or elements; elements with unknown nodes; words instead of numbers; if
                        strict, also repeated ids and sets with unknown members
    """
    report = Report(file, strict=strict)
    scopes, blocks = scoped_blocks(file, report)
    found = read_nodes(file, scopes, blocks)
    if not len(found.ids):
        restart = [
            each.block for each in blocks if each.block.key == "RESTART" and "READ" in each.block.options
        ]
        if restart:
            message = "it continues with another analysis (*RESTART, READ); give the file of that one"
            raise file.error(restart[0].line, message)
        raise ImportFormatError(f"{file.path}: no nodes below a *NODE; is this a mesh file, and complete?")
    kept = _last_definitions(report, "node", Labels(found.scopes, found.ids), found.lines)
    nodes = Labels(found.scopes[kept], found.ids[kept])
    model = AbaqusModel(file, report, scopes, blocks, nodes, found.positions[kept])
    for _ in model.named(*NODE_KEYWORDS):
        pass
    if elements:
        _read_elements(model)
    for scope, name, ids in found.named:
        _extend(model.node_sets, scope, name, model.nodes.numbers(scope, ids)[0])
    for block in model.elements:
        if block.set_name:
            first = np.array([] if block.master is None else [block.master], dtype=np.int64)
            members = np.concatenate([model.element_labels.numbers(block.scope, first)[0], block.numbers])
            _extend(model.element_sets, block.scope, block.set_name, members)
    for placed in model.named("NSET", "ELSET") if elements else model.named("NSET"):
        _read_set(model, placed, with_elements=elements)
    if elements:
        for placed in model.named("SURFACE"):
            _read_surface(model, placed)
    return model


# --- elements


def _read_elements(model: AbaqusModel) -> None:
    file, found = model.file, list[ElementBlock]()
    for placed in model.named("ELEMENT", "ELGEN", "ELCOPY"):
        block = placed.block
        if {"INPUT", "FILE", "OFFSET"} & block.options.keys():
            raise file.error(
                block.line,
                f"*{block.name} of that kind is not supported; write the data explicitly",
            )
        kind = element_type(block.options.get("TYPE", "").upper())
        if block.key == "ELGEN":
            made = generated_elements(file, model.nodes, placed, found)
        elif block.key == "ELCOPY":
            made = copied_elements(file, model.nodes, placed, found, _listed_elements(model, placed))
        elif kind.family is Family.UNKNOWN:
            model.report.leave_out(
                f"*ELEMENT, TYPE={kind.name}",
                block.line,
                "elements of this type are missing",
                len(block.data),
            )
            continue
        elif not block.data:
            raise file.error(block.line, "no elements below *ELEMENT; remove it, or is the file cut short?")
        else:
            made = [_written_elements(model, placed, kind)]
        found += made
    if found:
        ids, lines = (np.concatenate([getattr(block, part) for block in found]) for part in ("ids", "lines"))
        scopes = np.concatenate([np.full(len(block.ids), block.scope) for block in found])
        kept = _last_definitions(model.report, "element", Labels(scopes, ids), lines)
        model.element_labels = Labels(scopes[kept], ids[kept])
        model.elements = tuple(_numbered(found, kept))
    elif not model.report.left_out:
        raise ImportFormatError(
            f"{file.path}: no elements below an *ELEMENT; is this a mesh file, and complete?"
        )


def _listed_elements(model: AbaqusModel, copied: ScopedBlock) -> IntArray:
    """Ids in the *ELSET keywords of the old set above an *ELCOPY; elements have no numbers at this stage."""
    name = copied.block.options.get("OLDSET", "").upper()
    found = [np.empty(0, dtype=np.int64)]
    for placed in model.blocks:
        if placed is copied:
            break
        block = placed.block
        if (block.key, placed.scope) == ("ELSET", copied.scope) and block.options.get(
            "ELSET", ""
        ).upper() == name:
            found.append(plain_ids(block))
    return np.concatenate(found)


def _numbered(blocks: list[ElementBlock], kept: BoolArray) -> Iterator[ElementBlock]:
    """The blocks with the elements of the mask `kept` only, numbered consecutively."""
    start = first = 0
    for block in blocks:
        mine = kept[start : start + len(block.ids)]
        start += len(block.ids)
        axis = None if block.axis_nodes is None else block.axis_nodes[mine]
        yield replace(
            block,
            first=first,
            ids=block.ids[mine],
            nodes=block.nodes[mine],
            lines=block.lines[mine],
            axis_nodes=axis,
        )
        first += int(np.count_nonzero(mine))


def _written_elements(model: AbaqusModel, placed: ScopedBlock, kind: ElementType) -> ElementBlock:
    file, name = model.file, kind.name
    block, scopes = _with_plain_ids(model, placed)
    read = integers(file, block)
    n = kind.n_nodes
    # A beam may have one more node, towards which its first axis points.
    per_line = np.flatnonzero(np.append(read.first, True))
    if kind.family is Family.BEAM and (np.diff(per_line) == n + 2).all():
        n += 1
    places = _rows_of_elements(model, read, n + 1, name)
    rows, lines = read.values[places], read.lines[places[:, 0]]
    numbers, known = model.nodes.numbers(placed.scope, rows[:, 1:])
    for scope in np.unique(scopes).tolist() if len(scopes) else ():
        own = scopes[places[:, 1:]] == scope
        numbers[own], known[own] = model.nodes.numbers(scope, rows[:, 1:][own])
    if not known.all():
        row, corner = np.argwhere(~known)[0]
        raise file.error(
            int(lines[row]),
            f"element {rows[row, 0]} names node {rows[row, 1 + corner]}, which the file does not define; "
            "add the node, or remove the element",
        )
    if kind.family in (Family.SHELL, Family.MEMBRANE) and n == 4:
        crossed = crossed_quadrilaterals(model.positions, numbers)
        if crossed.size:
            raise file.error(int(lines[crossed[0]]), f"element {rows[crossed[0], 0]}: {CROSSED}")
    return ElementBlock(
        kind,
        placed.scope,
        0,
        rows[:, 0],
        numbers[:, : kind.n_nodes],
        lines,
        block.options.get("ELSET"),
        numbers[:, kind.n_nodes] if n > kind.n_nodes else None,
    )


def _with_plain_ids(model: AbaqusModel, placed: ScopedBlock) -> tuple[KeywordBlock, IntArray]:
    """The block without names of instances, and the scope of each of its numbers; empty if it names none.

    Elements outside of instances, such as springs between them, name nodes as INSTANCE.ID.
    """
    block = placed.block
    if placed.scope or not any("." in text for _, text in block.data):
        return block, np.empty(0, dtype=np.int64)
    known = {each.name.upper(): number for number, each in enumerate(model.scopes) if number}
    data, scopes = list[tuple[int, str]](), list[int]()
    for line, text in block.data:
        words = fields(text)
        for i, word in enumerate(words):
            instance, _, own = word.rpartition(".")
            scopes.append(known.get(instance.strip('"').upper(), 0))
            words[i] = own if scopes[-1] else word
        data.append((line, ", ".join(words)))
    return replace(block, data=tuple(data)), np.array(scopes)


def _rows_of_elements(model: AbaqusModel, read: IntegerRows, width: int, name: str) -> IntArray:
    """Places (E, width) in `read` of the numbers of each element.

    An element begins on a new line; numbers after its last node are a doubt, since CalculiX does not read
    them.
    """
    values, lines = read.values, read.lines
    starts = np.arange(0, len(values), width)
    if len(values) % width or not read.first[starts].all():
        ends = np.append(np.flatnonzero(read.first)[1:], len(values))
        kept, start, line_end = list[int](), 0, 0
        while start < len(values):
            line_end = ends[np.searchsorted(ends, start + width)] if start + width <= len(values) else 0
            beyond = line_end - start - width
            if beyond < 0 or beyond >= width:
                raise model.file.error(
                    int(lines[start]),
                    f"an element of type {name} is an id and {width - 1} nodes, on separate lines; is the "
                    "file cut short?",
                )
            if beyond:
                model.report.doubt(
                    int(lines[start]),
                    f"an element of type {name} is an id and {width - 1} nodes; {beyond} more numbers "
                    "are not read; correct the type of the element, or remove these numbers",
                )
            kept.append(start)
            start = int(line_end)
        starts = np.array(kept)
    return starts[:, None] + np.arange(width)


def _last_definitions(report: Report, what: str, labels: Labels, lines: IntArray) -> BoolArray:
    """Mask of the valid definitions: the last one of each id, as in both programs; repetitions are doubts."""
    order = np.lexsort([labels.ids, labels.scopes])
    same = np.diff(labels.ids[order]) == 0
    same &= np.diff(labels.scopes[order]) == 0
    kept = np.ones(len(order), dtype=bool)
    kept[order[:-1][same]] = False
    again = order[1:][same]
    if again.size:
        second = again.min()
        report.doubt(
            int(lines[second]),
            f"{what} {labels.ids[second]} is defined a second time; renumber or remove it",
        )
    return kept


# --- sets


def _extend(
    sets: dict[tuple[int, str], tuple[str, IntArray]], scope: int, name: str, members: IntArray
) -> None:
    spelling, earlier = sets.get((scope, name.upper()), (name, members[:0]))
    sets[scope, name.upper()] = spelling, each_once(np.concatenate([earlier, members]))


def _read_set(model: AbaqusModel, placed: ScopedBlock, *, with_elements: bool) -> None:
    file, block = model.file, placed.block
    of_nodes = block.key == "NSET"
    name, options = block.options.get(block.key), block.options
    if not name:
        raise file.error(block.line, f"*{block.name} without a name; write *{block.name}, {block.name}=NAME")
    sets = model.node_sets if of_nodes else model.element_sets
    find = model.nodes_of if of_nodes else model.elements_of
    scope, what = _scope_of_members(model, placed), f"set '{name}'"
    key = placed.scope, name.upper()
    if of_nodes and "UNSORTED" in options and key not in sets:
        model.unsorted.add(key)
    if of_nodes and "ELSET" in options:
        members = np.empty(0, dtype=np.int64)
        if with_elements:
            members = model.nodes_of_elements(model.elements_of(scope, options["ELSET"], block.line, what))
        _extend(sets, placed.scope, name, members)
        return
    if not block.data:
        model.report.doubt(block.line, f"set '{name}' is empty; list its members, or is the file cut short?")
        return
    labels = model.nodes if of_nodes else model.element_labels
    found: list[IntArray] = []
    for line, text in block.data:
        words = fields(text)
        if "GENERATE" in options:
            found.append(_generated_members(model, line, words, labels, scope, what, of_nodes=of_nodes))
        elif all(map(is_plain_digits, words)):
            ids = np.array([int(word) for word in words], dtype=np.int64)
            numbers, known = labels.numbers(scope, ids)
            found.append(numbers[known])
            if not known.all():
                find(scope, str(ids[~known][0]), line, what)
        else:
            found += [find(scope, word, line, what) for word in words if word]
    _extend(sets, placed.scope, name, np.concatenate(found))


def _scope_of_members(model: AbaqusModel, placed: ScopedBlock) -> int:
    """The scope that INSTANCE of a set names.

    An unknown name is an error in a file with instances or parts, else a doubt.
    """
    name, known = placed.block.options.get("INSTANCE"), [each.name.upper() for each in model.scopes]
    if name is None or name.upper() in known:
        return placed.scope if name is None else known.index(name.upper())
    message = f"no instance '{name}'; correct its name"
    model.report.doubt(placed.block.line, message)
    if len(known) > 1:
        raise model.file.error(placed.block.line, message)
    return placed.scope


def _generated_members(
    model: AbaqusModel, line: int, words: list[str], labels: Labels, scope: int, what: str, *, of_nodes: bool
) -> IntArray:
    """Numbers of the existing ids from first to last by step; a missing id is a doubt."""
    file = model.file
    if len(words) not in (2, 3) or not all(map(is_plain_digits, words)):
        raise file.error(line, f"GENERATE takes first, last, step; got '{', '.join(words)}'")
    first, last, step = [*map(int, words), 1][:3]
    if step < 1 or last < first:
        raise file.error(
            line, f"GENERATE from {first} to {last} by {step} is an empty range; use an ascending one"
        )
    mine = labels.of(scope)
    ids = labels.ids[mine]
    listed = range(first, last + 1, step)
    inside = mine[in_range(ids, listed)]
    if len(inside) < len(listed):
        known, find = set(ids.tolist()), model.nodes_of if of_nodes else model.elements_of
        find(scope, str(next(number for number in listed if number not in known)), line, what)
    return inside[np.argsort(labels.ids[inside], kind="stable")]


# --- surfaces


def _read_surface(model: AbaqusModel, placed: ScopedBlock) -> None:
    block, scope = placed.block, placed.scope
    name = block.options.get("NAME", "")
    kind = block.options.get("TYPE", "ELEMENT").upper()
    what = f"surface '{name}'"
    faces: dict[int, list[IntArray]] = {}
    of_beams = False
    if kind not in ("ELEMENT", "NODE") or "COMBINE" in block.options or "CROP" in block.options:
        model.report.note(f"surface '{name}' of type {kind} is not read")
        return
    for line, text in block.data:
        word, label = [*fields(text), ""][:2]
        if kind == "NODE":
            faces.setdefault(1, []).append(model.nodes_of(scope, word, line, what)[:, None])
            continue
        members = model.elements_of(scope, word, line, what)
        shared = None if label else _shared_faces(model, members)
        for elements, places in model.positions_of_elements(members):
            of_beams |= elements.type.family is Family.BEAM
            for face in _faces(elements, places, label.upper()):
                exposed = face
                if shared is not None and elements.type.family is Family.SOLID:
                    exposed = face[~np.isin(_face_keys(face), shared)]
                if len(exposed):
                    faces.setdefault(face.shape[1], []).append(exposed)
    by_size = tuple(np.concatenate(each) for each in faces.values())
    nodes = np.concatenate([np.empty(0, dtype=np.int64), *(each.ravel() for each in by_size)])
    model.surfaces[scope, name.upper()] = DeckSurface(name, by_size, each_once(nodes), of_beams)


def _faces(elements: ElementBlock, places: IntArray, label: str) -> list[IntArray]:
    """Faces (F, k) of some elements of a block by label; without a label, all faces."""
    nodes, kind = elements.nodes[places], elements.type
    whole_line = kind.family in (Family.BEAM, Family.ROD)
    if label or whole_line:
        face = face_nodes(kind, label)
        if len(face) == 3 and kind.family is not Family.SOLID and (kind.n_nodes != 3 or whole_line):
            # An edge of three nodes is two segments; beams and rods list its middle node between the ends.
            a, b, c = face if whole_line else (face[0], face[2], face[1])
            return [nodes[:, [a, b]], nodes[:, [b, c]]]
        return [nodes[:, face]] if face else []
    return [nodes[:, face] for face in all_faces(kind)]


def _shared_faces(model: AbaqusModel, members: IntArray) -> NDArray:
    """Keys of the faces that two solids of the model share, among the faces on the nodes of some elements."""
    near = np.zeros(len(model.positions), dtype=bool)
    near[model.nodes_of_elements(members)] = True
    keys = [_face_keys(np.empty((0, 3), dtype=np.int64))]
    for elements in model.elements:
        if elements.type.family is Family.SOLID:
            faces = [elements.nodes[:, face] for face in all_faces(elements.type)]
            keys += [_face_keys(each[near[each].all(axis=1)]) for each in faces]
    found, count = np.unique(np.concatenate(keys), return_counts=True)
    return found[count > 1]


def _face_keys(faces: IntArray) -> NDArray:
    """A key for each face (F, k) from its different nodes, in any order: equal for equal faces."""
    keys = np.full((len(faces), 8), -1, dtype=np.int64)
    keys[:, : faces.shape[1]] = faces
    keys.sort(axis=1)
    keys[:, 1:][np.diff(keys, axis=1) == 0] = -1
    keys.sort(axis=1)
    return keys.view([("", np.int64)] * 8).ravel()
