"""Element types of Abaqus and CalculiX: family, nodes, faces and cells."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.quadrilateral import split_quadratic_surfaces, split_quadrilaterals
from supple.mesh import CellType
from supple.mesh.reference_cell import mirrored_order


class Family(Enum):
    """Role of an element in a body."""

    SOLID = auto()
    SHELL = auto()
    MEMBRANE = auto()
    BEAM = auto()
    ROD = auto()
    SPRING = auto()
    DASHPOT = auto()
    MASS = auto()
    ROTARY_INERTIA = auto()
    PLANE = auto()
    """Two-dimensional elements: beside solids and shells they only define sets."""
    CARRIER = auto()
    """Elements without stiffness and mass: surface and rigid elements, DCOUP3D."""
    UNKNOWN = auto()


_WITH_EDGES = (Family.SHELL, Family.MEMBRANE, Family.CARRIER, Family.PLANE)
CELL_FAMILIES = (Family.SOLID, Family.SHELL, Family.MEMBRANE, Family.BEAM, Family.ROD)


@dataclass(frozen=True)
class ElementType:
    """A type of elements. n_nodes : nodes on a data line; 0 for unknown types, which are not read"""

    name: str
    family: Family
    n_nodes: int

    @property
    def shears(self) -> bool:
        """Whether a shell or beam has transverse shear; Kirchhoff and Euler-Bernoulli elements have none."""
        return not re.fullmatch(r"STRI.*|S\dR5|[BP].*33.*", self.name)


_BY_ORDER = {"1": 2, "2": 3, "3": 2}
_WORDS = {"MASS": 1, "ROTARYI": 1, "DCOUP3D": 1, "65": 6, "A": 2}
# Pattern of names, family, and number of nodes by the matched word; a word not listed is the number itself.
_PATTERNS: tuple[tuple[str, Family, dict[str, int]], ...] = (
    (r"C3D(4|5|6|8|10|13|15|20|27)[A-Z]*", Family.SOLID, {}),
    (r"SC([68])R?T?", Family.SOLID, {}),
    (r"S([34])[A-Z]*5?|STRI(3|65)|S(6)|S(8)R?5?T?|S(9)R5", Family.SHELL, _WORDS),
    (r"M3D([34689])R?", Family.MEMBRANE, {}),
    (r"(?:B|PIPE)3([123])[A-Z]*", Family.BEAM, _BY_ORDER),
    (r"T3D([23])[A-Z]*", Family.ROD, {}),
    (r"SPRING([12A])", Family.SPRING, _WORDS),
    (r"DASHPOT([12A])", Family.DASHPOT, _WORDS),
    (r"(MASS)", Family.MASS, _WORDS),
    (r"(ROTARYI)", Family.ROTARY_INERTIA, _WORDS),
    (r"(?:CPS|CPE|CPEG|CAX|CGAX)(10|3|4|6|8)[A-Z]*|T2D([23])[A-Z]*", Family.PLANE, {}),
    (r"(?:B2|PIPE2|SAX|MAX)([123])[A-Z]*", Family.PLANE, _BY_ORDER),
    (r"SFM3D([3468])R?|R3D([34])|RB3D(2)|(DCOUP3D)", Family.CARRIER, _WORDS),
)

CELLS = {
    4: "TETRA4", 5: "PYRAMID5", 6: "WEDGE6", 8: "HEXA8", 10: "TETRA10", 13: "PYRAMID13", 15: "WEDGE15",
    20: "HEXA20", 27: "HEXA20",
}  # fmt: skip
"""Types of solid cells by their number of nodes; of 27 nodes the last 7 (in faces, inside) are dropped."""

# Corners of the faces S1, S2, .. of solids, by the number of corners of the solid.
_FACES = {
    4: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    5: ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    6: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    8: ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
}


def element_type(name: str) -> ElementType:
    """The type of that name (in upper case), for any integration rule; UNKNOWN if unsupported."""
    for pattern, family, n_nodes in _PATTERNS:
        match = re.fullmatch(pattern, name)
        if match:
            word = next(word for word in match.groups() if word)
            return ElementType(name, family, n_nodes[word] if word in n_nodes else int(word))
    return ElementType(name, Family.UNKNOWN, 0)


@dataclass(frozen=True, eq=False)
class ElementBlock:
    """Elements of one keyword.

    first : number of its first element in the file;  ids : (E,);  nodes : (E, n) node numbers
    lines : (E,) indices of `KeywordFile.lines`;  set_name : the set of ELSET or NEW SET
    axis_nodes : (E,) for beams, a node towards which their first axis points; None if not given
    master : id of an element above it that is in its set as well; None without one
    """

    type: ElementType
    scope: int
    first: int
    ids: IntArray
    nodes: IntArray
    lines: IntArray
    set_name: str | None = None
    axis_nodes: IntArray | None = None
    master: int | None = None

    @property
    def numbers(self) -> IntArray:
        """Numbers (E,) of the elements among all elements of the file."""
        return self.first + np.arange(len(self.ids))


def cells_of(
    kind: ElementType, nodes: IntArray, positions: FloatArray
) -> Iterator[tuple[CellType, IntArray, IntArray]]:
    """Cell type, cells (C, k) and element index (C,) of each cell, of elements (E, n) of one type.

    Shells become triangles, a quadratic beam two lines. Eight-node hexahedra with repeated nodes become
    wedges, pyramids or tetrahedra, or are omitted if these have no volume. Other solids keep their repeated
    nodes, which cause a MeshError later. Triangles with repeated nodes are omitted.
    """
    if kind.family is Family.SOLID and kind.n_nodes == 8:
        ordered = np.sort(nodes, axis=1)
        whole = (np.diff(ordered, axis=1) != 0).all(axis=1)
        if whole.any() or not len(nodes):
            yield CellType.HEXA8, nodes[whole], np.flatnonzero(whole)
        simpler: dict[CellType, list[tuple[IntArray, int]]] = {}
        for element in np.flatnonzero(~whole).tolist():
            cell, made = _collapsed_hexahedron(nodes[element], positions)
            if len(made):
                simpler.setdefault(cell, []).append((made, element))
        for cell, found in simpler.items():
            yield cell, np.array([row for row, _ in found]), np.array([element for _, element in found])
        return
    yield _cells_of_one_kind(kind, nodes, positions)


def _collapsed_hexahedron(row: IntArray, positions: FloatArray) -> tuple[CellType, IntArray]:
    """The cell of a hexahedron with repeated nodes: without nodes if it has no volume, HEXA8 if none fits."""
    distinct = list(dict.fromkeys(row.tolist()))
    faces = [list(dict.fromkeys(row[list(face)].tolist())) for face in _FACES[8]]
    if len(distinct) == 6:
        triangles = [face for face in faces if len(face) == 3]
        pairs = [(a, b) for a in triangles for b in triangles if not set(a) & set(b)]
        if not pairs:
            return CellType.HEXA8, row
        bottom, top = pairs[0]
        edges = {frozenset((int(row[i]), int(row[j]))) for i, j in CellType.HEXA8.edges}
        top = [b for a in bottom for b in top if frozenset((a, b)) in edges]
        if len(top) != 3:
            return CellType.HEXA8, row
        nodes, kind = [*bottom, *top], CellType.WEDGE6
    elif len(distinct) == 5 and any(len(face) == 4 for face in faces):
        base = next(face for face in faces if len(face) == 4)
        nodes, kind = [*base, *(set(distinct) - set(base))], CellType.PYRAMID5
    elif len(distinct) == 4:
        nodes, kind = distinct, CellType.TETRA4
    else:
        return CellType.HEXA8, row[: 8 if len(distinct) > 3 else 0]
    x = positions[nodes]
    height = np.cross(x[1] - x[0], x[2] - x[0]) @ (x[-1] - x[0])
    made = np.array(nodes)
    return kind, (made if height > 0 else made[mirrored_order(kind)]) if height else made[:0]


def _cells_of_one_kind(
    kind: ElementType, nodes: IntArray, positions: FloatArray
) -> tuple[CellType, IntArray, IntArray]:
    if kind.family is Family.SOLID:
        cell = CellType[CELLS[kind.n_nodes]]
        return cell, nodes[:, : cell.n_nodes], np.arange(len(nodes))
    if kind.family in (Family.BEAM, Family.ROD):
        pairs = np.array([[0, 1]] if kind.n_nodes == 2 else [[0, 1], [1, 2]])
        return CellType.LINE2, nodes[:, pairs].reshape(-1, 2), np.repeat(np.arange(len(nodes)), len(pairs))
    if kind.n_nodes == 3:
        cells = nodes
    elif kind.n_nodes == 4:
        cells = split_quadrilaterals(positions, nodes)
    else:
        cells = split_quadratic_surfaces(positions, nodes[:, : 8 if kind.n_nodes == 9 else kind.n_nodes])
    owners = np.repeat(np.arange(len(nodes)), len(cells) // max(len(nodes), 1))
    whole = (cells != np.roll(cells, 1, axis=1)).all(axis=1)
    return CellType.TRIANGLE3, cells[whole], owners[whole]


def face_nodes(kind: ElementType, label: str) -> tuple[int, ...]:
    """Indices in an element of the nodes of a face: corners, then mid-edge nodes; empty for other labels.

    label : S1 .. S6 of solids; SPOS, SNEG, S1, S2 of shells, whose edges are E1 .. in Abaqus and S3 .. in
            CalculiX; edges S1 .. of two-dimensional elements; END1, END2 of beams and trusses: the end node;
            any other for beams and trusses: all nodes
    """
    match = re.fullmatch(r"([SE])([1-6])", label)
    is_edge, number = (match[1] == "E", int(match[2])) if match else (False, 0)
    if kind.family is Family.SOLID:
        cell = CellType[CELLS[kind.n_nodes]]
        faces = _FACES[cell.n_corners]
        if is_edge or not 0 < number <= len(faces):
            return ()
        return (*faces[number - 1], *cell.middles(faces[number - 1]))
    if kind.family in (Family.BEAM, Family.ROD) and label in ("END1", "END2"):
        return (0 if label == "END1" else kind.n_nodes - 1,)
    if kind.family not in _WITH_EDGES or kind.n_nodes < 3:
        return tuple(range(kind.n_nodes))
    corners = 3 if kind.n_nodes in (3, 6) else 4
    n = min(kind.n_nodes, 8)
    if number and (is_edge or kind.family is Family.PLANE):
        edge = number - 1
    elif number > 2:
        edge = number - 3
    else:
        return tuple(range(n)) if number or label in ("SPOS", "SNEG", "") else ()
    return (edge, (edge + 1) % corners, *([corners + edge] if n > corners else [])) if edge < corners else ()


def all_faces(kind: ElementType) -> tuple[tuple[int, ...], ...]:
    """Indices as of `face_nodes` for all faces of an element, also those that another element shares."""
    labels = [""]
    if kind.family is Family.SOLID:
        labels = [f"S{i + 1}" for i in range(len(_FACES[CellType[CELLS[kind.n_nodes]].n_corners]))]
    return tuple(face_nodes(kind, label) for label in labels)
